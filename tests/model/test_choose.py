"""Which potential a platoon gets: networks where they were trained, else the fixed triple, always with a reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from psp_model import BEST_FIXED, ModelError, PlatoonState
from psp_model.parameters import ObjectiveWeights, PlatoonParameters
from psp_model.platoon import Sampling
from psp_model.selection.choose import ParameterSource, Request, choose_for_any_number, choose_potential
from psp_model.selection.network import ParameterNetwork

ONNX = Path(__file__).parents[2] / "onnx"
HOW = (ObjectiveWeights(), Sampling())
SPEEDS = np.full(7, 30.0)


@pytest.fixture
def heard() -> list[str]:
    return []


def test_asking_for_a_network_that_is_not_there_is_one_sentence(heard):
    with pytest.raises(ModelError, match=r"no network for 7 vehicles.*parameter_source 2"):
        choose_potential(PlatoonState(np.full(6, 10.0), SPEEDS), Request(), None, *HOW, heard.append)


@pytest.mark.parametrize(
    "gap, constants, reason",
    [
        (12.5, PlatoonParameters(), "outside the network's training domain"),
        (10.0, PlatoonParameters(mu=0.6), "other constants"),
    ],
)
@pytest.mark.parametrize("source", [ParameterSource.NETWORK, ParameterSource.ROLLOUT])
def test_outside_its_training_a_network_is_not_asked(heard, gap, constants, reason, source):
    start = PlatoonState(np.full(6, gap), SPEEDS, constants)
    network = ParameterNetwork(ONNX / "platoon_7.onnx")
    assert choose_potential(start, Request(source=source), network, *HOW, heard.append) == BEST_FIXED
    assert len(heard) == 1 and reason in heard[0] and "alpha = 0.001" in heard[0]


@pytest.mark.parametrize("n", [2, 12, 13])
def test_the_network_for_any_number_ends_at_12_vehicles(heard, n):
    networks = dict.fromkeys(range(2, 13), ParameterNetwork(ONNX / "platoon_any.onnx"))
    s, v = np.full(n - 1, 10.0), np.full(n, 30.0)
    shape, in_domain = choose_for_any_number(s, v, PlatoonParameters(), Request(), networks, *HOW, heard.append)
    assert in_domain is (n <= 12)
    assert (shape == BEST_FIXED) is (n == 13)
    assert [("13 vehicles" in sentence) for sentence in heard] == [True] * (n == 13)


def test_a_network_that_ranks_nothing_has_one_candidate():
    network = ParameterNetwork(ONNX / "platoon_7_mse.onnx")
    gaps = np.full(6, 10.0)
    assert network.candidates(gaps, SPEEDS, 16) == [network.evaluate(gaps, SPEEDS)]
