"""The report's tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from psp_model.analysis.cases import Case, figures
from psp_model.analysis.certificate import largest_certified_period

from .provenance import constants_table

_MOST_STRETCHES = 4  # stretches of uncertified instants that are listed


def table(head: Sequence[str], rows: Sequence[Sequence[str]], classes: Sequence[str] = (), name: str = "") -> str:
    """An HTML table; the first column holds headings.

    Parameters
    ----------
    head : cells of the first line, as text
    rows : cells, as text
    classes : class of each column, "" for none
    name : id of the table, "" for none
    """
    classes = [*classes, *[""] * len(head)]
    top = "".join(
        f"<th scope='col'{f' class={kind!r}' if kind else ''}>{escape(cell)}</th>"
        for cell, kind in zip(head, classes, strict=False)
    )
    body = []
    for first, *others in rows:
        cells = "".join(
            f"<td{f' class={kind!r}' if kind else ''}>{escape(cell)}</td>"
            for cell, kind in zip(others, classes[1:], strict=False)
        )
        body.append(f"<tr><th scope='row'>{escape(first)}</th>{cells}</tr>")
    identity = f" id={name!r}" if name else ""
    return f"<table{identity}><thead><tr>{top}</tr></thead><tbody>{''.join(body)}</tbody></table>"


def summary(cases: Sequence[Case]) -> str:
    """The figures of each run side by side.

    Parameters
    ----------
    cases : the runs
    """
    rows = []
    for line in zip(*(figures(case) for case in cases), strict=True):
        unit = "" if line[0].unit == "1" else f" [{line[0].unit}]"
        rows.append([line[0].label + unit, *(f"{figure.value:.6g}" for figure in line)])
    return table(["", *(case.name for case in cases)], rows, name="summary")


def warnings(cases: Sequence[Case]) -> str:
    """The model's sentences, run by run.

    Parameters
    ----------
    cases : the runs
    """
    sentences = [f"{case.name}: {sentence}" for case in cases for sentence in case.warnings]
    return "".join(f"<p class='warning'>{escape(sentence)}</p>" for sentence in sentences)


def certificate(cases: Sequence[Case]) -> str:
    """The result of Lemma 1 for each run.

    Parameters
    ----------
    cases : the runs
    """
    head = [
        "run",
        "T [s]",
        "certified throughout",
        f"smallest {cases[0].certificate.bound if cases else 'T_max'} [s]",
        "at t [s]",
        "set by",
        "not certified",
        "largest T that holds throughout [s]",
    ]
    rows = []
    for case in cases:
        found = case.certificate
        k = found.tightest
        stretches = [f"{begin:.4g} to {end:.4g} s" for begin, end in found.refused()]
        if len(stretches) > _MOST_STRETCHES:
            stretches[_MOST_STRETCHES:] = [f"and {len(stretches) - _MOST_STRETCHES} more"]
        setup = case.setup
        law, chosen, until = setup.cooperation, setup.sampling.certificate, float(case.run.time[-1])
        largest = largest_certified_period(setup.start, case.shape, until, cooperation=law, certificate=chosen)
        verdict = "yes" if found.certified.all() else "no"
        limit = [f"{found.T_max[k]:.6g}", f"{found.time[k]:g}", found.who(k)]
        rows.append([case.name, f"{found.T:g}", verdict, *limit, ", ".join(stretches) or "never", f"{largest:.6g}"])
    return table(head, rows, ["", "", "", "", "", "text", "text", ""], name="certificate")


def parameters(cases: Sequence[Case]) -> str:
    """The potential of each run and where it came from, then the constants.

    Parameters
    ----------
    cases : the runs
    """
    rows = [
        [case.name, f"{case.shape.alpha:.7g}", f"{case.shape.r:.7g}", f"{case.shape.p:.7g}", case.origin]
        for case in cases
    ]
    potentials = table(["run", "alpha [1]", "r [m]", "p [1]", "where from"], rows, ["", "", "", "", "text"])
    lines = zip(*(constants_table(case) for case in cases), strict=True)
    rows = [[line[0][0], shared(row[1] for row in line), line[0][2], shared(row[3] for row in line)] for line in lines]
    constants = table(["constant", "value", "unit", "where from"], rows, ["", "", "text", "text"])
    return f"{potentials}<br>{constants}"


def shared(values: Iterable[str]) -> str:
    """One value where all runs have the same, else all of them in the order of the runs.

    Parameters
    ----------
    values : one per run
    """
    found = list(values)
    return found[0] if len(set(found)) == 1 else " / ".join(found)


def start(cases: Sequence[Case]) -> str:
    """Spacings and speeds at the start.

    Parameters
    ----------
    cases : the runs
    """
    starts = [case.setup.start for case in cases]
    rows = []
    for i in range(starts[0].v.size):
        spacing = shared(f"{one.s[i - 1]:.10g}" for one in starts) if i else ""
        rows.append([str(i + 1), spacing, shared(f"{one.v[i]:.10g}" for one in starts)])
    return table(["vehicle", "spacing ahead [m]", "speed [m/s]"], rows)


def provenance(entries: Mapping[str, str]) -> str:
    """Versions and hashes.

    Parameters
    ----------
    entries : values by name
    """
    return table(["", ""], [[name, value] for name, value in entries.items()], ["", "hash"], name="provenance")
