"""The platoon model of Tzortzoglou et al. and everything computed with it; knows nothing of FMI."""

from .batch import Runs, simulate_many
from .chosen import project_networks
from .controller import BadMeasurement, Command, ControllerSettings, Measurement, SampledController
from .errors import ModelError, PspError
from .law.controller import Controller, PaperLaw
from .law.cooperation import Cooperation, Traffic
from .law.extended import DrivenLeader, ExtendedLaw
from .law.potential import BEST_FIXED, V_OLD, Potential, PotentialParameters
from .membership import OpenPlatoon, Refusal
from .parameters import Actuation, ObjectiveWeights, PlatoonParameters
from .platoon import SampledPlatoon
from .public import (
    brake_margin,
    cooperative_command,
    exact_period,
    feedback,
    largest_period,
    potential,
    potential_slope,
    uncertain_period,
)
from .run import Run
from .sampling.hold import Plant
from .sampling.policy import Certificate, Lemma1Policy, Sampling
from .sampling.uncertain import Errors
from .selection.feasible import max_slope, project, require_feasible
from .selection.network import ParameterNetwork
from .selection.rollout import rollout_costs
from .selection.selectors import BestOfRollouts, Fixed, FromNetwork, Old, ParameterSource, Request, Selection, Selector
from .simulate import simulate
from .state import PlatoonState, StartDomain
from .validate import validate
from .vehicles.braking import Braking
from .vehicles.delayed import DelayedVehicles
from .vehicles.ideal import IdealPlant
from .vehicles.leader import Profile, Wave, read_profile
from .vehicles.road_law import RoadLaw, Seen
from .vehicles.road_plant import RoadPlant

__all__ = [
    "BEST_FIXED",
    "V_OLD",
    "Actuation",
    "BadMeasurement",
    "BestOfRollouts",
    "Braking",
    "Certificate",
    "Command",
    "Controller",
    "ControllerSettings",
    "Cooperation",
    "DelayedVehicles",
    "DrivenLeader",
    "Errors",
    "ExtendedLaw",
    "Fixed",
    "FromNetwork",
    "IdealPlant",
    "Lemma1Policy",
    "Measurement",
    "ModelError",
    "ObjectiveWeights",
    "Old",
    "OpenPlatoon",
    "PaperLaw",
    "ParameterNetwork",
    "ParameterSource",
    "Plant",
    "PlatoonParameters",
    "PlatoonState",
    "Potential",
    "PotentialParameters",
    "Profile",
    "PspError",
    "Refusal",
    "Request",
    "RoadLaw",
    "RoadPlant",
    "Run",
    "Runs",
    "SampledController",
    "SampledPlatoon",
    "Sampling",
    "Seen",
    "Selection",
    "Selector",
    "StartDomain",
    "Traffic",
    "Wave",
    "brake_margin",
    "cooperative_command",
    "exact_period",
    "feedback",
    "largest_period",
    "max_slope",
    "potential",
    "potential_slope",
    "project",
    "project_networks",
    "read_profile",
    "require_feasible",
    "rollout_costs",
    "simulate",
    "simulate_many",
    "uncertain_period",
    "validate",
]
