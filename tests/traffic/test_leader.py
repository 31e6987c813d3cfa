"""The leader's speed from a table: what it drives, and one sentence for each file that is none."""

from __future__ import annotations

import numpy as np
import pytest

from build_fmu import main as build
from harness import ERROR, OK, Instance, Unpacked
from lives import life
from psp_model import ModelError
from psp_model.vehicles.leader import Profile, profile_of, read_profile
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
        ("time,speed1,speed2\n0,1,2\n1\n", "profile_line", "'1'"),
        ("time,gap,other\n0,1,2\n1,2,3\n", "profile_line", "line 2"),
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


RUNTIMES = ["python", "native"]


@pytest.fixture(scope="module", params=RUNTIMES)
def profile_fmu(request, tmp_path_factory):
    return profile_leader(request.param, tmp_path_factory.mktemp("profile"))


def profile_leader(runtime, folder):
    """The FMU that drives TIMES and SPEEDS, whose clock begins at 100 s."""
    rows = [f"{time},{speed}" for time, speed in zip(np.add(TIMES, 100.0), SPEEDS, strict=True)]
    (folder / "own.csv").write_text("\ufeff" + "\n".join(["time [s],speed [m/s]", *rows]), encoding="utf-8")
    arguments = ["--component", "leader", "--profile", str(folder / "own.csv"), "--output", str(folder)]
    assert build([*arguments, "--runtime", runtime]) == 0
    (path,) = folder.glob("*.fmu")
    return Unpacked(path, folder / "unpacked")


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
    assert (profile_fmu.folder / "resources" / "profile.csv").read_text("utf-8-sig").startswith("time [s]")


@pytest.mark.parametrize("T", [0.01, 0.3])
def test_the_acceleration_held_for_T_gives_the_speeds_at_the_instants(instances, profile_fmu, leader_fmu, T):
    wave = {"v_high": 30.0, "v_low": 14.0, "begin": 1.0, "period": 9.0}
    for fmu, values in ((profile_fmu, {"begin": 1.5}), (leader_fmu, wave)):
        leader = instances(fmu)
        assert leader.initialise(values | {"T": T}) == OK
        (driven,) = leader.get("v")
        changed = 0
        for k in range(round(12.0 / T)):
            v, a = leader.get("v", "a")
            assert driven == pytest.approx(v, rel=0, abs=1e-11)
            driven += T * a
            changed += abs(a) > 0.1
            assert leader.step(k * T, T) == OK
        assert changed > 6.0 / T / 2


def good(rng):
    low, high = sorted(rng.uniform(0.0, 35.0, 2))
    drawn = {"v_low": low, "v_high": high, "begin": rng.uniform(-2.0, 2.0), "period": 10 ** rng.uniform(-2.0, 2.0)}
    return drawn | {"T": float(rng.choice([0.01, 0.3, 2.0]))}


def nothing(rng):
    return {}


def test_both_runtimes_live_the_same_life(python_leader_fmu, native_leader_fmu, tmp_path):
    """Waves, and a profile, from which the same numbers come bit for bit."""
    for seed in range(6):
        one, other = (life(fmu, seed, good, nothing, 0.5 * seed, 0.4) for fmu in (python_leader_fmu, native_leader_fmu))
        assert other.statuses == one.statuses and other.messages == one.messages == []
        np.testing.assert_allclose(other.rows, one.rows, rtol=1e-12, atol=1e-11)
        assert len(one.rows) > 30 and np.ptp(one.rows[:, 0]) > 0.1
    driven = [profile_leader(runtime, _new(tmp_path, runtime)) for runtime in RUNTIMES]
    for seed in range(6):
        one, other = (
            life(fmu, seed, lambda rng: {"begin": rng.uniform(-1.0, 2.0)}, nothing, 0.0, 0.4) for fmu in driven
        )
        assert other.statuses == one.statuses and other.rows.tolist() == one.rows.tolist()
        assert np.ptp(one.rows[:, 0]) > 5.0


def _new(folder, name):
    (folder / name).mkdir()
    return folder / name


BAD = [
    *({name: value} for name in ("T", "v_high", "v_low", "begin", "period") for value in (np.nan, np.inf, -np.inf)),
    *({"T": value} for value in (0.0, -1.0)),
    *({"period": value} for value in (0.0, -1.0)),
    *({"v_low": -1e-9}, {"v_low": 31.0}, {"v_high": 29.0}),
]


def test_bad_values_are_refused_in_the_same_words(python_leader_fmu, native_leader_fmu):
    said = []
    for fmu in (python_leader_fmu, native_leader_fmu):
        instance = Instance(fmu)
        for values in BAD:
            assert instance.initialise(values) == ERROR, values
            assert next(iter(values)) in instance.messages[-1][1]
            assert instance.call("fmi2Reset") == OK
        said.append(instance.messages)
        instance.close()
    assert said[1] == said[0] and len(said[0]) == len(BAD)


@pytest.mark.parametrize("values", [{"period": 5e-324}, {"begin": -1e308}, {"T": 1e300}, {"T": 5e-324}])
def test_values_at_the_ends_of_doubles_give_numbers_or_one_sentence(instances, leader_fmu, values):
    leader = instances(leader_fmu)
    assert leader.initialise(values | {"v_low": 14.0}) == OK
    assert leader.step(0.0, 20.0) == OK
    assert 14.0 <= leader.get("v")[0] <= 30.0 and not leader.messages


def test_a_profile_of_many_rows_is_found_in(tmp_path, instances):
    rng = np.random.default_rng(0)
    times, speeds = np.cumsum(rng.uniform(0.01, 0.4, 3000)), rng.uniform(0.0, 35.0, 3000)
    times -= times[0]
    (tmp_path / "long.csv").write_text(
        "\n".join(f"{float(t)!r},{float(v)!r}" for t, v in zip(times, speeds, strict=True))
    )
    arguments = ["--profile", str(tmp_path / "long.csv"), "--output", str(tmp_path), "--runtime", "native"]
    assert build(["--component", "leader", *arguments]) == 0
    leader = instances(Unpacked(tmp_path / "PspLeaderNative.fmu", tmp_path / "unpacked"))
    profile = read_profile(tmp_path / "long.csv")
    assert leader.initialise() == OK
    for k in range(2000):
        time = 0.25 * k
        assert leader.get("v") == [profile.speed(time)]
        assert leader.step(time, 0.25) == OK


def test_a_profile_belongs_to_the_leader(tmp_path, capsys):
    (tmp_path / "fast.csv").write_text("0,30\n1,40\n")
    options = ["--profile", str(tmp_path / "fast.csv"), "--output", str(tmp_path)]
    assert build(["--component", "leader", *options]) == 2
    assert "40 m/s in row 2" in capsys.readouterr().err
    assert build(["--component", "plant", *options]) == 2
    assert build(options) == 2
    assert "takes no --profile" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.fmu"))


def test_of_a_recording_of_several_vehicles_the_first_one_s_speed_counts() -> None:
    text = '# recorded\n"IVS1", "Time" ,Speed1,speed2\n9.0,100.0,20.0,1.0\n8.0,100.5,21.0,2.0\n'
    found = profile_of(text)
    assert found.times == (0.0, 0.5) and found.speeds == (20.0, 21.0)
