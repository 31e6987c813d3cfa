"""The leader's speed from a table: what it drives, and one sentence for each file that is none."""

from __future__ import annotations

import numpy as np
import pytest

from build_fmu import main as build
from harness import ERROR, OK, Unpacked
from psp_model import ModelError
from psp_model.vehicles.leader import Profile, read_profile
from psp_traffic.scenario import WLTC_HIGH

TIMES, SPEEDS = [0.0, 2.0, 3.0, 7.0], [10.0, 12.0, 4.0, 34.0]


def test_straight_lines_between_rows_and_the_ends_held():
    profile = Profile(TIMES, SPEEDS)
    asked = np.linspace(-1.0, 9.0, 201)
    found = [profile.speed(time) for time in asked]
    np.testing.assert_allclose(found, np.interp(asked, TIMES, SPEEDS), rtol=0, atol=1e-12)


def test_the_part_of_the_wltc_lies_inside_the_state_space_and_never_stands():
    wltc = read_profile(WLTC_HIGH)
    assert wltc.times == tuple(range(418))
    assert min(wltc.speeds) > 3.3 and max(wltc.speeds) < 27.1
    assert np.sum(wltc.speeds) == pytest.approx(7149.7, abs=0.1)  # [m] driven; the sum over the regulation's own km/h
    source = WLTC_HIGH.read_text(encoding="utf-8")
    assert "No. 15" in source and "Apache-2.0" in source


@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        ("time,speed\n0,1\n", "profile_rows", "has 1 rows"),
        ("", "profile_rows", "has 0 rows"),
        ("time,speed\n0,1\n1,x\n", "profile_line", "line 3"),
        ("# 1\n0,1\n1;2\n", "profile_line", "'1;2'"),
        ("0,1\n0,2\n", "profile_time", "row 2"),
        ("0,1\n1,36.5\n", "profile_speed", "36.5 m/s in row 2"),
        ("0,1\n1,-0.1\n", "profile_backwards", "[0, 35] m/s"),
        ("0,1\n1,nan\n", "finite", "nan"),
        ("0,1\ninf,2\n", "finite", "row 2"),
    ],
)
def test_a_file_that_is_no_profile(tmp_path, text, key, words):
    path = tmp_path / "own.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        read_profile(path)
    assert caught.value.key == key and words in str(caught.value) and "own.csv" in str(caught.value)


def test_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(ModelError, match=r"none\.csv cannot be read"):
        read_profile(tmp_path / "none.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe0,1")
    with pytest.raises(ModelError, match="not UTF-8"):
        read_profile(tmp_path / "binary.csv")


@pytest.fixture(scope="module")
def profile_fmu(tmp_path_factory):
    folder = tmp_path_factory.mktemp("profile")
    rows = [f"{time},{speed}" for time, speed in zip(np.add(TIMES, 100.0), SPEEDS, strict=True)]
    (folder / "own.csv").write_text("\ufeff" + "\n".join(["time [s],speed [m/s]", *rows]), encoding="utf-8")
    arguments = ["--component", "leader", "--profile", str(folder / "own.csv"), "--output", str(folder)]
    assert build(arguments) == 0
    return Unpacked(folder / "PspLeader.fmu", folder / "unpacked")


def test_the_leader_fmu_drives_its_profile(instances, profile_fmu):
    leader = instances(profile_fmu)
    assert leader.initialise({"begin": 1.5}) == OK
    seen = []
    for k in range(40):
        seen.append(leader.get("v")[0])
        assert leader.step(0.25 * k, 0.25) == OK
    np.testing.assert_allclose(seen, np.interp(0.25 * np.arange(40) - 1.5, TIMES, SPEEDS), rtol=0, atol=1e-12)
    assert leader.call("fmi2Reset") == OK
    assert leader.initialise({"begin": float("nan")}) == ERROR
    assert "begin" in leader.messages[-1][1]


def test_a_profile_belongs_to_the_leader(tmp_path, capsys):
    (tmp_path / "fast.csv").write_text("0,30\n1,40\n")
    options = ["--profile", str(tmp_path / "fast.csv"), "--output", str(tmp_path)]
    assert build(["--component", "leader", *options]) == 2
    assert "40 m/s in row 2" in capsys.readouterr().err
    assert build(["--component", "plant", *options]) == 2
    assert build(options) == 2
    assert "takes no --profile" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.fmu"))
