"""Which potential a platoon gets: networks where they were trained, else the fixed triple, always with a reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from psp_model import BEST_FIXED, ModelError, PlatoonState
from psp_model.parameters import ObjectiveWeights, PlatoonParameters
from psp_model.sampling.policy import Sampling
from psp_model.selection.network import ParameterNetwork
from psp_model.selection.selectors import FromNetwork, ParameterSource, Request, select_for

ONNX = Path(__file__).parents[2] / "onnx"
HOW = (ObjectiveWeights(), Sampling())
SPEEDS = np.full(7, 30.0)


def test_asking_for_a_network_that_is_not_there_is_one_sentence():
    with pytest.raises(ModelError, match=r"no network for 7 vehicles.*parameter_source 2"):
        select_for(PlatoonState(np.full(6, 10.0), SPEEDS), Request(), None, *HOW)


@pytest.mark.parametrize(
    "spacing, constants, reason",
    [
        (12.5, PlatoonParameters(), "outside the network's training domain"),
        (10.0, PlatoonParameters(mu=0.6), "other constants"),
    ],
)
@pytest.mark.parametrize("source", [ParameterSource.NETWORK, ParameterSource.ROLLOUT])
def test_outside_its_training_a_network_is_not_asked(spacing, constants, reason, source):
    start = PlatoonState(np.full(6, spacing), SPEEDS, constants)
    network = ParameterNetwork(ONNX / "platoon_7.onnx")
    selection = select_for(start, Request(source=source), network, *HOW)
    assert selection.potential == BEST_FIXED and not selection.by_network
    assert reason in selection.warning and "alpha = 0.001" in selection.warning


@pytest.mark.parametrize("n", [2, 12, 13])
def test_the_network_for_any_number_ends_at_12_vehicles(n):
    networks = dict.fromkeys(range(2, 13), ParameterNetwork(ONNX / "platoon_any.onnx"))
    s, v = np.full(n - 1, 10.0), np.full(n, 30.0)
    selection = FromNetwork(networks).select(s, v, PlatoonParameters())
    assert selection.by_network is (n <= 12)
    assert (selection.potential == BEST_FIXED) is (n == 13)
    assert ("13 vehicles" in (selection.warning or "")) is (n == 13)


def test_a_network_that_ranks_nothing_has_one_candidate():
    network = ParameterNetwork(ONNX / "platoon_7_mse.onnx")
    spacings = np.full(6, 10.0)
    assert network.candidates(spacings, SPEEDS, 16) == [network.evaluate(spacings, SPEEDS)]
