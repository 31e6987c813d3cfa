"""What the paper says of its figures, on the numbers behind ours."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
import pytest
from PIL import Image

from psp_model import BEST_FIXED, V_OLD, PlatoonParameters, PlatoonState, StartDomain, require_feasible, simulate
from psp_model.analysis.curves import curve, hill
from psp_model.analysis.landscape import landscape, optimum
from psp_model.analysis.motion import closing_speeds, moving_frame
from psp_model.law.potential import PotentialParameters
from psp_view.landscape import draw_landscape
from psp_view.palette import OKABE_ITO, cividis, colours
from psp_view.potentials import BASE, VARIED, draw_potentials, family
from psp_view.runs import draw_runs, save_runs
from psp_view.style import save

PAPER = PlatoonParameters()


def panel(name: str):
    return {line.label: line for line in family(name, VARIED[name], PAPER, BASE)}


def start(seed: int, vehicles: int = 7) -> PlatoonState:
    s, v = StartDomain().draw(np.random.default_rng(seed), vehicles, 1)
    return PlatoonState(s[:, 0], v[:, 0])


@pytest.fixture(scope="module")
def runs():
    """Runs of V_old and V_new from the same starts, V_new's after two minutes: it is slow where it has little slope."""
    starts = [start(seed) for seed in range(5)]
    return {
        shape: np.concatenate([simulate(one, shape, duration=time, output_step=time).s[-1] for one in starts])
        for shape, time in ((V_OLD, 30.0), (BEST_FIXED, 120.0))
    }


@pytest.mark.parametrize(("r", "label"), [(8.0, "r = 8 m"), (12.0, "r = 12 m")])
def test_the_local_minimum_is_close_to_r(r, label):
    """Paper, III.A.2: for r = 8 the local minimum occurs close to s = 8, for r = 12 close to s = 12."""
    line = panel("r")[label]
    inside = (line.s >= r) & (line.s <= r + 3)
    falls_then_rises = np.flatnonzero((line.V[1:-1] < line.V[:-2]) & (line.V[1:-1] < line.V[2:])) + 1
    assert falls_then_rises.size == 1 and inside[falls_then_rises[0]]
    assert r < line.s[falls_then_rises[0]] < r + 0.5
    minimum, _ = hill(line.shape, PAPER)
    assert minimum == pytest.approx(line.s[falls_then_rises[0]], abs=0.02)


def test_p_makes_the_hill_higher_and_sharper():
    """Paper, III.A.3: with p = 6 the hill is higher and sharper than with p = 5."""
    crests, slopes = {}, {}
    for label, line in panel("p").items():
        inside = (line.s > BASE.r) & (line.s < BASE.r + 3)
        crests[label], slopes[label] = line.V[inside].max(), np.abs(line.slope[inside]).max()
    assert crests["p = 6"] > 1.5 * crests["p = 5"]
    assert slopes["p = 6"] > 1.5 * slopes["p = 5"]


def test_alpha_scales_the_potential_and_its_slope_off_the_hill():
    """Paper, III.A.1: alpha scales V_new up and down and thereby its slope."""
    small, middle, large = panel("alpha").values()
    off = (small.s < BASE.r) | (small.s > BASE.r + 3)
    for quantity in ("V", "slope"):
        np.testing.assert_allclose(getattr(middle, quantity)[off], 10 * getattr(small, quantity)[off])
        np.testing.assert_allclose(getattr(large, quantity)[off], 100 * getattr(small, quantity)[off])


def test_the_slope_drawn_is_the_slope_of_the_potential_drawn():
    for name in VARIED:
        for line in panel(name).values():
            middle = 0.5 * (line.s[1:] + line.s[:-1])
            away = middle > 7.0  # nearer to L the curve is too steep for differences over 1 cm
            rise = np.diff(line.V) / np.diff(line.s)
            np.testing.assert_allclose(rise[away], np.interp(middle, line.s, line.slope)[away], atol=5e-3)


def test_without_a_minimum_there_is_no_hill_to_point_at():
    assert hill(V_OLD, PAPER) is None
    assert hill(PotentialParameters(0.1, 10.0, 5.0), PAPER) is None  # the base falls faster than the hill rises


def test_spacings_go_to_lambda_with_v_old(runs):
    """Paper, scenario 1: spacings converge towards lambda = 20 m (and, by its remark 1, not below)."""
    assert runs[V_OLD].min() > PAPER.lam - 0.05
    assert np.median(runs[V_OLD]) < PAPER.lam + 2.0


def test_spacings_go_to_the_hill_with_v_new(runs):
    """Paper, scenario 2: spacings converge to the local minimum; those that start beyond the crest cannot."""
    minimum, crest = hill(BEST_FIXED, PAPER)
    at_minimum = np.abs(runs[BEST_FIXED] - minimum) < 0.05
    assert (at_minimum | (runs[BEST_FIXED] > crest)).all()
    assert at_minimum.mean() > 0.8


def test_accelerations_are_far_smaller_with_v_new():
    """Paper, scenarios 1 and 2: unrealistically large with V_old, realistic with V_new."""
    old, new = (np.abs(simulate(start(3), shape, duration=5.0).a).max() for shape in (V_OLD, BEST_FIXED))
    assert old > 100.0 and new < 10.0


def test_the_moving_frame_and_closing_speeds_are_consistent_with_the_spacings():
    run = simulate(start(1), BEST_FIXED, duration=2.0)
    places = moving_frame(run, 30.0)
    np.testing.assert_allclose(places[:, :-1] - places[:, 1:], run.s, atol=1e-9)
    rates = np.gradient(run.s, run.time, axis=0)
    np.testing.assert_allclose(closing_speeds(run)[1:-1], rates[1:-1], atol=0.05)


def test_the_landscape_is_j_of_single_runs_and_its_optimum_beats_the_fixed_choice():
    scene = landscape(start(1), points=9)
    best = scene.best
    assert np.nanmin(scene.J) == pytest.approx(simulate(start(1), best).J, rel=1e-9)
    row, column = 0, 6
    shape = PotentialParameters(scene.alpha, float(scene.r[column]), float(scene.p[row]))
    assert scene.J[row, column] == pytest.approx(simulate(start(1), shape).J, rel=1e-9)
    assert np.isnan(scene.J[-1]).all()  # p = 9 is never feasible
    found, cost = optimum(start(1), scene)
    assert cost <= np.nanmin(scene.J)
    again = simulate(start(1), found).J
    assert again == pytest.approx(cost, rel=1e-9)
    require_feasible(found, PAPER)
    figure = draw_landscape(
        scene, {"best found": (found, cost), "fixed": (BEST_FIXED, simulate(start(1), BEST_FIXED).J)}, "psp figures"
    )
    assert "fixed: J = " in figure.legends[0].get_texts()[1].get_text()


def test_a_picture_holds_the_runs_and_its_command(tmp_path: Path):
    pair = {name: simulate(start(1), shape, duration=1.0) for name, shape in (("V_old", V_OLD), ("V_new", BEST_FIXED))}
    figure = draw_runs(pair, "psp compare --plot $HOME/a.png")
    drawn = figure.axes[3].lines
    np.testing.assert_array_equal(drawn[4].get_ydata(), pair["V_new"].s[:, 4])
    assert figure.axes[0].get_ylabel() == "spacing [m]" and figure.axes[-1].get_xlabel() == "time [s]"
    assert "psp compare --plot $HOME/a.png" in figure.get_supxlabel()
    for ending in ("png", "svg"):
        file = save_runs(pair, tmp_path / f"runs.{ending}", "psp compare")
        again = save_runs(pair, tmp_path / "again" / f"runs.{ending}", "psp compare")
        assert again.read_bytes() == file.read_bytes()
    assert Image.open(tmp_path / "runs.png").info["Description"] == "psp compare"


@pytest.mark.parametrize(("ending", "begins"), [("pdf", b"%PDF"), ("PNG", b"\x89PNG"), ("svg", b"<?xml")])
def test_the_suffix_decides_the_format(tmp_path: Path, ending: str, begins: bytes):
    file = save(draw_potentials("psp figures"), tmp_path / f"potentials.{ending}")
    assert file.read_bytes().startswith(begins) and list(tmp_path.iterdir()) == [file]


def test_other_suffixes_are_refused(tmp_path: Path):
    with pytest.raises(ValueError, match=r"\.jpg is not a supported picture file.* ends in \.png, \.svg or \.pdf"):
        save(draw_potentials("psp figures"), tmp_path / "potentials.jpg")
    assert not list(tmp_path.iterdir())


def test_colours_are_distinct_and_from_a_palette_for_the_colour_blind():
    assert set(colours(7)) <= set(OKABE_ITO) and len(set(colours(7))) == 7
    assert len(set(colours(100))) == 100
    there = matplotlib.colormaps["cividis"]
    for place in np.linspace(0.0, 1.0, 1001):
        assert cividis(place) == matplotlib.colors.to_hex(there(place))


def test_a_curve_starts_above_l_and_ends_beyond_lambda():
    line = curve(BEST_FIXED, PAPER)
    assert line.s[0] > PAPER.L and line.s[-1] > PAPER.lam and np.isfinite(line.V).all()
