"""The platoon model of Tzortzoglou et al. and everything computed with it; knows nothing of FMI."""

from .errors import ModelError, PspError
from .law.feedback import feedback
from .law.potential import potential, potential_slope
from .parameters import BEST_FIXED, V_OLD, ObjectiveWeights, PlatoonParameters, PotentialParameters
from .platoon import Lemma1Policy, SampledPlatoon, Sampling
from .sampling.lemma1 import largest_period
from .selection.feasible import max_slope, project, require_feasible
from .simulate import Run, simulate
from .state import PlatoonState, StartDomain

__all__ = [
    "BEST_FIXED",
    "V_OLD",
    "Lemma1Policy",
    "ModelError",
    "ObjectiveWeights",
    "PlatoonParameters",
    "PlatoonState",
    "PotentialParameters",
    "PspError",
    "Run",
    "SampledPlatoon",
    "Sampling",
    "StartDomain",
    "feedback",
    "largest_period",
    "max_slope",
    "potential",
    "potential_slope",
    "project",
    "require_feasible",
    "simulate",
]
