"""The pages inside the FMU: what it is, its variables, what it needs, its licences."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from .model_description import Component
from .variables import Variable

_STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 70rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem; }
th, td { text-align: left; padding: 0.25rem 0.6rem; border-bottom: 1px solid #8884; vertical-align: top; }
td.n { text-align: right; font-variant-numeric: tabular-nums; }
.wide { overflow-x: auto; }
code { font-size: 0.95em; }
"""

_SAMPLING_OF_A_LOOP = """<p>The feedback is sampled every <code>T</code> seconds by the FMU's own clock, beginning at
the start time. A communication step may be <code>T</code>, a multiple of it, any part of it, or 0: the results at
the sampling instants are independent of it, and between them the outputs follow the exact polynomials. At a
communication point that is a sampling instant the outputs are those just after sampling.</p>
<p>A vehicle joins when <code>insert</code> rises above 0.5, and leaves when <code>remove</code> does: at the
communication point where the input is set, when the next step begins; if both, one leaves first. This is a sampling
instant of its own, followed by a replan of <code>alpha</code>, <code>r</code>, <code>p</code> for the new initial
state. A vehicle joins only if <code>T</code> is certified for the platoon with it, as <code>certificate</code> says,
and if the platoon then has the brake margin <code>join_brake_margin</code>; if not, <code>change_ok</code> is 0,
<code>gap_offered</code> is a spacing that would be accepted, and a warning is logged.</p>
<p>With <code>leader_automated</code> = 0 vehicle 1 drives itself: set <code>leader_speed</code> and
<code>leader_acceleration</code> at every sampling instant, the latter as what is held until the next. They act when the
next step begins, from that instant on. The network, and the rollouts with <code>parameter_source</code> = 3, judge by
the paper's law.</p>"""
_SAMPLING = {
    "PspController": """<p>The sampling instants are at start + <code>phase</code> + k <code>T</code>, independent of
the communication step. At a communication point that is a sampling instant, set the inputs, step the controller, and
read the commands; then give them to the plant and step it over the same time: there is no delay. Reading the commands
after the inputs were set and before the step gives the same numbers, but FMI 2.0 (4.2.4) lists that as a wrong calling
sequence. A master that steps both and exchanges values afterwards has them one communication step later.
Instants inside a communication step
use the inputs of its beginning: communicate at every sampling instant. Between instants the commands are held.</p>
<p>With the fail-safe command (<code>bad_input</code> = 2) every active vehicle slows down with <code>a_safe</code>
until the inputs are valid again; Lemma 1 does not apply then.</p>""",
    "PspLeader": """<p>The speed is a function of time: it is independent of the communication step. Held for
<code>T</code>, the acceleration <code>a</code> takes a vehicle from the speed now to that <code>T</code> later: a plant
of the same <code>T</code> that is given <code>a</code> at every instant has exactly these speeds at the instants.
Connect <code>a</code> to the plant's <code>a[1]</code> and the controller's <code>a_measured[1]</code>, and
<code>automated</code>, which is 0, to <code>automated[1]</code> of both; or <code>v</code> to the controller's
<code>v_desired</code>.</p>""",
    "PspPlant": """<p>The acceleration known at the end of a period of length <code>T</code> applies to all of it: a
command passed by a master late, but within the period, has the same effect as without the delay. Outputs show the
motion at the beginning of the current period. With masters that exchange values between steps only, use a
communication step of T/4 and give the controller <code>phase</code> = T/2.</p>
<p>A command is cut at <code>a_min</code> and <code>a_max</code>; <code>actuation_delay</code> after the beginning of
its period it takes effect through a first-order lag with the time constant <code>actuator_lag</code>. The motion in
between is exact, so that it is independent of the communication step. With the start values there is neither dead
time nor lag nor limit. A vehicle with <code>automated</code> = 0 drives itself: it has its <code>a</code> at once,
and where it is automated again its actuator begins with that. Vehicles do not reverse: one that brakes to standstill
stands until its acceleration is above 0. Spacings are front to front and may have any size above 0 at the start; a
<code>clearance</code> of 0 or less means contact, after which vehicles drive on as if there were none.</p>""",
}


def _cell(value: float | None) -> str:
    return f'<td class="n">{"" if value is None else format(value, ".10g")}</td>'


def _row(variable: Variable) -> str:
    kind = f"{variable.causality}, {variable.variability}" + (", Integer" if variable.integer else "")
    numbers = "".join(_cell(value) for value in (variable.start, variable.minimum, variable.maximum))
    return (
        f"<tr><td><code>{escape(variable.name)}</code></td><td>{kind}</td><td>{escape(variable.unit)}</td>"
        f"{numbers}<td>{escape(variable.description)}</td></tr>"
    )


def variable_table(table: Sequence[Variable]) -> str:
    """The variables as an HTML table.

    Parameters
    ----------
    table : the variables
    """
    head = "<tr><th>name</th><th>kind</th><th>unit</th><th>start</th><th>min</th><th>max</th><th>meaning</th></tr>"
    return f'<div class="wide"><table>{head}\n' + "\n".join(map(_row, table)) + "\n</table></div>"


def index_page(component: Component, vehicles: int, table: Sequence[Variable], notes: Sequence[str]) -> bytes:
    """documentation/index.html.

    Parameters
    ----------
    component : names and versions
    vehicles : n
    table : the variables
    notes : paragraphs on the network and on what the FMU needs from outside
    """
    paragraphs = "\n".join(f"<p>{escape(note)}</p>" for note in notes)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{component.name} {component.version}</title><style>{_STYLE}</style></head><body>
<h1>{component.name} <small>{component.version}, {vehicles} vehicles</small></h1>
<p>{escape(component.description)}.</p>
{paragraphs}
<h2>Sampling</h2>
{_SAMPLING.get(component.name.removesuffix("Native"), _SAMPLING_OF_A_LOOP)}
<h2>Errors</h2>
<p>A value that the model is not defined for ends in <code>fmi2Error</code> and one logged sentence that names the
variable, its value, the limit and the remedy. The instance can then be reset and run again.</p>
<h2>Variables</h2>
{variable_table(table)}
</body></html>
""".encode()
