"""What the small C host of this folder is told."""

from __future__ import annotations

from harness import Unpacked


def host_arguments(fmu: Unpacked, step: float, steps: int, *names: str) -> list[str]:
    """What the C host needs to run an FMU."""
    model = fmu.description.coSimulation.modelIdentifier
    library = fmu.folder / "binaries" / "linux64" / f"{model}.so"
    resources = (fmu.folder / "resources").as_uri()
    references = [str(fmu.reference[name]) for name in names]
    return [str(library), resources, fmu.description.guid, repr(step), str(steps), *references]
