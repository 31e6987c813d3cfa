"""The platoon model of Tzortzoglou et al. and everything computed with it; knows nothing of FMI."""

from .batch import Runs, simulate_many
from .errors import ModelError, PspError
from .law.controller import Controller, PaperLaw
from .law.cooperation import Cooperation, Traffic, cooperative_command
from .law.feedback import feedback
from .law.potential import BEST_FIXED, V_OLD, Potential, PotentialParameters, potential, potential_slope
from .parameters import Actuation, ObjectiveWeights, PlatoonParameters
from .platoon import SampledPlatoon
from .run import Run
from .sampling.exact import exact_period
from .sampling.hold import Plant
from .sampling.lemma1 import largest_period
from .sampling.policy import Lemma1Policy, Sampling
from .sampling.uncertain import Errors, uncertain_period
from .selection.feasible import max_slope, project, require_feasible
from .selection.rollout import rollout_costs
from .selection.selectors import BestOfRollouts, Fixed, FromNetwork, Selection, Selector
from .simulate import simulate
from .state import PlatoonState, StartDomain
from .validate import validate
from .vehicles.braking import Braking, brake_margin
from .vehicles.delayed import DelayedVehicles
from .vehicles.road_law import RoadLaw, Seen

__all__ = [
    "BEST_FIXED",
    "V_OLD",
    "Actuation",
    "BestOfRollouts",
    "Braking",
    "Controller",
    "Cooperation",
    "DelayedVehicles",
    "Errors",
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
    "RoadLaw",
    "Run",
    "Runs",
    "SampledPlatoon",
    "Sampling",
    "Seen",
    "Selection",
    "Selector",
    "StartDomain",
    "Traffic",
    "brake_margin",
    "cooperative_command",
    "exact_period",
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
    "uncertain_period",
    "validate",
]
