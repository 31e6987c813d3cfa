"""Both FMUs, built once for all tests of this folder."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import fmpy
import pytest

from build_fmu import main as build
from harness import Instance, Unpacked
from system_packages import require

FMI_HEADERS = Path(fmpy.__file__).parent / "c-code"


def built(runtime: str, vehicles: int, folder: Path, component: str = "platoon") -> Unpacked:
    """An FMU of ours, built and unpacked into a folder."""
    options = ["--component", component, "--runtime", runtime, "--vehicles", str(vehicles)]
    assert build([*options, "--output", str(folder)]) == 0
    (path,) = folder.glob("*.fmu")
    return Unpacked(path, folder / "unpacked")


@pytest.fixture(scope="session")
def native_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlatoonNative.fmu for 7 vehicles, with the network."""
    return built("native", 7, tmp_path_factory.mktemp("native"))


@pytest.fixture(scope="session")
def native_fmu_of_three(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlatoonNative.fmu for 3 vehicles, with the network for any number."""
    return built("native", 3, tmp_path_factory.mktemp("native3"))


@pytest.fixture(scope="session")
def native_fmu_of_twelve(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlatoonNative.fmu for up to 12 vehicles."""
    return built("native", 12, tmp_path_factory.mktemp("native12"))


@pytest.fixture(scope="session")
def native_controller_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspControllerNative.fmu for up to 7 vehicles, with the networks."""
    return built("native", 7, tmp_path_factory.mktemp("native_controller"), "controller")


@pytest.fixture(scope="session")
def native_plant_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlantNative.fmu for 7 vehicles."""
    return built("native", 7, tmp_path_factory.mktemp("native_plant"), "plant")


@pytest.fixture(scope="session")
def native_leader_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspLeaderNative.fmu."""
    return built("native", 7, tmp_path_factory.mktemp("native_leader"), "leader")


@pytest.fixture(params=["native", "native_controller", "native_plant", "native_leader"])
def each_native_fmu(request: pytest.FixtureRequest) -> Unpacked:
    """Each of the native FMUs in turn."""
    return request.getfixturevalue(f"{request.param}_fmu")


@pytest.fixture(scope="session")
def python_fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlatoon.fmu for 7 vehicles, with the network."""
    return built("python", 7, tmp_path_factory.mktemp("python"))


@pytest.fixture(params=["native", "python"])
def either_fmu(request: pytest.FixtureRequest) -> Unpacked:
    """Each of the two FMUs in turn."""
    return request.getfixturevalue(f"{request.param}_fmu")


@pytest.fixture
def instance(either_fmu: Unpacked) -> Iterator[Instance]:
    """A fresh instance of each FMU in turn."""
    created = Instance(either_fmu)
    yield created
    created.close()


@pytest.fixture
def native(native_fmu: Unpacked) -> Iterator[Instance]:
    """A fresh instance of the native FMU."""
    created = Instance(native_fmu)
    yield created
    created.close()


@pytest.fixture(scope="session")
def c_host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small C host of this folder, compiled."""
    require("cc")
    host = tmp_path_factory.mktemp("host") / "c_host"
    source = Path(__file__).parent / "c_host.c"
    flags = ["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-I", str(FMI_HEADERS)]
    subprocess.run(["cc", *flags, "-o", str(host), str(source), "-ldl"], check=True)
    return host
