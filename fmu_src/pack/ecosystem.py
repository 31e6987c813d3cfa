"""Files for other tools, made from an FMU: SSP with parameter sets, cross-check files, FMI-LS-REF.

`python -m fmu_src.pack.ecosystem FMU FOLDER` writes NAME_in.csv, NAME_ref.csv and NAME_ref.opt for an FMU of this
project and, for the platoon, Platoon.ssp, scenario1.ssv and scenario2.ssv.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from fmpy import read_model_description, simulate_fmu

from psp_model import ModelError, simulate
from psp_model.selection.network import ParameterNetwork
from psp_model.selection.selectors import select_for

from ..interface.meaning import constants_of, request_of, sampling_of, start_of, weights_of
from ..interface.variables import Variable
from .ssp import (
    SCENARIOS,
    STOP_TIME,
    System,
    SystemComponent,
    parameter_connectors,
    parameter_set,
    parameters_of,
    with_values,
    write_ssp,
    xml_file,
)

_LS = "http://fmi-standard.org/fmi-ls-manifest"
LS_REF = "extra/org.fmi-standard.fmi-ls-ref"
STEP_SIZE = 0.01  # [s]


def scenario_values(table: Sequence[Variable], scenario: str) -> dict[str, float]:
    """All parameters of a scenario: the table's, with the values that the scenario changes.

    Parameters
    ----------
    table : the variables
    scenario : name in SCENARIOS
    """
    found = {}
    for row in table:
        if row.causality == "parameter" and row.start is not None:
            value = SCENARIOS[scenario].get(row.name, row.start)
            found[row.name] = int(value) if row.integer else float(value)
    return found


def parameter_files(table: Sequence[Variable]) -> dict[str, bytes]:
    """scenario1.ssv and scenario2.ssv by name (SSP 1.0 parameter sets).

    Parameters
    ----------
    table : the variables
    """
    return _parameter_files({name: scenario_values(table, name) for name in SCENARIOS})


def _parameter_files(sets: Mapping[str, Mapping[str, float]]) -> dict[str, bytes]:
    return {f"{name}.ssv": xml_file(parameter_set(name, values)) for name, values in sets.items()}


def _scenario_sets(fmu: Path) -> dict[str, dict[str, float]]:
    parameters = parameters_of(fmu)
    return {name: with_values(parameters, changed) for name, changed in SCENARIOS.items()}


def write_platoon_ssp(fmu: Path, path: Path) -> Path:
    """A flat .ssp with one component, its parameters and outputs: scenario1.ssd, scenario2.ssd; the latter by default.

    Parameters
    ----------
    fmu : the platoon
    path : of the .ssp
    """
    sets = _scenario_sets(fmu)
    # fmpy cannot run a system that leaves an input unconnected
    outputs = {row.name: ("output", row.type) for row in _variables(fmu, "output")}
    platoon = SystemComponent(fmu, parameter_connectors(parameters_of(fmu)) | outputs, sets)
    system = System(path.stem, {"platoon": platoon}, step_size=STEP_SIZE)
    return write_ssp(path, system, "scenario2", tuple(SCENARIOS), _parameter_files(sets))


def _variables(fmu: Path, causality: str) -> list[Any]:
    model = read_model_description(str(fmu), validate=False)
    return [row for row in model.modelVariables if row.causality == causality]


def _csv(names: Sequence[str], rows: Any, number: str = "%.17g") -> str:
    text = StringIO()
    text.write(",".join(f'"{name}"' for name in names) + "\n")
    np.savetxt(text, rows, delimiter=",", fmt=number)
    return text.getvalue()


def shown_outputs(names: Sequence[str]) -> list[str]:
    """The outputs that a reference result shows, 10 at most: of the first vehicle and the last, and reports.

    Parameters
    ----------
    names : of all outputs
    """
    n = max((int(name[2:-1]) for name in names if name.startswith(("a[", "v["))), default=1)
    wanted = [f"x[{n}]", "v", "v[1]", f"v[{n}]", "a[1]", f"a[{n}]", "s[2]", f"s[{n}]", "T_max"]
    wanted += ["J_acceleration", "J_gap"] if "J" in names else ["alpha", "input_ok"]
    return [name for name in dict.fromkeys(wanted) if name in names]


def write_cross_check(fmu: Path, folder: Path) -> list[Path]:
    """The three files of the FMI project's cross-check for the default start: all inputs, up to 10 outputs, options.

    Inputs keep their start values, so that it does not matter how a tool interpolates between rows.  An FMU without
    inputs has no NAME_in.csv, which is optional: fmuCheck cannot read one with time alone.

    Parameters
    ----------
    fmu : an FMU of this project
    folder : where they go

    Returns
    -------
    the files
    """
    inputs = {row.name: float(row.start) for row in _variables(fmu, "input")}
    names = shown_outputs([row.name for row in _variables(fmu, "output")])
    given = np.array([[time, *inputs.values()] for time in (0.0, STOP_TIME)])
    columns = np.array([tuple(row) for row in given], dtype=[(name, float) for name in ("time", *inputs)])
    step = {"step_size": STEP_SIZE, "output_interval": 0.1}
    result = simulate_fmu(str(fmu), stop_time=STOP_TIME, output=names, input=columns if inputs else None, **step)
    rows = np.column_stack([result[name] for name in ("time", *names)])
    options = {"StartTime": 0.0, "StopTime": STOP_TIME, "StepSize": STEP_SIZE, "RelTol": 1e-6}
    contents = {"in.csv": _csv(["time", *inputs], given)} if inputs else {}
    contents |= {
        "ref.csv": _csv(["time", *names], rows),
        "ref.opt": "".join(f"{name},{value!r}\n" for name, value in options.items()),
    }
    paths = [folder / f"{fmu.stem}_{ending}" for ending in contents]
    for path, content in zip(paths, contents.values(), strict=True):
        path.write_text(content, encoding="utf-8")
    return paths


def layered_standard(table: Sequence[Variable], references: Mapping[str, str]) -> dict[str, bytes]:
    """FMI-LS-REF: the manifest, the experiments, their parameter sets and reference results, by name in the FMU.

    Parameters
    ----------
    table : the variables
    references : CSV text by scenario
    """
    manifest = Element("fmiReferences", {"xmlns:fmi-ls": _LS, "fmi-ls:fmi-ls-name": "org.fmi-standard.fmi-ls-ref"})
    manifest.set("fmi-ls:fmi-ls-version", "1.0.0-alpha.1")
    about = "Layered Standard providing information on related files included in an FMU."
    manifest.set("fmi-ls:fmi-ls-description", about)
    experiments = Element("Experiments", name="The paper's scenarios")
    times = {"startTime": "0.0", "stopTime": repr(STOP_TIME), "stepSize": repr(STEP_SIZE)}
    found = {f"{LS_REF}/{name}": content for name, content in parameter_files(table).items()}

    def related(source: str, role: str, kind: str) -> None:
        SubElement(manifest, "Related", type=kind, source=source, role=role)

    related("experiments.xml", "experiment", "application/xml")
    for name, text in references.items():
        experiment = SubElement(experiments, "Experiment", {"name": name} | times)
        SubElement(experiment, "Parameters", source=f"{name}.ssv")
        SubElement(experiment, "References", source=f"{name}_ref.csv")
        related(f"{name}.ssv", "parameter", "application/x-ssp-parameter-set")
        related(f"{name}_ref.csv", "result", "text/csv")
        found[f"{LS_REF}/{name}_ref.csv"] = text.encode()
    found[f"{LS_REF}/experiments.xml"] = xml_file(experiments)
    return found | {f"{LS_REF}/fmi-ls-manifest.xml": xml_file(manifest)}


def reference_results(table: Sequence[Variable], network: ParameterNetwork | None) -> dict[str, str]:
    """The results of both scenarios, from psp_model and without FMI: CSV text by scenario, a row every 0.1 s.

    Parameters
    ----------
    table : the variables
    network : for this number of vehicles, None if there is none

    Returns
    -------
    CSV text by scenario; a scenario that Lemma 1 does not certify for this number of vehicles is left out
    """
    found = {}
    for name in SCENARIOS:
        values = scenario_values(table, name)
        n, read = sum(key.startswith("v_start[") for key in values), values.__getitem__
        rows = {row.name: row for row in table}
        weights, sampling = weights_of(read), sampling_of(read, rows)
        start = start_of(read, n, constants_of(read))
        shape = select_for(start, request_of(read, rows), network, weights, sampling).potential
        try:
            run = simulate(start, shape, weights=weights, sampling=sampling, duration=STOP_TIME, output_step=0.1)
        except ModelError:
            continue
        names = ["time", f"x[{n}]", "v[1]", f"v[{n}]", f"a[{n}]", "s[2]", f"s[{n}]", "T_max", "J"]
        columns = [run.time, run.x[:, -1], run.v[:, 0], run.v[:, -1], run.a[:, -1], run.s[:, 0], run.s[:, -1]]
        found[name] = _csv(names, np.column_stack([*columns, run.T_max, run.cost.sum(axis=1)]), "%.10g")
    return found


def main(fmu: Path, folder: Path) -> list[Path]:
    """Write everything for an FMU and print what was written."""
    folder.mkdir(parents=True, exist_ok=True)
    written = write_cross_check(fmu, folder)
    if any(row.name == "J" for row in _variables(fmu, "output")):  # the platoon is a system by itself
        written.append(write_platoon_ssp(fmu, folder / "Platoon.ssp"))
        for name, content in _parameter_files(_scenario_sets(fmu)).items():
            written.append(folder / name)
            written[-1].write_bytes(content)
    print(*written, sep="\n")
    return written


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
