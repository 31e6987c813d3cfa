"""For each public class of the model an object, and what that object does: what the tests of pickling send round."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from psp_model import (
    BEST_FIXED,
    V_OLD,
    Actuation,
    BestOfRollouts,
    Certificate,
    DelayedVehicles,
    Fixed,
    FromNetwork,
    Lemma1Policy,
    ModelError,
    ObjectiveWeights,
    PaperLaw,
    PlatoonParameters,
    PlatoonState,
    PotentialParameters,
    PspError,
    SampledPlatoon,
    Sampling,
    Selection,
    StartDomain,
    simulate,
    simulate_many,
)
from psp_model.analysis.cases import Case, Setup, run_case
from psp_model.analysis.curves import curve
from psp_model.analysis.landscape import Landscape
from psp_model.analysis.response import Choice, respond
from psp_model.controller import (
    BadMeasurement,
    ControllerSettings,
    Decision,
    Measurement,
    SampledController,
    no_command,
)
from psp_model.controller import decide as decide_measured
from psp_model.figures import Figure
from psp_model.membership import JoinMargin, OpenPlatoon, Refusal
from psp_model.quantities import quantity_of
from psp_model.sampling.clock import Clock
from psp_model.sampling.hold import IDEAL
from psp_model.sampling.loop import begin, step
from psp_model.selection.network import ParameterNetwork, read_networks
from psp_model.selection.selectors import Old, ParameterSource, Request
from psp_model.vehicles.ideal import STOPPING, IdealPlant
from psp_model.vehicles.leader import Profile, Wave
from road_examples import PAIR, ROAD_EXAMPLES, Example, delayed, itself, rode

NETWORKS = Path(__file__).parents[1] / "onnx"
HEARD: list[str] = []


def hear(sentence: str) -> None:
    HEARD.append(sentence)


def fixed(s: Any, v: Any) -> PotentialParameters:
    """The potential of an open platoon."""
    return BEST_FIXED


def plain(one: Any) -> Any:
    """What is equal for objects of the same content: numbers with all their bits, arrays with their shapes."""
    if isinstance(one, np.ndarray):
        return one.dtype.str, one.shape, one.tobytes()
    if isinstance(one, float):
        return type(one), float(one).hex()
    if isinstance(one, ParameterNetwork):
        return one.path, one._content
    if isinstance(one, Enum) or callable(one):
        return one
    if isinstance(one, BaseException):
        return type(one), str(one), plain(vars(one))
    if is_dataclass(one):
        return type(one), [plain(getattr(one, field.name)) for field in fields(one) if field.name != "warn"]
    if isinstance(one, Mapping):
        return {key: plain(value) for key, value in one.items()}
    return (type(one), [plain(item) for item in one]) if isinstance(one, Sequence) and not isinstance(one, str) else one


def start_of(vehicles: int, seed: int, constants: PlatoonParameters | None = None) -> PlatoonState:
    s, v = StartDomain().draw(np.random.default_rng(seed), vehicles, 1)
    return PlatoonState(s[:, 0], v[:, 0], constants or PlatoonParameters(), x_leader=-3.7)


def platoon(policy: Lemma1Policy = Lemma1Policy.ERROR, T: float = 0.01, warn: Any = hear) -> SampledPlatoon:
    """A platoon between two sampling instants; under policy 2 with T = 0.08 s it warns two periods later."""
    old = policy is Lemma1Policy.SHORTEN
    made = SampledPlatoon.begin(start_of(4, 3), V_OLD if old else BEST_FIXED, sampling=Sampling(T, policy), warn=warn)
    made.advance_to(7, 0.3)
    return made


def future(made: SampledPlatoon) -> list[Any]:
    """All that a platoon does in the next 40 periods and a bit."""
    seen: list[Any] = [made.observe(made.now.period, 0.9)]
    heard = len(HEARD)
    for period in range(made.now.period + 1, made.now.period + 40):
        made.advance_to(period, 0.37)
        seen += [made.observe(period, 0.37), made.now]
    return [*seen, HEARD[heard:]]


def controller(**settings: Any) -> SampledController:
    """A controller that has decided a few times, once on bad measurements."""
    networks = read_networks(NETWORKS, {7: "platoon_7_mse.onnx"})
    told = ControllerSettings(
        7, bad_input=BadMeasurement.SAFE_ACTION, actuation=Actuation(a_min=-8.0, a_max=3.0), **settings
    )
    made = SampledController.begin(told, networks, hear)
    decisions(made, range(3))
    return made


def decisions(made: SampledController, rows: range = range(3, 12)) -> list[Any]:
    seen: list[Any] = []
    for row in rows:
        s, v = StartDomain().draw(np.random.default_rng(row), 7, 1)
        n = (7, 4, 9)[row % 3]  # for 4 there is no network, and 9 are more than there are
        made.sample(0.01 * row, Measurement(s[:, 0], v[:, 0], n, resolve=row % 2, v_desired=(None, 25.0)[row % 2]))
        seen.append(made.now)
    return seen


def opened(name: str) -> ParameterNetwork:
    network = ParameterNetwork(NETWORKS / name)
    answers_of(network)
    return network


def answers_of(network: ParameterNetwork) -> list[Any]:
    n = max(network.vehicles)
    s, v = StartDomain().draw(np.random.default_rng(n), n, 1)
    asked = [network.evaluate(s[:, 0], v[:, 0]), network.candidates(s[:, 0], v[:, 0], 5)]
    return [*asked, network.domain, network.constants, network.trained_on, network.ranks, list(network.vehicles)]


def driven(plant: IdealPlant) -> Any:
    plant = plant.advanced_to(plant.period + 5, np.array([0.3, -1.0, 0.7]))
    return plant.now, plant.now.positions(), plant.period


def plant() -> IdealPlant:
    return IdealPlant.begin(start_of(3, 8), 0.05).advanced_to(3, np.array([-0.1, 0.2, 0.0]))


def open_platoon() -> OpenPlatoon:
    made, refused = OpenPlatoon.begin(platoon(), 6, fixed).insert(4, 12.0, 30.0, 7, 0.3)
    assert refused is None
    return made


def changes(made: OpenPlatoon) -> list[Any]:
    _, refused = made.insert(1, 0.5, 30.0, 7, 0.3)
    made.platoon.advance_to(20, 0.0)
    after, left = made.remove(2, 20, 0.0)
    return [refused, left, after.vehicles, future(after.platoon)]


def pair_of(start: PlatoonState) -> tuple[Any, Any]:
    return start.s, start.v


def commands(made: Any) -> list[Any]:
    """What a controller decides at two instants."""
    memory, first = made.decide(None, *PAIR)
    return [memory, first, made.decide(memory, PAIR[0] - 0.1, PAIR[1] + 0.1)]


def decision() -> Decision:
    """One that is not certified, for vehicles for which there is no network."""
    settings = ControllerSettings(4, sampling=Sampling(0.5, Lemma1Policy.WARN))
    return decide_measured(settings, FromNetwork({}), {}, no_command(settings), 1.5, Measurement(*PAIR, 3))


def selected(made: Any) -> list[Any]:
    return [made.select(*pair_of(start_of(7, seed)), PlatoonParameters()) for seed in range(2)]


def case() -> Case:
    request = Request(source=ParameterSource.FIXED)
    return run_case("mine", Setup(start_of(3, 4), request, ObjectiveWeights(), Sampling()), None, 0.2)


def speeds(leader: Any) -> list[float]:
    return [leader.speed(time) for time in np.linspace(-1.0, 60.0, 50)]


def refused() -> ModelError:
    with pytest.raises(ModelError) as caught:
        platoon(T=0.5)
    return caught.value


EXAMPLES: dict[str, Example] = {
    "PlatoonParameters": (lambda: PlatoonParameters(L=4.1, lam=17.3), itself),
    "ObjectiveWeights": (lambda: ObjectiveWeights(w1=0.1, s_ref=7.0), itself),
    "PotentialParameters": (lambda: PotentialParameters(0.002, 9.7, 5.1), itself),
    "PlatoonState": (lambda: start_of(7, 2), lambda made: simulate(made, BEST_FIXED, duration=0.3)),
    "StartDomain": (lambda: StartDomain(gap_min=9.0), lambda made: made.draw(np.random.default_rng(1), 4, 3)),
    "Sampling": (lambda: Sampling(0.02, Lemma1Policy.SHORTEN, 7), itself),
    "Lemma1Policy": (lambda: Lemma1Policy.WARN, itself),
    "policy.Certificate": (lambda: Certificate.EXACT, itself),
    "ParameterSource": (lambda: ParameterSource.ROLLOUT, itself),
    "BadMeasurement": (lambda: BadMeasurement.SAFE_ACTION, itself),
    "ModelError": (refused, itself),
    "PspError": (lambda: PspError("T = 1 s is long", "take less"), itself),
    "Run": (lambda: simulate(start_of(3, 1), V_OLD, duration=0.4, output_step=0.03), lambda made: (made.J, made)),
    "SampledPlatoon": (platoon, future),
    "SampledPlatoon, policy 2": (lambda: platoon(Lemma1Policy.WARN, 0.08), future),
    "SampledPlatoon, policy 3": (lambda: platoon(Lemma1Policy.SHORTEN, 0.06), future),
    "Instant": (lambda: platoon().now, itself),
    "Observation": (lambda: platoon().observe(7, 0.5), itself),
    "OpenPlatoon": (open_platoon, changes),
    "JoinMargin": (lambda: JoinMargin(3.0, -6.0), itself),
    "Refusal": (lambda: Refusal("too near: stay away", 12.5), itself),
    "Request": (lambda: Request(source=ParameterSource.ROLLOUT, rollouts=3), itself),
    "ControllerSettings": (lambda: ControllerSettings(5, a_safe=-1.5), itself),
    "Measurement": (lambda: Measurement(np.array([9.0]), np.array([30.0, 29.0]), 2.0), itself),
    "Command": (lambda: controller().now, itself),
    "Basis": (lambda: controller().now.basis, itself),
    "SampledController": (controller, decisions),
    "SampledController, rollouts": (
        lambda: controller(request=Request(source=ParameterSource.ROLLOUT, rollouts=2, horizon=0.1)),
        decisions,
    ),
    "ParameterNetwork": (lambda: opened("platoon_any.onnx"), answers_of),
    "ParameterNetwork, not yet read": (lambda: ParameterNetwork(NETWORKS / "platoon_7_mse.onnx"), answers_of),
    "networks": (
        lambda: {7: opened("platoon_7.onnx"), 4: ParameterNetwork(NETWORKS / "platoon_4_alone.onnx")},
        lambda made: {n: answers_of(network) for n, network in made.items()},
    ),
    "Wave": (lambda: Wave(31.0, 22.0, 4.0, 30.0), speeds),
    "Profile": (lambda: Profile([0.0, 4.0, 50.0], [30.0, 21.5, 33.0], "mine"), speeds),
    "Clock": (
        lambda: Clock.begin(3.5, 0.002, 0.01).after(3.5, 0.037, 0.01),
        lambda made: made.after(3.537, 0.02, 0.01),
    ),
    "IdealPlant": (plant, driven),
    "Motion": (lambda: plant().now, lambda made: IDEAL.advance(made, np.array([1.0, 0.0, -1.0]), 0.3)),
    # the law, and the loop around it
    "PaperLaw": (lambda: PaperLaw(BEST_FIXED, PlatoonParameters(mu=0.4)), commands),
    "Loop": (lambda: platoon().loop, lambda made: step(made, platoon().now)),
    "loop.Verdict": (lambda: begin(platoon(T=0.01).loop, 0.0, *pair_of(start_of(3, 1)))[1], itself),
    "DoubleIntegrators": (lambda: IDEAL, rode),
    "StoppingIntegrators": (lambda: STOPPING, rode),
    "DelayedVehicles": (lambda: DelayedVehicles(Actuation(0.03, 0.2)), rode),
    "Delayed": (delayed, lambda made: DelayedVehicles(Actuation(0.03, 0.2)).advance(made, np.zeros(3), 0.02)),
    "deciding.Verdict": (lambda: decision().verdict, itself),
    "Decision": (lambda: decision(), itself),
    # selection
    "Selection": (lambda: Selection(BEST_FIXED, warning="too far: come nearer"), itself),
    "Old": (Old, selected),
    "Fixed": (lambda: Fixed(PotentialParameters(0.002, 12.0, 4.5)), selected),
    "FromNetwork": (lambda: FromNetwork({7: opened("platoon_7.onnx")}), selected),
    "BestOfRollouts": (
        lambda: BestOfRollouts({7: opened("platoon_7.onnx")}, rollouts=2, horizon=0.1),
        selected,
    ),
    # what runs come to
    "Runs": (lambda: simulate_many([start_of(3, 1), start_of(3, 2)], V_OLD, duration=0.3), lambda made: (made.J, made)),
    "Figure": (lambda: Figure("smallest spacing", "m", 7.9), itself),
    "Quantity": (lambda: quantity_of("lam"), itself),
    "Setup": (lambda: case().setup, lambda made: run_case("again", made, None, 0.2)),
    "Case": (lambda: case(), lambda made: made.certificate),
    "Certificate": (lambda: case().certificate, lambda made: (made.tightest, made.who(3), made.refused())),
    "Curve": (lambda: curve(BEST_FIXED, PlatoonParameters()), itself),
    "Landscape": (
        lambda: Landscape(1e-3, np.array([10.0, 11.0]), np.array([5.0]), np.array([[3.0, np.nan]])),
        lambda made: made.best,
    ),
    "Choice": (lambda: Choice(False, 1e-3, 11.0, 5.5, (9.0, 10.0), (30.0, 31.0, 29.0)), lambda made: made.shape),
    "Response": (
        lambda: respond(Choice(False, 1e-3, 11.0, 9.0, (9.0,), (30.0, 31.0)), PlatoonParameters(), 0.1),
        itself,
    ),
} | ROAD_EXAMPLES
"""By the name of the class; classes of one name say their module too, objects of one class what they differ in."""
