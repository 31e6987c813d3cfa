"""Training, export and evaluation at small size."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from psp_model import PlatoonState, PotentialParameters, StartDomain, simulate
from psp_model.offline.cost_table import TableCost, regret_tables
from psp_model.offline.dataset import make_dataset
from psp_model.offline.errors import OfflineError
from psp_model.offline.evaluate import Judge, as_markdown
from psp_model.offline.export import check_export
from psp_model.offline.fit import Schedule, apply, fit, initial_layers
from psp_model.offline.mixture import Mixture
from psp_model.offline.onnx_file import Provenance, write_network
from psp_model.offline.parquet import Dataset, read_dataset
from psp_model.offline.ranking import choose_dictionary, train_ranking
from psp_model.offline.recipes import RECIPES, Trained, split, train
from psp_model.offline.structures import fold_scaling
from psp_model.parameters import ObjectiveWeights
from psp_model.sampling.policy import Sampling
from psp_model.selection.network import ParameterNetwork
from psp_model.selection.search.search import EFFORTS
from psp_model.selection.search.slope_limit import SlopeLimit
from psp_model.selection.selectors import ParameterSource, Request, select_for
from small_problems import PLAN, TINY, draw

QUICK = Schedule(3e-3, True, 5, 16, 5)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Dataset]:
    path = tmp_path_factory.mktemp("data") / "data.parquet"
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(EFFORTS, "tiny", TINY)
        make_dataset(replace(PLAN, starts=60, chunk=60), path)
        yield read_dataset(path)


def trained(data: Dataset, recipe: str, checkpoint: Path | None = None) -> Trained:
    return train(Mixture((data,)), replace(RECIPES[recipe], schedule=QUICK), 0, checkpoint, lambda *losses: None)


def ranked(data: Dataset, parameters: Trained) -> tuple[Trained, np.ndarray]:
    return train_ranking(Mixture((data,)), parameters.structure, 12, (8,), 0, None, lambda *losses: None, QUICK)


def test_the_papers_recipe_is_the_papers() -> None:
    recipe = RECIPES["mse"]
    assert recipe.hidden == (32, 16)
    assert (recipe.schedule.learning_rate, recipe.schedule.epochs) == (35e-6, 2000)
    assert (recipe.schedule.patience, recipe.schedule.stop_below, recipe.schedule.cosine) == (50, 1e-3, False)
    assert [len(part) for part in split(6000, 0)] == [5100, 450, 450]


def test_table_cost_reads_the_table_at_its_points_and_clips_p_at_the_slope_limit(data: Dataset) -> None:
    grid, limit = data.grid, SlopeLimit(data.problem.constants)
    cost = TableCost.of(grid, limit)
    assert data.tables is not None
    regret = regret_tables(data.tables, data.J, 0.5)
    flat = regret.reshape(len(regret), -1)
    for i, j in [(3, 2), (10, 0), (15, 5)]:
        largest = float(limit.largest_p(np.array(grid.alpha), np.array(grid.r[i])))
        p = 3.0 + grid.level[j] * (largest - 3.0)
        rows = np.full(len(flat), 1.0, np.float32)
        np.testing.assert_allclose(cost(flat, rows * grid.r[i], rows * p), regret[:, i, j], atol=2e-3)
        np.testing.assert_allclose(cost(flat, rows * grid.r[i], rows * 9), regret[:, i, -1], atol=2e-3)


@pytest.mark.parametrize("recipe", ["mse", "cost"])
def test_training_lowers_the_loss_and_repeats(data: Dataset, recipe: str) -> None:
    first, second = trained(data, recipe), trained(data, recipe)
    history = [loss for loss, _ in first.fit.history]
    assert min(history) < history[0]
    assert history == [loss for loss, _ in second.fit.history]
    assert all((a[0] == b[0]).all() for a, b in zip(first.layers, second.layers, strict=True))


def test_training_goes_on_where_it_was_interrupted(tmp_path: Path) -> None:
    x = draw(3, 64).astype(np.float32) / 30
    rows = {"x": x, "y": x[:, :2] ** 2}

    def loss(layers: object, batch: dict[str, np.ndarray]) -> object:
        return ((apply(layers, batch["x"]) - batch["y"]) ** 2).mean()

    class Interrupted(Exception):
        pass

    def stop(epoch: int, *losses: float) -> None:
        if epoch == 31:
            raise Interrupted

    schedule, layers = Schedule(1e-3, True, 40, 16, 40), initial_layers([5, 8, 2], 1)
    whole = fit(layers, loss, rows, rows, schedule, 3)
    checkpoint = tmp_path / "checkpoint"
    with pytest.raises(Interrupted):
        fit(layers, loss, rows, rows, schedule, 3, checkpoint, stop)
    epochs: list[int] = []
    resumed = fit(layers, loss, rows, rows, schedule, 3, checkpoint, lambda epoch, *losses: epochs.append(epoch))
    assert epochs[0] == 25
    assert resumed.history == whole.history
    other = fit(layers, loss, rows, rows, schedule, 4, checkpoint)
    assert other.history != whole.history


def test_onnx_file_computes_what_was_trained(data: Dataset, tmp_path: Path) -> None:
    parameters = trained(data, "cost")
    ranking, dictionary = ranked(data, parameters)
    origin = Provenance(data.problem, data.domain, "cost", data.sha256, "psp train")
    path = tmp_path / "network.onnx"
    write_network(path, parameters.layers, origin, ranking.layers, dictionary)
    assert check_export(path, Mixture((data,)), parameters, ranking) < 2e-5
    network = ParameterNetwork(path)
    assert (network.vehicles, network.domain, network.constants) == (range(3, 4), StartDomain(), data.problem.constants)
    assert network.trained_on == data.sha256
    candidates = network.candidates(data.starts[0, :2], data.starts[0, 2:], 5)
    assert len(candidates) == 5 and candidates[0] == network.evaluate(data.starts[0, :2], data.starts[0, 2:])
    rows = {tuple(row) for row in dictionary.astype(np.float32)}
    assert all((np.float32(c.alpha), np.float32(c.r), np.float32(c.p)) in rows for c in candidates[1:])


def test_folded_scaling_gives_the_same_function() -> None:
    rng = np.random.default_rng(0)
    layers = [(W.astype(float), rng.standard_normal(b.size)) for W, b in initial_layers([4, 6, 3], 0)]
    shift, scale, out_shift, out_scale = rng.uniform(1, 2, (4, 4))
    x = rng.uniform(5, 10, (20, 4))
    folded = fold_scaling(layers, shift, scale, out_shift[:3], out_scale[:3])
    expected = out_shift[:3] + out_scale[:3] * apply(layers, (x - shift) / scale)
    np.testing.assert_allclose(apply(folded, x.astype(np.float32)), expected, rtol=1e-4, atol=1e-4)


def test_dictionary_is_greedy() -> None:
    regret = np.array([[0.0, 0.3, 0.1], [0.3, 0.0, 0.1], [0.3, 0.3, 0.1]], np.float32)
    assert choose_dictionary(regret, 2)[0] == 2
    assert set(choose_dictionary(regret, 3)) == {0, 1, 2}


def test_evaluation_agrees_with_runs_of_the_model(data: Dataset, tmp_path: Path) -> None:
    parameters = trained(data, "cost")
    ranking, dictionary = ranked(data, parameters)
    path = tmp_path / "network.onnx"
    origin = Provenance(data.problem, data.domain, "cost", "other", "psp train")
    write_network(path, parameters.layers, origin, ranking.layers, dictionary)
    network, judge = ParameterNetwork(path), Judge(data.first(4))
    judge.network("network", network)
    judge.rollout("rollout", network, 16)
    fixed, alone, rollout = judge.evaluation.answers
    assert (alone.J >= rollout.J).all()
    for k in range(4):
        start = PlatoonState(data.starts[k, :2], data.starts[k, 2:])
        request = Request(source=ParameterSource.ROLLOUT, rollouts=16, horizon=data.problem.horizon)
        chosen = select_for(start, request, network, ObjectiveWeights(), Sampling()).potential
        np.testing.assert_allclose([chosen.alpha, chosen.r, chosen.p], rollout.triples[k], rtol=1e-12)
        run = simulate(start, PotentialParameters(*map(float, alone.triples[k])), duration=data.problem.horizon)
        assert pytest.approx(alone.J[k], abs=1e-9) == run.J
    score = judge.evaluation.score(fixed)
    assert score.mean == pytest.approx(float((fixed.J / data.J[:4] - 1).mean()))
    assert score.beats_fixed == 0.0
    assert "rollout" in as_markdown(judge.evaluation.scores)


class _Bomb:
    """What a hostile checkpoint would hold: unpickling it makes a file."""

    def __init__(self, path: Path):
        self.path = path

    def __reduce__(self) -> tuple[object, ...]:
        return Path.touch, (self.path,)


def test_a_checkpoint_runs_no_code_and_a_damaged_one_is_named(tmp_path: Path) -> None:
    rows = {"x": np.ones((8, 2), np.float32)}

    def loss(layers: object, batch: dict[str, np.ndarray]) -> object:
        return (apply(layers, batch["x"]) ** 2).mean()

    checkpoint, trace = tmp_path / "checkpoint", tmp_path / "trace"
    arguments = (initial_layers([2, 2], 1), loss, rows, rows, Schedule(1e-3, True, 26, 8, 40), 3, checkpoint)
    fit(*arguments)
    good = checkpoint.read_bytes()
    np.savez(tmp_path / "bomb.npz", key=np.array([_Bomb(trace)], dtype=object), allow_pickle=True)
    for content in (pickle.dumps(_Bomb(trace)), (tmp_path / "bomb.npz").read_bytes(), good[:-30], b""):
        checkpoint.write_bytes(content)
        with pytest.raises(OfflineError, match="is not a checkpoint of this training: remove it"):
            fit(*arguments)
    assert not trace.exists()
