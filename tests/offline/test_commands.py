"""The commands of the offline half: what they write, and one sentence with exit code 2 for everything bad."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from psp_cli.main import app
from psp_cli.remedies import REMEDIES
from psp_model import PlatoonParameters, PotentialParameters, require_feasible
from psp_model.offline.plan import Plan
from small_problems import draw

ROOT = Path(__file__).parents[2]
RUN = CliRunner()
HEADER = "s_2,s_3,v_1,v_2,v_3\n"


def sentence(arguments: list[str]) -> str:
    """What a command says when it ends with exit code 2."""
    result = RUN.invoke(app, arguments)
    assert result.exit_code == 2, result.output
    said = [line for line in result.stderr.splitlines() if line.startswith("psp: ")]
    assert "Traceback" not in result.stderr and len(said) == 1
    return said[0]


def test_optimize_gives_the_same_from_csv_and_npz(tmp_path: Path) -> None:
    starts = draw(3, 2)
    np.savez(tmp_path / "starts.npz", s0=starts[:, :2], v0=starts[:, 2:])
    rows = "\n".join(",".join(repr(float(x)) for x in row[[3, 0, 1, 2, 4]]) for row in starts)
    (tmp_path / "starts.csv").write_text("v_2,s_2,s_3,v_1,v_3\n" + rows + "\n")
    for kind in ("csv", "npz"):
        arguments = ["--starts", str(tmp_path / f"starts.{kind}"), "-o", str(tmp_path / f"out.{kind}")]
        result = RUN.invoke(app, ["optimize", *arguments, "--effort", "quick"])
        assert result.exit_code == 0, result.output
    found = np.load(tmp_path / "out.npz")
    table = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)
    for name in ("alpha", "r", "p", "J"):
        assert (found[name] == table[name]).all() and found[name].shape == (2,)
    for triple in zip(found["alpha"], found["r"], found["p"], strict=True):
        require_feasible(PotentialParameters(*map(float, triple)), PlatoonParameters())


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("", "is empty"),
        (HEADER, "holds no start"),
        (HEADER + "9,9,30,30,nan\n", "finite"),
        (HEADER + "9,4.2,30,30,30\n", "spacing s[3] = 4.2 m must exceed L"),
        (HEADER + "9,9,30,30,36\n", "speed v[3] = 36"),
        (HEADER + "9,9,30,30\n", "has 4 cells"),
        (HEADER + "9,9,30,30,fast\n", "something else than numbers"),
        ("s_2,v_1,v_2,colour\n9,30,30,1\n", "unknown column 'colour'"),
        ("s_2,v_1,v_2,v_2\n9,30,30,1\n", "repeated column"),
        ("s_2,v_1,v_2,v_3\n9,30,30,30\n", "s_3"),
    ],
)
def test_bad_csv(tmp_path: Path, content: str, expected: str) -> None:
    path = tmp_path / "starts.csv"
    path.write_text(content)
    assert expected in sentence(["optimize", "--starts", str(path), "-o", str(tmp_path / "out.csv")])
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize(
    ("arrays", "expected"),
    [
        ({"s0": np.ones((2, 3)) * 9, "v0": np.ones((2, 3)) * 30}, "s0 [2, 3] and v0 [2, 3]"),
        ({"s0": np.ones((2, 3)) * 9}, "it needs s0"),
        ({"s0": np.ones((0, 3)), "v0": np.ones((0, 4))}, "holds no start"),
        ({"s0": np.array([["a"]]), "v0": np.ones((1, 2))}, "numeric"),
    ],
)
def test_bad_npz(tmp_path: Path, arrays: dict[str, np.ndarray], expected: str) -> None:
    np.savez(tmp_path / "starts.npz", **arrays)
    assert expected in sentence(["optimize", "--starts", str(tmp_path / "starts.npz"), "-o", str(tmp_path / "out.npz")])


def test_other_bad_input(tmp_path: Path) -> None:
    (tmp_path / "text.npz").write_text("no zip")
    out = ["-o", str(tmp_path / "out.npz")]
    assert "not an NPZ file" in sentence(["optimize", "--starts", str(tmp_path / "text.npz"), *out])
    assert "could not be read" in sentence(["optimize", "--starts", str(tmp_path / "none.csv"), *out])
    assert "neither CSV nor NPZ" in sentence(["optimize", "--starts", str(tmp_path / "x.txt"), *out])
    assert "not one of" in sentence(["dataset", "--effort", "huge", *out])
    assert "there is no data set" in sentence(["train", "--data", str(tmp_path / "none.parquet"), *out])
    (tmp_path / "text.parquet").write_text("no parquet")
    assert "not a Parquet file" in sentence(["train", "--data", str(tmp_path / "text.parquet"), *out])
    network = ["--network", "onnx/platoon_7.onnx"]
    assert "not a Parquet file" in sentence(["evaluate", "--data", str(tmp_path / "text.parquet"), *network])
    assert "no Dask scheduler" in sentence(["dataset", "--scheduler", "tcp://127.0.0.1:1", *out])


def test_dataset_train_evaluate_from_end_to_end(
    tiny_plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for seed, count in ((1, 30), (2, 6)):
        arguments = [
            "-n",
            "3",
            "--starts",
            str(count),
            "--seed",
            str(seed),
            "-o",
            f"{seed}.parquet",
            "--effort",
            "tiny",
        ]
        assert RUN.invoke(app, ["dataset", *arguments]).exit_code == 0
    trained = ["train", "--data", "1.parquet", "-o", "net.onnx", "--epochs", "2", "--candidates", "9", "--hidden", "8"]
    assert RUN.invoke(app, trained).exit_code == 0
    assert Path("out/training/net_parameters.png").stat().st_size > 1000
    judged = ["evaluate", "--data", "2.parquet", "--network", "net.onnx", "--rollouts", "4", "--card", "--json"]
    result = RUN.invoke(app, judged)
    assert result.exit_code == 0, result.output
    kept = json.loads(Path("out/evaluation/net.json").read_text())
    assert {key: kept[key] for key in kept if key != "command"}.items() <= json.loads(result.stdout).items()
    card = Path("net.md").read_text()
    assert "psp train" in card or "SHA-256" in card
    assert "best of 4 by rollout" in card and "best fixed triple" in card
    assert Path("out/evaluation/net.png").stat().st_size > 1000
    assert "trained on this very data set" in sentence(["evaluate", "--data", "1.parquet", "--network", "net.onnx"])


@pytest.mark.parametrize(
    ("header", "words"),
    [("s_2,v_1,v_999999999\n9,30,30\n", "names vehicle 999999999"), ("s_" + "1" * 5000 + "\n", "unknown column")],
)
def test_csv_headers_that_would_fill_the_memory_are_refused(tmp_path: Path, header: str, words: str) -> None:
    path = tmp_path / "starts.csv"
    path.write_text(header)
    assert words in sentence(["optimize", "--starts", str(path), "-o", str(tmp_path / "out.csv")])


def test_the_remedy_names_the_option_of_the_command(tiny_plan: Plan, tmp_path: Path) -> None:
    """The library says what is wrong; the command line, which has the option, what to do with it."""
    path, parts = tmp_path / "a.parquet", tmp_path / "a.parquet.parts"
    arguments = ["dataset", "-n", "3", "--starts", "3", "--effort", "tiny", "-o", str(path)]
    assert RUN.invoke(app, arguments).exit_code == 0
    assert sentence(arguments).endswith("exists already: remove it or give --output another name")
    path.unlink()
    parts.mkdir()
    (parts / "plan.json").write_text("{}")
    (parts / "000000.npz").write_bytes(b"half")
    assert sentence(arguments).endswith("holds an unfinished run: go on with --resume, or remove that folder")
    assert "with another plan: repeat the options" in sentence([*arguments, "--resume"])
    assert "there is no data set" in (said := sentence(["train", "--data", "b.parquet", "-o", "net.onnx"]))
    assert said.endswith("make one with psp dataset")


def test_every_remedy_is_that_of_an_error_which_the_library_raises() -> None:
    library = "".join(path.read_text() for path in (ROOT / "psp_model" / "offline").glob("*.py"))
    assert all(f'"{key}")' in library for key in REMEDIES)
