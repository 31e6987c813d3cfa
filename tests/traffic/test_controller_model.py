"""The controller and the ideal plant without FMI are the sampled platoon."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from psp_model import BEST_FIXED, Lemma1Policy, ModelError, PlatoonParameters, PlatoonState, Sampling, simulate
from psp_model.controller import ControllerSettings, Measurement, SampledController
from psp_model.selection.selectors import ParameterSource, Request
from psp_model.vehicles.ideal import IdealPlant
from strategies import paper_start

T = 0.01


@pytest.mark.parametrize("old", [False, True])
@pytest.mark.parametrize("vehicles", [2, 5, 12])
def test_controller_and_plant_are_the_platoon(vehicles, old):
    request = Request(old=old, source=ParameterSource.FIXED)
    controller = SampledController.begin(ControllerSettings(vehicles, request=request))
    start = PlatoonState(*paper_start(vehicles, vehicles), x_leader=-4.0)
    plant = IdealPlant.begin(start, T)
    run = simulate(start, controller.now.shape if old else BEST_FIXED, duration=10.0)
    for k in range(1000):
        controller.sample(k * T, Measurement(plant.now.s, plant.now.v, vehicles))
        np.testing.assert_allclose(plant.now.positions(), run.x[k], rtol=0, atol=1e-9)
        np.testing.assert_allclose(controller.now.a, run.a[k], rtol=0, atol=1e-9)
        assert controller.now.T_max == pytest.approx(run.T_max[k], abs=1e-9)
        plant = plant.advanced_to(k + 1, controller.now.a)


@pytest.mark.parametrize("policy", [Lemma1Policy.ERROR, Lemma1Policy.WARN])
def test_an_instant_that_lemma_1_does_not_cover_is_an_error_or_counted_and_warned_of_once(policy):
    warned: list[str] = []
    fixed = Request(source=ParameterSource.FIXED)
    settings = ControllerSettings(2, request=fixed, sampling=Sampling(T, policy))
    controller = SampledController.begin(settings, warn=warned.append)
    close = Measurement(np.array([5.2]), np.array([30.0, 30.0]), 2)  # T_max is at most 0.2 m / 35 m/s
    if policy is Lemma1Policy.ERROR:
        with pytest.raises(ModelError, match="T_max"):
            controller.sample(0.0, close)
        return
    for k in range(3):
        controller.sample(k * T, close)
    assert controller.now.violations == 3 and len(warned) == 1 and controller.now.T_max < T


def test_a_desired_speed_moves_the_equilibrium():
    settings = ControllerSettings(1, PlatoonParameters(), request=Request(source=ParameterSource.FIXED))
    controller, v = SampledController.begin(settings), np.array([30.0])
    for k in range(3000):
        controller.sample(k * T, replace(Measurement(np.empty(0), v, 1), v_desired=17.0))
        v = v + T * controller.now.a
    assert v[0] == pytest.approx(17.0, abs=1e-3)
