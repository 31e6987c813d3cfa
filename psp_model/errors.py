"""The root of all errors that a user can cause, the model's own error, and the sentences it carries.

Every sentence says value, unit, limit and remedy.  They are printf formats so that the native FMU, which has
no Python, prints the same words: `fmu_src` copies this table into its C sources.  The one colon in a sentence that a
space follows stands between problem and remedy.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import combinations
from typing import Any, ClassVar

SENTENCES = {
    "finite": "%s must be a finite number, not %.10g: give it a value in %s",
    "L": "L = %.10g m must be positive: it is the smallest allowable spacing, give it a length above 0 m",
    "lambda": "lambda = %.10g m must exceed L + 3 m = %.10g m: the hill is 3 m wide and lies between L and lambda, "
    "raise lambda or lower L",
    "v_max": "v_max = %.10g m/s must be positive: it is the speed limit, give it a speed above 0 m/s",
    "v_star": "v_star = %.10g m/s must lie strictly between 0 m/s and v_max = %.10g m/s: lower v_star or raise v_max",
    "v_star_backwards": "v_star = %.10g m/s must lie strictly between 0 m/s and v_max = %.10g m/s: give it a speed "
    "above 0 m/s",
    "epsilon": "epsilon = %.10g m/s2 must be positive: it is the width over which f is smoothed, give it a value "
    "above 0 m/s2",
    "mu": "mu = %.10g 1/s must be positive: it is the smallest feedback gain, give it a value above 0 1/s",
    "z": "z = %.10g m/s2 must be positive: it limits |V_new'| on the hill, give it a value above 0 m/s2",
    "w1": "w1 = %.10g must not be negative: it weighs acceleration in J, give it 0 or more",
    "w2": "w2 = %.10g must not be negative: it weighs the spacings in J, give it 0 or more",
    "a_ref": "a_ref = %.10g m/s2 must be positive: it scales acceleration in J, give it a value above 0 m/s2",
    "s_ref": "s_ref = %.10g m must be positive: it scales the spacings in J, give it a length above 0 m",
    "not_negative": "%s = %.10g %s must not be negative: give it 0 %s or more",
    "feedforward": "feedforward = %.10g must lie in [0, 1]: it is the commanded share of the followed vehicle's "
    "acceleration",
    "reach": "%s = %.10g m must exceed %s = %.10g m: raise the first or lower the second",
    "following": "following = %d must be 1, the nearest vehicle ahead that is not automated, or 2, the predecessor: "
    "choose one of them",
    "length": "length[%d] = %.10g m must be positive: give vehicle %d a length above 0 m",
    "command_limits": "a_min[%d] = %.10g m/s2 must be negative and a_max[%d] = %.10g m/s2 positive: a vehicle has to "
    "be able to brake and to accelerate",
    "dead_time": "actuation_delay = %.10g s must not exceed %d periods of T = %.10g s, as every command on its way is "
    "remembered: lower actuation_delay or raise T",
    "older": "what is measured is %.10g s old, more than oldest = %.10g s, for which commands are remembered: raise "
    "oldest, or measure more often",
    "T": "T = %.10g s must be positive: it is the sampling period, give it a time above 0 s",
    "alpha": "alpha = %.10g must lie in [%.10g, %.10g]: choose alpha inside these bounds",
    "r": "r = %.10g m must exceed L = %.10g m and not exceed lambda - 3 m = %.10g m: choose r inside these bounds",
    "p": "p = %.10g must lie in [%.10g, %.10g]: choose p inside these bounds",
    "slope": "max |V_new'| = %.10g m/s2 on [r, r + 3 m] for alpha = %.10g, r = %.10g m, p = %.10g must not exceed z "
    "= %.10g m/s2: lower p, raise r or raise z",
    "empty": "no alpha, r, p keeps max |V_new'| on the hill below z = %.10g m/s2: raise z or widen lambda - L",
    "vehicles": "%d vehicles are too few: a platoon has at least 2",
    "shape": "%d spacings and %d speeds do not belong to one platoon: n vehicles have n - 1 spacings and n speeds",
    "spacing": "spacing s[%d] = %.10g m must exceed L = %.10g m: start the vehicles further apart or lower L",
    "spacing_order": "spacing s[%d] = %.10g m must be above 0 m: start vehicle %d behind vehicle %d",
    "spacing_length": "spacing s[%d] = %.10g m must exceed the length of vehicle %d, %.10g m: start the vehicles "
    "further apart, or correct that length",
    "speed": "speed v[%d] = %.10g m/s must lie in [0, %.10g] m/s: start vehicle %d no faster than v_max, or raise "
    "v_max",
    "speed_backwards": "speed v[%d] = %.10g m/s must lie in [0, %.10g] m/s: start vehicle %d at 0 m/s or more",
    "lemma1_spacing": "T = %.10g s is not below T_max = %.10g s at t = %.10g s (Lemma 1), as vehicle %d could close "
    "its spacing s[%d] = %.10g m to L = %.10g m at v_max = %.10g m/s within T: choose T < %.10g s, or lemma1_policy 3",
    "lemma1_fast": "T = %.10g s is not below T_max = %.10g s at t = %.10g s (Lemma 1), as vehicle %d, at v[%d] = "
    "%.10g m/s with a[%d] = %.10g m/s2, would reach v_max = %.10g m/s within T: choose T < %.10g s, or lemma1_policy "
    "3",
    "lemma1_slow": "T = %.10g s is not below T_max = %.10g s at t = %.10g s (Lemma 1), as vehicle %d, at v[%d] = "
    "%.10g m/s with a[%d] = %.10g m/s2, would come to a stop, %.10g m/s, within T: choose T < %.10g s, or "
    "lemma1_policy 3",
    "lemma1_length": "T = %.10g s is not below T_max = %.10g s at t = %.10g s (Lemma 1), as vehicle %d could close its "
    "spacing s[%d] = %.10g m to the length of the vehicle ahead, %.10g m, at v_max = %.10g m/s within T: choose T < "
    "%.10g s, or lemma1_policy 3",
    "exact_spacing": "T = %.10g s is not below T_exact = %.10g s at t = %.10g s, as vehicle %d would close its spacing "
    "s[%d] = %.10g m to %.10g m within T: choose T < %.10g s, or lemma1_policy 3",
    "exact_fast": "T = %.10g s is not below T_exact = %.10g s at t = %.10g s, as vehicle %d, at v[%d] = %.10g m/s with "
    "a[%d] = %.10g m/s2, would reach v_max = %.10g m/s within T: choose T < %.10g s, or lemma1_policy 3",
    "exact_slow": "T = %.10g s is not below T_exact = %.10g s at t = %.10g s, as vehicle %d, at v[%d] = %.10g m/s with "
    "a[%d] = %.10g m/s2, would come to a stop, %.10g m/s, within T: choose T < %.10g s, or lemma1_policy 3",
    "choice": "%s = %d must lie in %d to %d: choose one of these whole numbers",
    "count": "%s = %d must be at least 1: choose a larger whole number",
    "horizon": "rollout_horizon = %.10g s must be positive and finite: give it a time above 0 s",
    "no_network": "there is no network for %d vehicles here: use parameter_source 2, or build the FMU with a network",
    "network_missing": "the network file %s cannot be read (%s): put it back, or use parameter_source 2",
    "network_damaged": "the network file %s is not a readable ONNX file: put an undamaged one in its place, or use "
    "parameter_source 2",
    "network_shape": "the network file %s has inputs %s and outputs %s, but initial_condition [batch, 2n-1], or gaps "
    "[batch, n-1] and speeds [batch, n] for any n, and parameters [batch, 3] are needed: export it with psp train, "
    "or use parameter_source 2",
    "network_metadata": "the network file %s lacks readable psp_vehicles (or psp_vehicles_min and psp_vehicles_max), "
    "psp_domain or psp_constants in its metadata: export it with psp train, or use parameter_source 2",
    "network_range": "the network file %s is made for %d to %d vehicles, not for %d: use one for this platoon, or "
    "parameter_source 2",
    "network_vehicles": "the network file %s is made for %d vehicles, not for %d: use the one for this platoon, or "
    "parameter_source 2",
    "fallback": "the initial state has %s: alpha = %.10g, r = %.10g m, p = %.10g are used instead of the network's",
    "left_spacing": "spacing s[%d] = %.10g m has fallen to L = %.10g m at t = %.10g s, where the model ends: choose a "
    "smaller T, or lemma1_policy 3",
    "left_length": "spacing s[%d] = %.10g m has fallen to the length of the vehicle ahead, %.10g m, at t = %.10g s, "
    "where vehicles touch: choose a smaller T, or lemma1_policy 3",
    "networks": "%s holds no networks, although this project brings some: install it anew, or put the folder back",
    "onnxruntime": "the Python %s cannot import onnxruntime (%s): run %s -m pip install onnxruntime, or use "
    "parameter_source 2, or the native FMU",
    "numbers": "%s is not an array of numbers: give numbers, a list or tuple of numbers, or an array",
    "start": "the start %s is neither a PlatoonState nor a pair of numbers: give n - 1 spacings and n speeds, as in "
    "([9, 10], [30, 30, 30])",
    "potential": "%s is neither a potential nor a selector: give one, or one of the words %s",
    "duration": "duration = %.10g s must be finite and not negative: give the run a length of 0 s or more",
    "batch_empty": "there are no starts to run: give at least one",
    "batch_starts": "start %d, with %d vehicles, cannot be in one batch with the first, with %d: give all starts of a "
    "batch the same number of vehicles, at least 2, and the same constants",
    "batch_potentials": "%d potentials do not fit %d starts: give one for all, or one for each",
    "output_step": "output_step = %.10g s must be positive and finite: give it a time above 0 s",
    "a_safe": "a_safe = %.10g m/s2 must not be below a_min[%d] = %.10g m/s2: raise a_safe or lower that a_min",
    "a_safe_positive": "a_safe = %.10g m/s2 must not be above 0 m/s2, as the fail-safe command slows down: give it 0 "
    "m/s2 or less",
    "max_age": "max_age = %.10g s must be positive: it is the greatest age of an input, give it a time above 0 s",
    "phase": "phase = %.10g s must be at least 0 s and below T = %.10g s: it is the time of the first sampling instant",
    "active": "n_active = %.10g must be a whole number from 1 to %d: set the number of vehicles that are controlled",
    "v_desired": "v_desired = %.10g m/s is above v_max = %.10g m/s: lower v_desired or raise v_max",
    "v_desired_backwards": "v_desired = %.10g m/s is below 0 m/s: give it 0 m/s to stand, or -1 m/s for v_star",
    "v_desired_finite": "v_desired = %.10g m/s is not a finite number: give it a speed from 0 m/s to v_max = %.10g "
    "m/s, or -1 m/s for v_star",
    "measured_spacing": "the measured spacing s[%d] = %.10g m does not exceed L = %.10g m, and no feedback is defined "
    "there: keep the vehicles apart, check the sensor, or lower L",
    "measured_clearance": "the measured spacing s[%d] = %.10g m does not exceed the length of vehicle %d, %.10g m, "
    "and no feedback is defined where vehicles touch: keep them apart, check the sensor, or correct that length",
    "measured_order": "the measured spacing s[%d] = %.10g m is not above 0 m, as if vehicle %d were not behind "
    "vehicle %d: number the vehicles from the front, or check the sensor",
    "measured_speed": "the measured speed v[%d] = %.10g m/s is above v_max = %.10g m/s, and no feedback is defined "
    "there: slow the vehicle down, check the sensor, or raise v_max",
    "measured_backwards": "the measured speed v[%d] = %.10g m/s is below 0 m/s, and no feedback is defined for a "
    "vehicle that rolls backwards: stop it, or check the sensor's zero",
    "stale": "the inputs are %.10g s old, more than max_age = %.10g s: measure more often, or raise max_age",
    "age": "the inputs are %.10g s old, which is not a finite number: set t_measured to the time of measurement, or "
    "to -1 s for the time at which they are set",
    "safe_action": "the fail-safe command is given at t = %.10g s: %s",
    "lemma1_controller": "T = %.10g s is not below T_max = %.10g s at t = %.10g s for the %s spacings and speeds "
    "(Lemma 1): choose T < %.10g s, or lemma1_policy 2",
    "lemma1_controller_spacing": "T = %.10g s is not below T_max = %.10g s at t = %.10g s for the %s spacing s[%d] = "
    "%.10g m (Lemma 1): keep that spacing above %.10g m, choose T < %.10g s, or lemma1_policy 2",
    "exact_controller": "T = %.10g s is not below T_exact = %.10g s at t = %.10g s, after which the commands held "
    "would take a spacing to its limit or a speed out of [0, v_max]: choose T < %.10g s, or lemma1_policy 2",
    "older_input": "the inputs are %.10g s old, and vehicles can be predicted from %.10g s at most: measure more often",
    "full": "the platoon is full (%d vehicles): remove one first, or build the FMU for more",
    "place": "%s = %.10g must be a whole number from %d to %d: name a vehicle of the platoon",
    "last": "the last vehicle cannot leave: a platoon has at least 1",
    "insert_speed": "the joining vehicle's speed %.10g m/s must lie in [0, %.10g] m/s: let it join no faster than "
    "v_max",
    "insert_finite": "the joining vehicle's speed %.10g m/s must be a finite number: let it join at a speed from 0 "
    "m/s to v_max = %.10g m/s",
    "insert_backwards": "the joining vehicle's speed %.10g m/s must lie in [0, %.10g] m/s: let it join at 0 m/s or "
    "more",
    "insert_spacing": "a vehicle cannot join at place %d with a spacing of %.10g m at %.10g m/s, where T = %.10g s "
    "would not be below T_max (Lemma 1): a spacing of %.10g m would be accepted",
    "insert_none": "a vehicle cannot join at place %d with a spacing of %.10g m at %.10g m/s, where T = %.10g s "
    "would not be below T_max (Lemma 1): no spacing would be accepted there now, let it join at another place, speed "
    "or time",
    "insert_length": "the joining vehicle's length %.10g m must be a finite number, not below 0 m: give it its length, "
    "or 0 m for L",
    "insert_spacing_exact": "a vehicle cannot join at place %d with a spacing of %.10g m at %.10g m/s, where T = %.10g "
    "s would not be below T_exact: a spacing of %.10g m would be accepted",
    "insert_none_exact": "a vehicle cannot join at place %d with a spacing of %.10g m at %.10g m/s, where T = %.10g s "
    "would not be below T_exact: no spacing would be accepted there now, let it join at another place, speed or time",
    "insert_spacing_margin": "a vehicle cannot join at place %d with a spacing of %.10g m at %.10g m/s, where the "
    "brake margin would be below join_brake_margin = %.10g m/s2: a spacing of %.10g m would be accepted",
    "insert_none_margin": "a vehicle cannot join at place %d with a spacing of %.10g m at %.10g m/s, where the brake "
    "margin would be below join_brake_margin = %.10g m/s2: no spacing would be accepted there now, let it join at "
    "another place, speed or time",
    "join_brake_margin": "join_brake_margin = %.10g m/s2 must lie in [0, %.10g] m/s2: it is the brake margin that "
    "joining asks for, give it 0 m/s2 to ask for none",
    "join_a_min": "join_a_min = %.10g m/s2 must be negative: it is what vehicles can brake with, give it a value below "
    "0 m/s2",
    "leader_speed": "leader_speed = %.10g m/s must lie in [0, %.10g] m/s: set it to a speed from 0 m/s to v_max, or "
    "raise v_max",
    "wave": "v_low = %.10g m/s must not exceed v_high = %.10g m/s: raise v_high or lower v_low",
    "wave_backwards": "v_low = %.10g m/s must not be negative: give it a speed of 0 m/s or more",
    "wave_period": "period = %.10g s must be positive: give the wave a time above 0 s",
    "profile_file": "the speed profile %s cannot be read (%s): give a CSV file with time [s] and speed [m/s]",
    "profile_line": "line %d of the speed profile %s, '%s', is not two numbers with a comma between them: write time "
    "[s] and speed [m/s], or a heading that names the columns time and speed",
    "profile_rows": "the speed profile %s has %d rows of time and speed: give it at least 2",
    "profile_time": "time %.10g s in row %d of the speed profile %s does not come after %.10g s: let times increase",
    "profile_speed": "speed %.10g m/s in row %d of the speed profile %s must lie in [0, %.10g] m/s: use a part of "
    "the profile that does, with speeds in m/s",
    "profile_backwards": "speed %.10g m/s in row %d of the speed profile %s must lie in [0, %.10g] m/s: give the "
    "leader 0 m/s or more",
    "periods": "%.10g s are more sampling periods of T = %.10g s than can be counted: take a shorter time or a "
    "longer T",
    "short_periods": "more than max_short_periods = %d short sampling periods in one communication step, at t = "
    "%.10g s with T_max = %.10g s: raise max_short_periods, take shorter communication steps, or start further from L",
    "short_periods_exact": "more than max_short_periods = %d short sampling periods in one communication step, at t = "
    "%.10g s with T_exact = %.10g s: raise max_short_periods, take shorter communication steps, or start further apart",
}

SEPARATOR = ": "
"""What stands between problem and remedy."""

_CONVERSION = re.compile(r"%(?:\.1[07]g|d|s|%)")

Value = float | int | str | BaseException
"""What a sentence is filled with: a number, a text, or an error whose sentence goes on with this one's."""


def parts_of(sentence: str) -> tuple[str, str]:
    """Problem and remedy of a sentence, or of the format of one.

    Parameters
    ----------
    sentence : with its separator; where there are several, as in "file: line: problem: remedy", the last one counts

    Returns
    -------
    problem, remedy : the remedy is empty where there is no separator
    """
    problem, separator, remedy = sentence.rpartition(SEPARATOR)
    return (problem, remedy) if separator else (sentence, "")


class PspError(Exception):
    """The root of all errors that a user can cause; its text is one sentence, "problem: remedy".

    Attributes
    ----------
    problem : what is wrong, with value, unit and limit
    remedy : what to do about it
    key : name of the sentence in a table of sentences, None where it comes from none
    values : what that sentence was filled with

    Parameters
    ----------
    problem : the same; without `remedy` the whole sentence
    remedy : the same
    """

    key: str | None = None
    values: tuple[Value, ...] = ()

    def __init__(self, problem: str, remedy: str | None = None) -> None:
        # `args` are the arguments of the constructor: that is all that pickle and copy ask of an exception
        super().__init__(*((problem,) if remedy is None else (problem, remedy)))
        self.problem, self.remedy = parts_of(problem) if remedy is None else (problem, remedy)

    def __str__(self) -> str:
        return SEPARATOR.join(part for part in (self.problem, self.remedy) if part)


class TableError(PspError):
    """An error whose sentence stands in a table.

    Attributes
    ----------
    sentences : the table, formats by key

    Parameters
    ----------
    key : of the sentence
    values : that it is filled with
    """

    sentences: ClassVar[Mapping[str, str]] = {}
    key: str

    def __init__(self, key: str, *values: object) -> None:
        sentence = self.sentences[key]
        plain = _plain(sentence, values)
        super().__init__(*_filled(sentence, plain))
        self.args = (key, *plain)
        self.key, self.values = key, plain


class ModelError(TableError, ValueError):
    """A value outside the model's domain; the message is one sentence with value, unit, limit and remedy."""

    sentences = SENTENCES


def _plain(sentence: str, values: tuple[object, ...]) -> tuple[Value, ...]:
    """The values as the sentence shows them: Python's own numbers and texts, whatever array they come from."""
    made: dict[str, Any] = {"%.10g": float, "%d": int, "%s": _text}
    conversions = (one for one in _CONVERSION.findall(sentence) if one != "%%")
    return tuple(made[conversion](value) for conversion, value in zip(conversions, values, strict=True))


def _text(value: object) -> str | PspError:
    return value if isinstance(value, PspError) else str(value)


def _filled(sentence: str, values: tuple[Value, ...]) -> tuple[str, str]:
    """Problem and remedy; where numbers that differ would look alike ("35 is above 35"), all with 17 digits.

    fmu_src/c/front_log.c does the same.
    """
    numbers = [value for value in values if isinstance(value, float)]
    if any((a < b or a > b) and f"{a:.10g}" == f"{b:.10g}" for a, b in combinations(numbers, 2)):
        sentence = sentence.replace("%.10g", "%.17g")
    problem, remedy = parts_of(sentence)
    count = sum(one != "%%" for one in _CONVERSION.findall(problem))
    if remedy == "%s" and isinstance(cause := values[-1], PspError):  # the remedy is that of what led to this
        return SEPARATOR.join([problem % values[:count], cause.problem]), cause.remedy
    return problem % values[:count], remedy % values[count:]


class EngineError(PspError, ValueError):
    """The engine of the rollouts could not be compiled."""
