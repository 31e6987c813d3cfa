"""What stands behind the explorer's page."""

from __future__ import annotations

import numpy as np
import pytest

from psp_model import ModelError, PlatoonParameters, PlatoonState, PotentialParameters, require_feasible, simulate
from psp_model.analysis.response import Choice, feasible_edge, respond
from psp_view.explore.plots import feasible_plot, potential_plots, run_plots

PAPER = PlatoonParameters()
START = ((9.5, 11.0), (30.0, 31.0, 29.0))


def feasible(alpha: float, r: float, p: float) -> bool:
    try:
        require_feasible(PotentialParameters(alpha, r, p), PAPER)
    except ModelError:
        return False
    return True


def test_the_edge_parts_feasible_from_infeasible():
    for alpha in (1e-3, 1e-2):
        r, p = feasible_edge(alpha, PAPER, points=13)
        assert np.isfinite(p).any()
        for place, edge in zip(r.tolist(), p.tolist(), strict=True):
            if np.isnan(edge):
                assert not feasible(alpha, place, 3.0)
            else:
                assert feasible(alpha, place, edge) and (edge == 9.0 or not feasible(alpha, place, edge + 1e-6))


def test_the_response_is_the_models():
    found = respond(Choice(False, 1e-3, 11.0, 5.5, *START), PAPER, duration=2.0)
    run = simulate(PlatoonState(*map(np.array, START)), PotentialParameters(1e-3, 11.0, 5.5), duration=2.0)
    np.testing.assert_array_equal(found.run.s, run.s)
    assert found.problem == "" and {figure.label: figure.value for figure in found.figures}["J"] == run.J
    drawn = run_plots(found)
    assert drawn[0]["data"][1]["y"] == run.s[::4, 1].tolist() and drawn[1]["data"][2]["y"] == run.a[::4, 2].tolist()
    ends = potential_plots(found)[0]["data"][1]
    assert ends["x"] == run.s[-1].tolist()


def test_what_is_not_feasible_is_said_and_run_all_the_same():
    choice = Choice(False, 1e-3, 8.0, 9.0, *START)
    found = respond(choice, PAPER, duration=1.0)
    assert "must not exceed z = 4 m/s2" in found.problem and found.run is not None
    cross = feasible_plot(choice, feasible_edge(1e-3, PAPER, points=5), found, PAPER)["data"][1]
    assert cross["marker"]["symbol"] == "x" and (cross["x"], cross["y"]) == ([8.0], [9.0])


@pytest.mark.parametrize("old", [True, False])
def test_a_start_outside_the_state_space_is_refused_in_words(old):
    found = respond(Choice(old, 1e-3, 11.0, 5.5, (5.0, 11.0), START[1]), PAPER)
    assert found.run is None and "must exceed L = 5 m" in found.problem
    assert all(plot["data"] == [] for plot in run_plots(found))
