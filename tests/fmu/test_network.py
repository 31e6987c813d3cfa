"""Where alpha, r, p come from."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import onnxruntime

from harness import OK, WARNING, random_start, starts
from psp_model import PlatoonParameters, PotentialParameters, project, require_feasible

ONNX = Path(__file__).parents[2] / "onnx" / "platoon_7.onnx"


def test_the_network_in_the_fmu_gives_what_onnxruntime_gives_projected(instances):
    session = onnxruntime.InferenceSession(ONNX)
    for seed in range(5):
        s, v = random_start(seed)
        instance = instances()
        assert instance.initialise(starts(s, v)) == OK
        row = np.array([[*s, *v]], dtype=np.float32)
        (raw,) = session.run(["parameters"], {"initial_condition": row})
        expected = project(PotentialParameters(*map(float, raw[0])), PlatoonParameters())
        np.testing.assert_allclose(instance.get("alpha", "r", "p"), [expected.alpha, expected.r, expected.p], rtol=1e-6)
        require_feasible(PotentialParameters(*instance.get("alpha", "r", "p")), PlatoonParameters())
        assert instance.get("network_in_domain") == [1.0]


def test_outside_the_domain_the_fallback_is_used_with_a_warning(instance):
    s, v = random_start(1)
    s[2] = 30.0
    fixed = {"alpha_fixed": 2e-3, "r_fixed": 12.0, "p_fixed": 5.0}
    assert instance.initialise(starts(s, v) | fixed) == OK
    assert instance.get("network_in_domain", "alpha", "r", "p") == [0.0, 2e-3, 12.0, 5.0]
    assert any(status == WARNING and "training domain" in text for status, text in instance.messages)


def test_other_constants_than_the_networks_use_the_fallback_too(instance):
    assert instance.initialise({"mu": 0.6}) == OK
    assert instance.get("network_in_domain", "r") == [0.0, 11.0]
    assert "other constants" in instance.messages[-1][1]


def test_v_old_reports_that_it_has_no_hill(instance):
    assert instance.initialise({"potential": 1}) == OK
    assert instance.get("alpha", "r", "p") == [1.0, 0.0, 0.0]


def test_the_file_says_what_it_is():
    metadata = onnxruntime.InferenceSession(ONNX).get_modelmeta().custom_metadata_map
    assert json.loads(metadata["psp_vehicles"]) == 7
    assert {"gap_min", "gap_max", "speed_min", "speed_max"} <= json.loads(metadata["psp_domain"]).keys()
    assert len(metadata["psp_data_sha256"]) == 64


def test_rollouts_are_never_worse_than_the_network_alone(instances):
    for seed in (2, 3):
        s, v = random_start(seed)
        costs = []
        for source in (1, 3):
            instance = instances()
            assert instance.initialise(starts(s, v) | {"parameter_source": source, "rollout_count": 8}) == OK
            for k in range(20):
                assert instance.step(float(k), 1.0) == OK
            costs += instance.get("J")
        assert costs[1] <= costs[0] + 1e-9
