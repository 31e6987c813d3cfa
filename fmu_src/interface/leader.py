"""The table of FMI variables of `PspLeader`."""

from __future__ import annotations

from psp_model.sampling.policy import Sampling
from psp_model.vehicles.leader import Wave

from .variables import Variable

_LEADER = "Speed and acceleration of a leader"


def description(profile: str | None = None) -> str:
    """One sentence on a leader.

    Parameters
    ----------
    profile : name of the file with the speeds that he drives, None for the wave
    """
    return f"{_LEADER} who follows {profile}" if profile else f"{_LEADER}, steady or on a stop-and-go wave"


def leader_table(profile: bool = False) -> tuple[Variable, ...]:
    """The variables of `PspLeader`: a leader's speed over time, and his acceleration.

    Parameters
    ----------
    profile : whether the FMU carries a speed profile, which takes the place of the wave

    Returns
    -------
    tuple of Variable (ours)
    """
    text = "How long a is meant to be held, above 0: the plant's period"
    period = Variable("T", text, "s", Sampling().T, 0, nominal=0.01)
    text = "Acceleration of the leader: held for T, it takes him from the speed now to that T later"
    himself = (
        "0: the leader drives himself; for automated[i] of controller and plant, where vehicle i has his acceleration"
    )
    motion = (
        Variable("v", "Speed of the leader", "m/s", nominal=30, continuous=True),
        Variable("a", text, "m/s2", nominal=1, continuous=True),
        Variable("automated", himself, minimum=0, maximum=0, initial_dependencies=()),
    )
    if profile:
        text = "When the profile begins, with its first row; before and after it the first and the last speed are held"
        return period, Variable("begin", text, "s", 0.0, nominal=10), *motion
    wave = Wave()
    return (
        period,
        Variable("v_high", "Speed before and at the top of the wave", "m/s", wave.high, 0, nominal=30),
        Variable(
            "v_low", "Speed at the bottom of the wave, at most v_high; v_high for none", "m/s", wave.low, 0, None, 30
        ),
        Variable("begin", "When the first braking begins", "s", wave.begin, nominal=10),
        Variable("period", "Period of the wave, above 0", "s", wave.period, 0, nominal=40),
        *motion,
    )
