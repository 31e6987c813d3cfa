"""The network for any number of vehicles: what ought to hold for its shape, its file and its choice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import onnx
from fmu_src.networks import networks_up_to
from onnx import numpy_helper
from psp_cli.main import app
from psp_model import BEST_FIXED, ModelError, ObjectiveWeights, PlatoonState, Sampling, StartDomain, project
from psp_model.offline.dataset import make_dataset
from psp_model.offline.errors import OfflineError
from psp_model.offline.export import check_export
from psp_model.offline.fit import Schedule
from psp_model.offline.mixture import Mixture
from psp_model.offline.onnx_file import Provenance, write_network
from psp_model.offline.parquet import Dataset, read_dataset
from psp_model.offline.ranking import train_ranking
from psp_model.offline.recipes import RECIPES, Trained, train
from psp_model.offline.structures import PerSpacing
from psp_model.selection.network import ParameterNetwork, network_path, read_networks
from psp_model.selection.rollout import rollout_costs
from psp_model.selection.search.engine import Problem
from psp_model.selection.search.search import EFFORTS
from small_problems import PLAN, TINY, draw

ONNX = Path(__file__).parents[2] / "onnx"
ANY = ONNX / "platoon_any.onnx"
DOMAIN = StartDomain()
QUICK = Schedule(3e-3, True, 3, 16, 3)


@pytest.fixture(scope="module")
def mixture(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Mixture]:
    """Two data sets, of 3 and of 4 vehicles."""
    folder = tmp_path_factory.mktemp("data")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(EFFORTS, "tiny", TINY)
        sets: list[Dataset] = []
        for n in (3, 4):
            make_dataset(replace(PLAN, starts=40, chunk=40, problem=Problem(n, horizon=2.0)), folder / f"{n}.parquet")
            sets.append(read_dataset(folder / f"{n}.parquet"))
        yield Mixture(tuple(sets))


@pytest.fixture(scope="module")
def trained(mixture: Mixture) -> tuple[Trained, Trained, np.ndarray]:
    """Answer, ranking and dictionary of a small network for any number of vehicles."""
    recipe = replace(RECIPES["any"], hidden=(8,), per_spacing=(8, 6), schedule=QUICK)
    parameters = train(mixture, recipe, 0, None, lambda *losses: None)
    ranking, dictionary = train_ranking(mixture, parameters.structure, 9, (8,), 0, None, lambda *losses: None, QUICK)
    return parameters, ranking, dictionary


@pytest.fixture(scope="module")
def small(
    mixture: Mixture, trained: tuple[Trained, Trained, np.ndarray], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """The file of that network."""
    parameters, ranking, dictionary = trained
    path = tmp_path_factory.mktemp("any") / "small.onnx"
    origin = Provenance(mixture.problem, mixture.domain, "any", mixture.sha256, "psp train", vehicles=mixture.vehicles)
    write_network(path, parameters.layers, origin, ranking.layers, dictionary, parameters.structure)
    return path


def random_layers(structure: PerSpacing) -> list[tuple[np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(1)
    return [(W, rng.standard_normal(b.size).astype(np.float32)) for W, b in structure.initial((7,), 3, 0)]


@pytest.mark.parametrize("vehicles", [2, 3, 12])
def test_spacings_that_are_not_there_change_nothing(vehicles: int) -> None:
    short, long = PerSpacing(vehicles - 1, (9, 5)), PerSpacing(20, (9, 5))
    layers, starts = random_layers(short), draw(vehicles, 6)
    filled = long.apply(layers, long.rows(starts, DOMAIN))
    np.testing.assert_allclose(short.apply(layers, short.rows(starts, DOMAIN)), filled, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(long.apply(layers, long.rows(starts[2:3], DOMAIN))[0], filled[2], rtol=1e-5, atol=1e-5)


def test_without_neighbours_the_order_of_the_spacings_does_not_matter() -> None:
    structure = PerSpacing(8, (9, 5), radius=0)
    layers, rows = random_layers(structure), structure.rows(draw(6, 5), DOMAIN)
    mixed = rows[:, np.random.default_rng(2).permutation(8)]
    np.testing.assert_allclose(structure.apply(layers, mixed), structure.apply(layers, rows), rtol=1e-5, atol=1e-5)
    aware = replace(structure, radius=1)
    layers = random_layers(aware)
    assert np.abs(aware.apply(layers, mixed) - aware.apply(layers, rows)).max() > 1e-3


def reference(model: onnx.ModelProto, prefix: str, shared: int, s: np.ndarray, v: np.ndarray) -> np.ndarray:
    """What the network should give, spacing by spacing in float64 from the numbers in the file."""
    numbers = {tensor.name: numpy_helper.to_array(tensor).astype(float) for tensor in model.graph.initializer}
    count = sum(name.startswith(f"{prefix}_W") for name in numbers)
    layers = [(numbers[f"{prefix}_W{k}"], numbers[f"{prefix}_b{k}"]) for k in range(1, count + 1)]
    radius, seen = (len(layers[0][0]) // 4 - 1) // 2, []
    for i in range(s.size):
        channels: list[float] = []
        for j in range(i - radius, i + radius + 1):
            channels += [s[j], v[j], v[j + 1], 1.0] if 0 <= j < s.size else [0.0, 0.0, 0.0, 0.0]
        x = np.array(channels)
        for W, b in layers[:shared]:
            x = np.maximum(x @ W + b, 0.0)
        seen.append(x)
    x = np.concatenate([np.mean(seen, axis=0), np.max(seen, axis=0)])
    for W, b in layers[shared:-1]:
        x = np.maximum(x @ W + b, 0.0)
    return np.asarray(x @ layers[-1][0] + layers[-1][1])


@pytest.mark.parametrize("vehicles", range(2, 13))
def test_the_networks_file_is_what_its_card_says(vehicles: int) -> None:
    network, model = ParameterNetwork(ANY), onnx.load(str(ANY))
    s, v = DOMAIN.draw(np.random.default_rng(vehicles), vehicles, 3)
    for k in range(3):
        found = network.evaluate(s[:, k], v[:, k])
        expected = reference(model, "parameters", 2, s[:, k], v[:, k])
        np.testing.assert_allclose([found.alpha, found.r, found.p], expected, rtol=2e-5, atol=1e-7)
        scores = reference(model, "scores", 2, s[:, k], v[:, k])
        (dictionary,) = (numpy_helper.to_array(t) for t in model.graph.initializer if t.name == "dictionary_values")
        best = network.candidates(s[:, k], v[:, k], 2)[1]
        (row,) = np.flatnonzero((dictionary == np.float32([best.alpha, best.r, best.p])).all(axis=1))[:1]
        assert scores[row] == pytest.approx(scores.max(), rel=1e-4)


def test_it_serves_2_to_12_vehicles_better_than_one_fixed_triple() -> None:
    network = ParameterNetwork(ANY)
    assert network.vehicles == range(2, 13) and network.domain == DOMAIN and network.ranks
    s, v = DOMAIN.draw(np.random.default_rng(5), 3, 8)
    J = []
    for k in range(8):
        start = PlatoonState(s[:, k], v[:, k])
        chosen = [project(network.evaluate(start.s, start.v), start.constants), BEST_FIXED]
        costs, certified = rollout_costs(start, chosen, ObjectiveWeights(), Sampling(), 20.0)
        assert certified.all()
        J.append(costs)
    answer, fixed = np.mean(J, axis=0)
    assert answer < fixed


def test_training_lowers_the_loss_and_the_file_computes_what_was_trained(
    mixture: Mixture, trained: tuple[Trained, Trained, np.ndarray], small: Path
) -> None:
    parameters, ranking, _ = trained
    history = [loss for loss, _ in parameters.fit.history]
    assert min(history) < history[0]
    assert check_export(small, mixture, parameters, ranking) < 2e-5
    network = ParameterNetwork(small)
    assert network.vehicles == range(3, 5)
    assert all(data.sha256 in network.trained_on for data in mixture.sets)
    for data in mixture.sets:
        spacings = data.problem.vehicles - 1
        start = data.starts[0, :spacings], data.starts[0, spacings:]
        candidates = network.candidates(*start, 5)
        assert len(candidates) == 5 and candidates[0] == network.evaluate(*start)
    with pytest.raises(ModelError, match="made for 3 to 4 vehicles, not for 5"):
        network.evaluate(np.full(4, 9.0), np.full(5, 30.0))


def test_data_sets_that_do_not_belong_together_are_refused(mixture: Mixture) -> None:
    three, four = mixture.sets
    with pytest.raises(OfflineError, match="use recipe any"):
        train(mixture, replace(RECIPES["cost"], schedule=QUICK), 0, None, lambda *losses: None)
    with pytest.raises(OfflineError, match="differ in constants"):
        Mixture((three, replace(four, problem=replace(four.problem, T=0.02))))


def test_the_network_for_just_that_number_comes_first(small: Path, tmp_path: Path) -> None:
    assert network_path(3, tmp_path) is None
    (tmp_path / "platoon_any.onnx").write_bytes(small.read_bytes())
    assert [network_path(n, tmp_path) and n for n in (2, 3, 4, 5)] == [None, 3, 4, None]
    (tmp_path / "platoon_4.onnx").write_bytes(b"")
    paths = {n: network_path(n, tmp_path) for n in (3, 4)}
    assert [path and path.name for path in paths.values()] == ["platoon_any.onnx", "platoon_4.onnx"]
    networks = read_networks(ONNX, {"3": "platoon_any.onnx", "5": "platoon_any.onnx", "7": "platoon_7.onnx"})
    assert networks[3] is networks[5] and networks[7].vehicles == range(7, 8)


def test_a_network_of_ones_own_serves_all_its_numbers(small: Path, tmp_path: Path) -> None:
    names = {n: network.name for n, network in networks_up_to(4, small).items()}
    assert names == {2: "platoon_any.onnx", 3: "small.onnx", 4: "small.onnx"}
    namesake = tmp_path / "platoon_any.onnx"
    namesake.write_bytes(small.read_bytes())
    names = {n: network.name for n, network in networks_up_to(4, namesake).items()}
    assert names == {2: "platoon_any.onnx", 3: "own_platoon_any.onnx", 4: "own_platoon_any.onnx"}
    with pytest.raises(ModelError, match="made for 3 to 4 vehicles, not for 5"):
        networks_up_to(5, small)


def without(model: onnx.ModelProto, key: str) -> None:
    kept = [entry for entry in model.metadata_props if entry.key != key]
    del model.metadata_props[:]
    model.metadata_props.extend(kept)


def fixed_size(model: onnx.ModelProto) -> None:
    model.graph.input[0].type.tensor_type.shape.dim[1].dim_value = 6


def other_name(model: onnx.ModelProto) -> None:
    model.graph.input[0].name = "distances"
    for node in model.graph.node:
        node.input[:] = ["distances" if name == "gaps" else name for name in node.input]


def misshapen(model: onnx.ModelProto) -> None:
    (tensor,) = (tensor for tensor in model.graph.initializer if tensor.name == "neighbour1_end")
    tensor.CopyFrom(numpy_helper.from_array(np.array([2], np.int64), tensor.name))


@pytest.mark.parametrize(
    ("damage", "expected"),
    [
        (lambda model: without(model, "psp_vehicles_max"), "lacks readable"),
        (lambda model: without(model, "psp_domain"), "lacks readable"),
        (fixed_size, "has inputs"),
        (other_name, "has inputs"),
        (misshapen, "not a readable ONNX file"),
    ],
)
def test_a_bad_file_is_one_sentence(small: Path, tmp_path: Path, damage: object, expected: str) -> None:
    assert callable(damage)
    model = onnx.load(str(small))
    damage(model)
    path = tmp_path / "bad.onnx"
    onnx.save(model, str(path))
    with pytest.raises(ModelError, match=expected) as caught:
        ParameterNetwork(path).evaluate(np.array([9.0, 9.0]), np.array([30.0, 30.0, 30.0]))
    assert "bad.onnx" in str(caught.value) and "\n" not in str(caught.value)


def test_train_and_evaluate_take_several_data_sets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(EFFORTS, "tiny", TINY)
    run = CliRunner()
    for n, seed, count in ((2, 1, 24), (3, 1, 24), (2, 2, 4), (3, 2, 4)):
        make_dataset(
            replace(PLAN, starts=count, seed=seed, chunk=24, problem=Problem(n, horizon=2.0)),
            Path(f"{n}_{seed}.parquet"),
        )
    data = ["--data", "2_1.parquet", "--data", "3_1.parquet"]
    options = ["-o", "net.onnx", "--recipe", "any", "--epochs", "1", "--hidden", "8", "--candidates", "5"]
    assert run.invoke(app, ["train", *data, *options, "--ranking-hidden", "8"]).exit_code == 0
    held = ["--data", "2_2.parquet", "--data", "3_2.parquet", "--network", "net.onnx", "--rollouts", "8", "--card"]
    result = run.invoke(app, ["evaluate", *held])
    assert result.exit_code == 0, result.output
    card = Path("net.md").read_text()
    assert "2 to 3 vehicles" in card and "| 2 | 4 |" in card and "| 3 | 4 |" in card and "best of 8 by rollout" in card
    assert card.count("**Data**") == 2
    assert Path("out/evaluation/net.png").stat().st_size > 1000
    refused = run.invoke(app, ["evaluate", *data, "--network", "net.onnx"])
    assert refused.exit_code == 2 and "trained on this very data set" in refused.stderr


def test_one_file_is_one_network_for_all_who_ask_until_it_is_replaced(tmp_path: Path) -> None:
    copy = tmp_path / "network.onnx"
    copy.write_bytes((ONNX / "platoon_any.onnx").read_bytes())
    first = read_networks(tmp_path, {"3": "network.onnx"})[3]
    assert read_networks(tmp_path, {"3": "network.onnx"})[3] is first
    copy.write_bytes((ONNX / "platoon_7.onnx").read_bytes())
    assert list(read_networks(tmp_path, {"7": "network.onnx"})[7].vehicles) == [7]


def test_a_file_with_a_size_that_cannot_be_is_refused_at_once(tmp_path: Path) -> None:
    model = onnx.load(str(ONNX / "platoon_any.onnx"))
    model.graph.input[0].type.tensor_type.shape.dim[-1].dim_value = 2**31
    (tmp_path / "network.onnx").write_bytes(model.SerializeToString())
    with pytest.raises(ModelError, match=r"network\.onnx"):
        ParameterNetwork(tmp_path / "network.onnx").require_vehicles(4)
