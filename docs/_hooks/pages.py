"""What the pages take from the code: variables, error messages, help texts; and mathematics as MathML."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

_CODE = re.compile(r"(^```.*?^```|`[^`\n]*`)", re.DOTALL | re.MULTILINE)
_MATHS = re.compile(r"\$\$(.+?)\$\$|\\\((.+?)\\\)", re.DOTALL)
_VEHICLES = 7


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Fill in what stands in double braces, then set the mathematics."""
    makers = {"variables": variables, "messages": messages, "commands": commands}
    makers |= {"controller variables": controller_variables, "joining variables": joining_variables}
    makers |= {"plant variables": plant_variables, "leader variables": leader_variables}
    makers |= {"cost in traffic": cost_in_traffic, "rooms": rooms}
    for name, make in makers.items():
        if f"{{{{ {name} }}}}" in markdown:
            markdown = markdown.replace(f"{{{{ {name} }}}}", make())
    markdown = re.sub(r"\{\{ file (\S+) \}\}", lambda found: (ROOT / found[1]).read_text(encoding="utf-8"), markdown)
    markdown = re.sub(r"\{\{ (traffic|sweep) (\S+) \}\}", lambda found: _OF_RESULTS[found[1]](found[2]), markdown)
    markdown = re.sub(r"\{\{ result (\w+) \}\}", lambda found: result(found[1]), markdown)
    parts = _CODE.split(markdown)
    return "".join(part if index % 2 else _MATHS.sub(_mathml, part) for index, part in enumerate(parts))


def _mathml(found: re.Match[str]) -> str:
    from latex2mathml.converter import convert

    display = "block" if found[1] else "inline"
    return str(convert((found[1] or found[2]).strip(), display=display))


def result(name: str) -> str:
    """What a long run left in benchmarks/results, without its title."""
    path = ROOT / "benchmarks" / "results" / f"{name}.md"
    if not path.exists():
        return f"No result of a whole run is kept in `benchmarks/results/{name}.md` for this version."
    return re.sub(r"\A# .*\n", "", path.read_text(encoding="utf-8")).strip()


def variables() -> str:
    """The table of FMI variables of `PspPlatoon`."""
    from fmu_src.interface.platoon import platoon_table

    return _rows(platoon_table(_VEHICLES))


def controller_variables() -> str:
    """The inputs and outputs of `PspController`, and the parameters that it alone has."""
    from fmu_src.interface.controller import controller_table
    from fmu_src.interface.platoon import platoon_table

    known = {row.name for row in platoon_table(_VEHICLES) if row.causality == "parameter"}
    return _rows([row for row in controller_table(_VEHICLES) if row.name not in known])


def plant_variables() -> str:
    """The variables of `PspPlant`."""
    from fmu_src.interface.plant import plant_table

    return _rows(plant_table(_VEHICLES))


def leader_variables() -> str:
    """The variables of `PspLeader`, with the wave."""
    from fmu_src.interface.leader import leader_table

    return _rows(leader_table())


def joining_variables() -> str:
    """What `PspPlatoon` has for vehicles that join and leave."""
    from fmu_src.interface.platoon import joining_names, platoon_table

    return _rows([row for row in platoon_table(_VEHICLES) if row.name in joining_names(_VEHICLES)])


def traffic(situation: str) -> str:
    """The table of a traffic situation, from benchmarks/results."""
    from psp_traffic.compare import of_situation
    from psp_traffic.results import read_results
    from psp_traffic.summary import table

    return table(of_situation(read_results(_RESULTS / "traffic.json")[1], situation))


def sweep(situation: str) -> str:
    """The tables of delay and lag in a situation, from benchmarks/results."""
    from psp_traffic.results import read_results
    from psp_traffic.sweep import of_sweep, sweep_text

    file = {"highway": "traffic_sweep_highway.json", "stop-and-go": "traffic_sweep_wave.json"}[situation]
    return sweep_text(of_sweep(read_results(_RESULTS / file)[1], situation))


def cost_in_traffic() -> str:
    """The table of benchmarks/traffic.py, from benchmarks/results."""
    import json

    rows = json.loads((_RESULTS / "traffic_cost.json").read_text(encoding="utf-8"))["rows"]
    lines = ["| " + " | ".join(map(str, cells)) + " |" for cells in (rows[0], *(row.values() for row in rows))]
    return "\n".join([lines[0], "|---" * len(rows[0]) + "|", *lines[1:]])


def rooms() -> str:
    """The rooms of the project: a picture with the ground floor at the bottom, then a line for each room."""
    import tomllib

    floors = tomllib.loads((ROOT / "docs" / "rooms.toml").read_text(encoding="utf-8"))["floors"]
    lines = ["| floor | room | what is in it | packages that it knows |", "|---|---|---|---|"]
    for floor in reversed(floors):
        for place, room in enumerate(floor["rooms"]):
            name = "" if place else floor["name"]
            path = f'`{room["path"]}`{{ style="white-space: nowrap" }}'
            lines.append(f"| {name} | {path} | {room['line']} | {', '.join(room.get('foreign', []))} |")
    return _house(floors) + "\n\n" + "\n".join(lines)


_WIDTH, _HEIGHT, _LEFT = 860, 46, 142
_TINTS = {"psp_model": "#0072b2", "fmu_src": "#d55e00", "other packages": "#009e73"}  # Okabe and Ito (2008)


def _house(floors: list[dict[str, Any]]) -> str:
    """The floors as SVG, one above the other; it stands on light and on dark ground."""
    parts = []
    for place, floor in enumerate(reversed(floors)):
        top, each = place * _HEIGHT, (_WIDTH - _LEFT) / len(floor["rooms"])
        parts.append(f'<text x="0" y="{top + 25}" font-weight="bold">{floor["name"]}</text>')
        parts += [_box(room, _LEFT + k * each, top, each) for k, room in enumerate(floor["rooms"])]
    bottom = len(floors) * _HEIGHT
    line = f'x1="{_LEFT - 12}" y1="6" x2="{_LEFT - 12}" y2="{bottom - 14}" stroke="currentColor"'
    tip = f"{_LEFT - 16},{bottom - 18} {_LEFT - 12},{bottom - 8} {_LEFT - 8},{bottom - 18}"
    parts.append(f'<line {line}/><polygon points="{tip}" fill="currentColor"/>')
    parts.append(f'<text x="{_LEFT}" y="{bottom + 16}">The arrow says which way imports go.</text>')
    for k, (package, colour) in enumerate(_TINTS.items()):
        x = _LEFT + 300 + 130 * k
        parts.append(f'<rect x="{x}" y="{bottom + 5}" width="14" height="14" rx="3" {_painted(colour)}/>')
        parts.append(f'<text x="{x + 20}" y="{bottom + 16}">{package}</text>')
    style = "font:13px sans-serif;fill:currentColor;max-width:100%;height:auto"
    title = "<title>The rooms; imports point down.</title>"
    size = f'viewBox="0 0 {_WIDTH} {bottom + 24}" width="{_WIDTH}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} style="{style}">{title}{"".join(parts)}</svg>'


def _box(room: dict[str, Any], x: float, top: int, width: float) -> str:
    """A room: its name, and its line where the mouse rests on it."""
    package = room["path"].split("/")[0]
    name = room.get("name", room["path"].removeprefix("psp_model/").removeprefix("fmu_src/"))
    size = f'x="{x + 3:.0f}" y="{top + 4}" width="{width - 6:.0f}" height="{_HEIGHT - 10}" rx="5"'
    text = f'<text x="{x + width / 2:.0f}" y="{top + 26}" text-anchor="middle">{name}</text>'
    tint = _painted(_TINTS.get(package, _TINTS["other packages"]))
    return f"<g><title>{room['path']}: {room['line']}</title><rect {size} {tint}/>{text}</g>"


def _painted(colour: str) -> str:
    return f'fill="{colour}" fill-opacity="0.16" stroke="{colour}"'


_RESULTS = ROOT / "benchmarks" / "results"
_OF_RESULTS = {"traffic": traffic, "sweep": sweep}


def _rows(table: Any) -> str:
    """One row per name; numbered ones as name[i]."""
    rows: dict[str, list[Any]] = {}
    for row in table:
        rows.setdefault(re.sub(r"\[\d+\]", "[i]", row.name), []).append(row)
    lines = ["| name | what | unit | start | limits | meaning |", "|---|---|---|---|---|---|"]
    for name, same in rows.items():
        first = same[0]
        starts = "" if first.start is None else ", ".join(dict.fromkeys(f"{row.start:g}" for row in same))
        meaning = re.sub(r"vehicle \d+", "vehicle i", first.description) if "[i]" in name else first.description
        meaning = meaning.replace("vehicle i and vehicle i", "vehicle i - 1 and vehicle i")
        what = first.causality + (", Integer" if first.integer else "")
        shown = [f"`{name}`", what, first.unit, starts, _limits(first.minimum, first.maximum), meaning]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in shown) + " |")
    return "\n".join(lines)


def _limits(low: float | None, high: float | None) -> str:
    if low is None or high is None:
        return f"≥ {low:g}" if low is not None else f"≤ {high:g}" if high is not None else ""
    return f"{low:g} to {high:g}"


def messages() -> str:
    """Every sentence of the model and of the FMUs, with dots where values stand."""
    from fmu_src import errors as of_the_fmus
    from psp_model import errors as of_the_model

    lines = []
    for key, sentence in (of_the_model.SENTENCES | of_the_fmus.SENTENCES).items():
        problem, remedy = of_the_model.parts_of(re.sub(r"%(\.10g|d|s)", "…", sentence).replace("%%", "%"))
        lines.append(f"### {problem} {{ #{key} }}\n\n**What to do:** {remedy}.\n")
    return "\n".join(lines)


def commands() -> str:
    """The help text of every command."""
    from typer.main import get_command
    from typer.testing import CliRunner

    from psp_cli.main import app

    lines = []
    for name in get_command(app).commands:
        text = CliRunner().invoke(app, [name, "--help"], prog_name="psp", terminal_width=100).stdout
        lines.append(f"## psp {name}\n\n```text\n{text.strip()}\n```\n")
    return "\n".join(lines)
