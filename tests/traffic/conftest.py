"""FMUs of the controller and of ideal vehicles, built once for all tests of this folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from build_fmu import main as build
from harness import Instance, Unpacked


def _unpacked(component: str, folder: Path, runtime: str = "python") -> Unpacked:
    assert build(["--component", component, "--runtime", runtime, "--output", str(folder)]) == 0
    (path,) = folder.glob("*.fmu")
    return Unpacked(path, folder / "unpacked")


@pytest.fixture(scope="session")
def python_controller_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspController.fmu for up to 7 vehicles."""
    return _unpacked("controller", tmp_path_factory.mktemp("controller"))


@pytest.fixture(scope="session")
def native_controller_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspControllerNative.fmu for up to 7 vehicles."""
    return _unpacked("controller", tmp_path_factory.mktemp("native_controller"), "native")


@pytest.fixture(scope="session", params=["python", "native"])
def controller_fmu(request: pytest.FixtureRequest) -> Unpacked:
    """Each of the two controllers in turn."""
    return request.getfixturevalue(f"{request.param}_controller_fmu")


@pytest.fixture(scope="session")
def python_plant_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlant.fmu with 7 vehicles."""
    return _unpacked("plant", tmp_path_factory.mktemp("plant"))


@pytest.fixture(scope="session")
def native_plant_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlantNative.fmu with 7 vehicles."""
    return _unpacked("plant", tmp_path_factory.mktemp("native_plant"), "native")


@pytest.fixture(scope="session")
def python_leader_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspLeader.fmu."""
    return _unpacked("leader", tmp_path_factory.mktemp("leader"))


@pytest.fixture(scope="session")
def native_leader_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspLeaderNative.fmu."""
    return _unpacked("leader", tmp_path_factory.mktemp("native_leader"), "native")


@pytest.fixture(scope="session", params=["python", "native"])
def plant_fmu(request: pytest.FixtureRequest) -> Unpacked:
    """Each of the two plants in turn."""
    return request.getfixturevalue(f"{request.param}_plant_fmu")


@pytest.fixture(scope="session", params=["python", "native"])
def leader_fmu(request: pytest.FixtureRequest) -> Unpacked:
    """Each of the two leaders in turn."""
    return request.getfixturevalue(f"{request.param}_leader_fmu")


@pytest.fixture(scope="session")
def platoon_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlatoon.fmu with 7 vehicles."""
    return _unpacked("platoon", tmp_path_factory.mktemp("platoon"))


@pytest.fixture
def instances() -> Iterator[Callable[..., Instance]]:
    """Makes instances and frees them at the end."""
    created: list[Instance] = []

    def make(of: Unpacked, **options: object) -> Instance:
        created.append(Instance(of, f"instance{len(created)}", **options))
        return created[-1]

    yield make
    for each in created:
        each.close()
