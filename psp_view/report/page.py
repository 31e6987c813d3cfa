"""The report's page, put together from its parts."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

from psp_model.analysis.cases import Case
from psp_model.selection.network import ParameterNetwork
from psp_model.whole_file import write_whole

from . import tables
from .payload import payload
from .provenance import hashes, network_hash, versions
from .thin import TOLERANCE

_STYLES = ("uplot.min.css", "report.css")
_SCRIPTS = ("uplot.min.js", "data.js", "road.js", "plots.js")


def report_html(
    cases: Sequence[Case], command: str, network: ParameterNetwork | None = None, title: str = "Platoon report"
) -> str:
    """One self-contained HTML page about runs of the same platoon.

    The same runs and the same command give the same page, to the byte.

    Parameters
    ----------
    cases : the runs, all with the same number of vehicles
    command : what makes this very page
    network : the network that runs asked, for its hash
    title : heading

    Returns
    -------
    the page
    """
    first = cases[0]
    n, constants = first.run.v.shape[1], first.setup.start.constants
    duration = max(float(case.run.time[-1]) for case in cases)
    page = Template(read("page.html"))
    return page.substitute(
        title=escape(title),
        subtitle=f"{n} vehicles, {duration:g} s, {len(cases)} runs",
        css="\n".join(read(name) for name in _STYLES),
        summary=tables.summary(cases),
        warnings=tables.warnings(cases),
        v_star=f"{constants.v_star:g}",
        duration=f"{duration:.10g}",
        vehicles=n,
        thinned=f"Lines are thinned: none is off by more than {TOLERANCE:.2%} of its plot's range. "
        "The tables use all points.",
        certificate=tables.certificate(cases),
        parameters=tables.parameters(cases),
        start=tables.start(cases),
        command=escape(command),
        provenance=tables.provenance(versions() | network_hash(network) | hashes(cases)),
        data=_packed(json.dumps(payload(cases), separators=(",", ":"))),
        js=f"/*\n{read('uplot.LICENSE')}*/\n" + "\n".join(read(name) for name in _SCRIPTS),
    )


def read(name: str) -> str:
    """A part of the page.

    Parameters
    ----------
    name : of the file in assets/
    """
    return (files(__package__) / "assets" / name).read_text(encoding="utf-8")


def _packed(text: str) -> str:
    """Text as base64 of gzip, the same every time."""
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def write_report(
    cases: Sequence[Case],
    path: Path,
    command: str,
    network: ParameterNetwork | None = None,
    title: str = "Platoon report",
) -> None:
    """Write `report_html` to a file.

    Parameters
    ----------
    cases, command, network, title : as for `report_html`
    path : the file; missing folders are made
    """
    write_whole(path, report_html(cases, command, network, title))
