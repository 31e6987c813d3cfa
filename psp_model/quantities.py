"""The quantities of the model: how each is written, in which unit, and what it is.

Units stand here once; the tables of FMI variables, the checks and all that prints a quantity use it.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """A quantity of the model.

    Attributes
    ----------
    name : as the FMI variable, without an index
    unit : SI unit, "1" for none
    symbol : as the paper writes it
    meaning : in a few words
    """

    name: str
    unit: str
    symbol: str
    meaning: str


_TABLE = (
    Quantity("T", "s", "T", "sampling period"),
    Quantity("L", "m", "L", "smallest allowable spacing"),
    Quantity("lambda", "m", "λ", "spacing at which the repulsion ends"),
    Quantity("v_star", "m/s", "v*", "desired cruising speed"),
    Quantity("v_max", "m/s", "v_max", "speed limit"),
    Quantity("epsilon", "m/s2", "ε", "width over which f is smoothed"),
    Quantity("mu", "1/s", "μ", "smallest feedback gain"),
    Quantity("z", "m/s2", "z", "limit of the slope of V_new on its hill"),
    Quantity("w1", "1", "w₁", "weight of acceleration in J"),
    Quantity("w2", "1", "w₂", "weight of the spacings in J"),
    Quantity("a_ref", "m/s2", "a_ref", "scale of acceleration in J"),
    Quantity("s_ref", "m", "s_ref", "scale of the spacings in J"),
    Quantity("kappa", "1/s", "κ", "viscosity at the smallest spacing"),
    Quantity("kappa_reach", "m", "κ_reach", "spacing at which viscosity has faded to 0"),
    Quantity("time_gap", "s", "h", "clearance per speed that counts as none"),
    Quantity("feedforward", "1", "φ", "share of the followed vehicle's acceleration that is commanded"),
    Quantity("closing_speed", "m/s", "c", "by how much a vehicle that closes up is faster than its predecessor"),
    Quantity("closing_spacing", "m", "c_spacing", "spacing at which closing up sets in"),
    Quantity("closing_reach", "m", "c_reach", "spacing at which closing up has faded to 0"),
    Quantity("length", "m", "l", "length of a vehicle"),
    Quantity("actuation_delay", "s", "θ", "time from a command to its first effect"),
    Quantity("actuator_lag", "s", "τ", "time constant of an actuator"),
    Quantity("a_min", "m/s2", "a_min", "smallest acceleration of a vehicle"),
    Quantity("a_max", "m/s2", "a_max", "largest acceleration of a vehicle"),
    Quantity("error_s", "m", "e_s", "bound on the error of measured spacings"),
    Quantity("error_v", "m/s", "e_v", "bound on the error of measured speeds"),
    Quantity("alpha", "1", "α", "scale of the repulsion"),
    Quantity("r", "m", "r", "where the hill begins"),
    Quantity("p", "1", "p", "exponent of the hill"),
    Quantity("x", "m", "x", "position"),
    Quantity("s", "m", "s", "spacing, front to front"),
    Quantity("v", "m/s", "v", "speed"),
    Quantity("a", "m/s2", "F", "commanded acceleration"),
    Quantity("T_max", "s", "T_max", "largest sampling period that Lemma 1 certifies"),
    Quantity("J", "1", "J", "objective"),
)

QUANTITIES = {quantity.name: quantity for quantity in _TABLE}

_ENDINGS = ("_start", "_fixed", "_measured", "_predicted")

FIELD_NAMES = {"lam": "lambda"}
"""Fields of the model's structs that cannot be called what the quantity is called: `lambda` is a keyword of Python."""


def quantity_of(field: str) -> Quantity:
    """The quantity that a field of a struct, or an FMI variable, holds.

    Parameters
    ----------
    field : name of the field, or of the variable with its index or with an ending such as `_start`

    Raises
    ------
    KeyError : where the table has no such quantity
    """
    name = field.split("[")[0]
    name = FIELD_NAMES.get(name, name)
    for ending in _ENDINGS:
        if name not in QUANTITIES:
            name = name.removesuffix(ending)
    return QUANTITIES[name]
