"""The platoon model of Tzortzoglou et al. and everything computed with it; knows nothing of FMI."""

from .batch import Runs, simulate_many
from .errors import ModelError, PspError
from .law.controller import Controller, PaperLaw
from .law.feedback import feedback
from .law.potential import BEST_FIXED, V_OLD, Potential, PotentialParameters, potential, potential_slope
from .parameters import ObjectiveWeights, PlatoonParameters
from .platoon import SampledPlatoon
from .run import Run
from .sampling.hold import Plant
from .sampling.lemma1 import largest_period
from .sampling.policy import Lemma1Policy, Sampling
from .selection.feasible import max_slope, project, require_feasible
from .selection.rollout import rollout_costs
from .selection.selectors import BestOfRollouts, Fixed, FromNetwork, Selection, Selector
from .simulate import simulate
from .state import PlatoonState, StartDomain
from .validate import validate

__all__ = [
    "BEST_FIXED",
    "V_OLD",
    "BestOfRollouts",
    "Controller",
    "Fixed",
    "FromNetwork",
    "Lemma1Policy",
    "ModelError",
    "ObjectiveWeights",
    "PaperLaw",
    "Plant",
    "PlatoonParameters",
    "PlatoonState",
    "Potential",
    "PotentialParameters",
    "PspError",
    "Run",
    "Runs",
    "SampledPlatoon",
    "Sampling",
    "Selection",
    "Selector",
    "StartDomain",
    "feedback",
    "largest_period",
    "max_slope",
    "potential",
    "potential_slope",
    "project",
    "require_feasible",
    "rollout_costs",
    "simulate",
    "simulate_many",
    "validate",
]
