"""The one exception of the model, and the sentences it carries.

Every sentence says value, unit, limit and remedy.  They are printf formats so that the native FMU, which has
no Python, prints the same words: `fmu_src` copies this table into its C sources.
"""

import re
from itertools import combinations
from typing import Any

SENTENCES = {
    "finite": "%s must be a finite number, not %.10g: give it a value in %s",
    "L": "L = %.10g m must be positive: it is the smallest allowable gap, give it a length above 0 m",
    "lambda": "lambda = %.10g m must exceed L + 3 m = %.10g m: the hill is 3 m wide and lies between L and lambda, "
    "raise lambda or lower L",
    "v_max": "v_max = %.10g m/s must be positive: it is the speed limit, give it a speed above 0 m/s",
    "v_star": "v_star = %.10g m/s must lie strictly between 0 m/s and v_max = %.10g m/s: lower v_star or raise v_max",
    "epsilon": "epsilon = %.10g m/s2 must be positive: it is the width over which f is smoothed, "
    "give it a value above 0 m/s2",
    "mu": "mu = %.10g 1/s must be positive: it is the smallest feedback gain, give it a value above 0 1/s",
    "z": "z = %.10g m/s2 must be positive: it limits |V_new'| on the hill, give it a value above 0 m/s2",
    "w1": "w1 = %.10g must not be negative: it weighs acceleration in J, give it 0 or more",
    "w2": "w2 = %.10g must not be negative: it weighs the gaps in J, give it 0 or more",
    "a_ref": "a_ref = %.10g m/s2 must be positive: it scales acceleration in J, give it a value above 0 m/s2",
    "s_ref": "s_ref = %.10g m must be positive: it scales the gaps in J, give it a length above 0 m",
    "not_negative": "%s = %.10g %s must not be negative: give it 0 %s or more",
    "feedforward": "feedforward = %.10g must lie in [0, 1]: it is the commanded share of the followed vehicle's "
    "acceleration",
    "reach": "%s = %.10g m must exceed %s = %.10g m: raise the one or lower the other",
    "following": "following = %d must be 1, the nearest vehicle ahead that is not automated, or 2, the predecessor: "
    "choose one of them",
    "length": "length[%d] = %.10g m must be positive: give vehicle %d a length above 0 m",
    "command_limits": "a_min[%d] = %.10g m/s2 must be negative and a_max[%d] = %.10g m/s2 positive: a vehicle has "
    "to be able to brake and to accelerate",
    "older": "what is measured is %.10g s old, more than oldest = %.10g s, for which commands are remembered: raise "
    "oldest, or measure more often",
    "T": "T = %.10g s must be positive: it is the sampling period, give it a time above 0 s",
    "alpha": "alpha = %.10g must lie in [%.10g, %.10g]: choose alpha inside these bounds",
    "r": "r = %.10g m must exceed L = %.10g m and not exceed lambda - 3 m = %.10g m: choose r inside these bounds",
    "p": "p = %.10g must lie in [%.10g, %.10g]: choose p inside these bounds",
    "slope": "max |V_new'| = %.10g m/s2 on [r, r + 3 m] for alpha = %.10g, r = %.10g m, p = %.10g must not exceed "
    "z = %.10g m/s2: lower p, raise r or raise z",
    "empty": "no alpha, r, p keeps max |V_new'| on the hill below z = %.10g m/s2: raise z or widen lambda - L",
    "vehicles": "%d vehicles are too few: a platoon has at least 2",
    "shape": "%d gaps and %d speeds do not belong to one platoon: n vehicles have n - 1 gaps and n speeds",
    "gap": "gap s[%d] = %.10g m must exceed L = %.10g m: start the vehicles further apart or lower L",
    "speed": "speed v[%d] = %.10g m/s must lie in [0, %.10g] m/s: start vehicle %d slower than v_max and not backwards",
    "lemma1_gap": "T = %.10g s is not below T_max = %.10g s at t = %.10g s (Lemma 1): vehicle %d could close its gap "
    "s[%d] = %.10g m to L = %.10g m at v_max = %.10g m/s within T; choose T < %.10g s, or lemma1_policy 3",
    "lemma1_fast": "T = %.10g s is not below T_max = %.10g s at t = %.10g s (Lemma 1): vehicle %d, at "
    "v[%d] = %.10g m/s with a[%d] = %.10g m/s2, would reach v_max = %.10g m/s within "
    "T; choose T < %.10g s, or lemma1_policy 3",
    "lemma1_slow": "T = %.10g s is not below T_max = %.10g s at t = %.10g s (Lemma 1): vehicle %d, at "
    "v[%d] = %.10g m/s with a[%d] = %.10g m/s2, would come to a stop, %.10g m/s, within "
    "T; choose T < %.10g s, or lemma1_policy 3",
    "choice": "%s = %d must lie in %d to %d: choose one of these whole numbers",
    "count": "%s = %d must be at least 1: choose a larger whole number",
    "horizon": "rollout_horizon = %.10g s must be positive and finite: give it a time above 0 s",
    "no_network": "there is no network for %d vehicles here: use parameter_source 2, or build the FMU with a network",
    "network_missing": "the network file %s cannot be read (%s): put it back, or use parameter_source 2",
    "network_damaged": "the network file %s is not a readable ONNX file: put an undamaged one in its place, or use "
    "parameter_source 2",
    "network_shape": "the network file %s has inputs %s and outputs %s, but initial_condition [batch, 2n-1], or gaps "
    "[batch, n-1] and speeds [batch, n] for any n, and parameters [batch, 3] are needed: export it with psp train, or "
    "use parameter_source 2",
    "network_metadata": "the network file %s lacks readable psp_vehicles (or psp_vehicles_min and psp_vehicles_max), "
    "psp_domain or psp_constants in its metadata: export it with psp train, or use parameter_source 2",
    "network_range": "the network file %s is made for %d to %d vehicles, not for %d: use one for this platoon, or "
    "parameter_source 2",
    "network_vehicles": "the network file %s is made for %d vehicles, not for %d: use the one for this platoon, or "
    "parameter_source 2",
    "fallback": "the initial state has %s: alpha = %.10g, r = %.10g m, p = %.10g are used instead of the network's",
    "left_gap": "gap s[%d] = %.10g m has fallen to L = %.10g m at t = %.10g s, where the model ends: choose a smaller "
    "T, or lemma1_policy 3",
    "fixed": "%s is a fixed parameter: set it before initialisation ends, or reset the FMU first",
    "output": "%s is an output and cannot be set: set parameters only",
    "reference": "value reference %d belongs to no %s variable of this FMU: take it from modelDescription.xml",
    "internal": "internal error in %s, %s: please report it with the start values that led to it",
    "compiler": "the rollouts could not be compiled (%s): install the extra psp-platoon[offline], which brings "
    "a C compiler",
    "duration": "duration = %.10g s must be finite and not negative: give the run a length of 0 s or more",
    "batch_empty": "there are no starts to run: give at least one",
    "batch_starts": "start %d, with %d vehicles, does not go with the first, with %d: give all starts of a batch the same "
    "number of vehicles, at least 2, and the same constants",
    "batch_potentials": "%d potentials do not fit %d starts: give one for all, or one for each",
    "output_step": "output_step = %.10g s must be positive and finite: give it a time above 0 s",
    "limits": "a_min = %.10g m/s2 must be negative and a_max = %.10g m/s2 positive: a vehicle has to be able to "
    "slow down and to speed up",
    "a_safe": "a_safe = %.10g m/s2 must lie between a_min = %.10g m/s2 and 0 m/s2: the safe action slows down",
    "max_age": "max_age = %.10g s must be positive: it is the greatest age of an input, give it a time above 0 s",
    "phase": "phase = %.10g s must be at least 0 s and below T = %.10g s: it is the time of the first sampling instant",
    "active": "n_active = %.10g must be a whole number from 1 to %d: set the number of vehicles that are controlled",
    "v_desired": "v_desired = %.10g m/s must lie strictly between 0 m/s and v_max = %.10g m/s, or be -1 for v_star: "
    "choose another desired speed",
    "measured_gap": "the measured gap s[%d] = %.10g m does not exceed L = %.10g m: no feedback is defined there, keep "
    "the vehicles apart, lower L, or set bad_input to 2 for the safe action",
    "measured_speed": "the measured speed v[%d] = %.10g m/s does not lie in [0, %.10g] m/s: no feedback is defined "
    "there, raise v_max, or set bad_input to 2 for the safe action",
    "stale": "the inputs are %.10g s old, more than max_age = %.10g s: measure more often, raise max_age, or set "
    "bad_input to 2 for the safe action",
    "safe_action": "the safe action is taken at t = %.10g s: %s",
    "lemma1_controller": "T = %.10g s is not below T_max = %.10g s at t = %.10g s for the measured gaps and speeds "
    "(Lemma 1): choose T < %.10g s, or lemma1_policy 2",
    "full": "a vehicle more than %d does not fit: remove one first, or build the FMU for more",
    "place": "%s = %.10g must be a whole number from %d to %d: name a vehicle of the platoon",
    "last": "the last vehicle cannot leave: a platoon has at least 1",
    "insert_speed": "the joining vehicle's speed %.10g m/s must lie in [0, %.10g] m/s: let it join at another speed",
    "insert_gap": "a vehicle cannot join at place %d with a gap of %.10g m at %.10g m/s, where T = %.10g s would not "
    "be below T_max (Lemma 1): a gap of %.10g m would do",
    "insert_none": "a vehicle cannot join at place %d with a gap of %.10g m at %.10g m/s, where T = %.10g s would not "
    "be below T_max (Lemma 1): no gap would do there now, let it join at another place, speed or time",
    "wave": "a wave from %.10g to %.10g m/s with a period of %.10g s is none: choose 0 <= v_low <= v_high and "
    "a period above 0 s",
    "profile_file": "the speed profile %s cannot be read (%s): give a CSV file with time [s] and speed [m/s]",
    "profile_line": "line %d of the speed profile %s, '%s', is not two numbers with a comma between them: write time "
    "[s] and speed [m/s]",
    "profile_rows": "the speed profile %s has %d rows of time and speed: give it at least 2",
    "profile_time": "time %.10g s in row %d of the speed profile %s does not come after %.10g s: let times increase",
    "profile_speed": "speed %.10g m/s in row %d of the speed profile %s must lie in [0, %.10g] m/s: use a part of the "
    "profile that does, with speeds in m/s",
    "periods": "%.10g s are more sampling periods of T = %.10g s than can be counted: take a shorter time or a "
    "longer T",
    "short_periods": "more than max_short_periods = %d short sampling periods in one communication step, at "
    "t = %.10g s with T_max = %.10g s: raise max_short_periods, take shorter communication "
    "steps, or start further from L",
}


def _filled(sentence: str, values: tuple[Any, ...]) -> str:
    """A sentence with its values; where numbers that differ would look alike ("35 is above 35"), all with 17 digits.

    fmu_src/c/front_log.c does the same.
    """
    conversions = re.findall(r"%(?:\.10g|d|s|%)", sentence)
    places = zip((one for one in conversions if one != "%%"), values, strict=True)
    numbers = [float(value) for conversion, value in places if conversion == "%.10g"]
    if any((a < b or a > b) and f"{a:.10g}" == f"{b:.10g}" for a, b in combinations(numbers, 2)):
        sentence = sentence.replace("%.10g", "%.17g")
    return sentence % values


class ModelError(ValueError):
    """A value outside the model's domain; the message is one sentence with value, unit, limit and remedy."""

    def __init__(self, key: str, *values: object):
        super().__init__(_filled(SENTENCES[key], values))
        self.key = key
