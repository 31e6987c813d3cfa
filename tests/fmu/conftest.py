"""FMUs built once for all tests of this folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from build_fmu import main as build
from harness import Instance, Unpacked


def _unpacked(vehicles: int, folder: Path) -> Unpacked:
    assert build(["--vehicles", str(vehicles), "--output", str(folder)]) == 0
    return Unpacked(folder / "PspPlatoon.fmu", folder / "unpacked")


@pytest.fixture(scope="session")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlatoon.fmu for 7 vehicles, with the network."""
    return _unpacked(7, tmp_path_factory.mktemp("seven"))


@pytest.fixture(scope="session")
def fmu_of_three(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """PspPlatoon.fmu for 3 vehicles, with the network for any number."""
    return _unpacked(3, tmp_path_factory.mktemp("three"))


@pytest.fixture
def instance(fmu: Unpacked) -> Iterator[Instance]:
    """A fresh instance of the 7-vehicle FMU."""
    created = Instance(fmu)
    yield created
    created.close()


@pytest.fixture
def instances(fmu: Unpacked) -> Iterator[Callable[..., Instance]]:
    """Makes instances, of the 7-vehicle FMU unless told otherwise, and frees them at the end."""
    created: list[Instance] = []

    def make(of: Unpacked | None = None, **options: object) -> Instance:
        created.append(Instance(of or fmu, f"platoon{len(created)}", **options))
        return created[-1]

    yield make
    for each in created:
        each.close()
