"""The table of FMI variables of `PspLeader`."""

from __future__ import annotations

from psp_model.vehicles.leader import Wave

from .variables import Variable

DESCRIPTION = "The speed of a leader"


def leader_table(profile: bool = False) -> tuple[Variable, ...]:
    """The variables of `PspLeader`: a leader's speed over time.

    Parameters
    ----------
    profile : whether the FMU carries a speed profile, which takes the place of the wave

    Returns
    -------
    tuple of Variable (ours)
    """
    speed = Variable("v", "Speed of the leader", "m/s", nominal=30, continuous=True)
    if profile:
        text = "When the profile begins, with its first row; before and after it the first and the last speed are held"
        return Variable("begin", text, "s", 0.0, nominal=10), speed
    wave = Wave()
    return (
        Variable("v_high", "Speed before and at the top of the wave", "m/s", wave.high, 0, nominal=30),
        Variable(
            "v_low", "Speed at the bottom of the wave, at most v_high; v_high for none", "m/s", wave.low, 0, None, 30
        ),
        Variable("begin", "When the first braking begins", "s", wave.begin, nominal=10),
        Variable("period", "Period of the wave, above 0", "s", wave.period, 0, nominal=40),
        speed,
    )
