"""Several instances, and several different FMUs of ours, in one process."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from harness import OK, run
from psp_model import PlatoonParameters, project
from psp_model.selection.network import ParameterNetwork


def test_instances_of_one_fmu_are_independent(instances):
    alone, first, second = instances(), instances(), instances()
    assert alone.initialise() == OK
    expected = run(alone, 0, 20)
    assert first.initialise() == OK
    assert second.initialise({"potential": 1, "x_start": 50.0}) == OK
    seen = []
    for k in range(20):  # interleaved
        seen += run(first, k, 1)
        run(second, k, 1)
    assert seen == expected


def test_fmus_for_7_and_3_vehicles_do_not_run_each_others_code(instances, fmu_of_three):
    seven, three = instances(), instances(fmu_of_three)
    assert three.initialise() == OK
    assert seven.initialise() == OK
    for k in range(10):
        assert seven.step(k * 0.01, 0.01) == OK
        assert three.step(k * 0.01, 0.01) == OK
    assert len(seven.group("v")) == 7 and len(three.group("v")) == 3
    assert seven.get("network_in_domain") == three.get("network_in_domain") == [1.0]
    network = ParameterNetwork(Path(__file__).parents[2] / "onnx" / "platoon_any.onnx")
    given = {v.name: v.start for v in fmu_of_three.description.modelVariables}
    s, v = ([float(given[name]) for name in given if name.startswith(kind)] for kind in ("s_start", "v_start"))
    chosen = project(network.evaluate(s, v), PlatoonParameters())
    np.testing.assert_allclose(three.get("alpha", "r", "p"), [chosen.alpha, chosen.r, chosen.p], rtol=1e-9)


def test_many_instances_come_and_go(instances, fmu):
    from harness import Instance

    for _ in range(30):
        instance = Instance(fmu)
        assert instance.initialise({"parameter_source": 2}) == OK
        assert instance.step(0.0, 0.01) == OK
        instance.close()
