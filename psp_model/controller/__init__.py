"""The feedback law as a controller of measured vehicles: spacings and speeds in, accelerations out."""

from .deciding import Decision, Verdict, decide
from .decision import Basis, Command, followed_of, is_certified, margin_of, no_command
from .measurement import Measurement
from .sampled import SampledController
from .settings import PREDICTED_AGE, BadMeasurement, ControllerSettings

__all__ = [
    "PREDICTED_AGE",
    "BadMeasurement",
    "Basis",
    "Command",
    "ControllerSettings",
    "Decision",
    "Measurement",
    "SampledController",
    "Verdict",
    "decide",
    "followed_of",
    "is_certified",
    "margin_of",
    "no_command",
]
