"""Runs kept in a JSON file, so that an interrupted comparison can be resumed."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from hashlib import sha256
from math import isfinite
from pathlib import Path

from psp_model.errors import PspError
from psp_model.whole_file import write_whole

Row = dict[str, float]


class ResultsError(PspError, ValueError):
    """One sentence on a file from which runs cannot be resumed."""


def digest(path: Path) -> str:
    """What identifies the content of a file.

    Parameters
    ----------
    path : of the file
    """
    return sha256(path.read_bytes()).hexdigest()[:16]


class Results:
    """Runs by name; with a file each run is written as soon as it is done.

    Parameters
    ----------
    path : of the file; None keeps nothing
    settings : of all runs; a file with other settings is rejected
    command : that makes the file, noted in it

    Raises
    ------
    ResultsError : where the file is not one of these, or was made with other settings
    """

    def __init__(
        self, path: Path | None = None, settings: Mapping[str, object] | None = None, command: str = ""
    ) -> None:
        self.path, self.settings, self.command = path, dict(settings or {}), command
        self.runs: dict[str, Row] = {}
        if path is not None and path.exists():
            found, self.runs = read_results(path)
            if found != self.settings:
                other = [key for key in {*found, *self.settings} if found.get(key) != self.settings.get(key)]
                raise ResultsError(
                    f"{path} was made with other settings ({', '.join(sorted(other))}): name another file or delete it"
                )

    def run(self, name: str, make: Callable[[], Row]) -> Row:
        """The run of that name, made if it is not there.

        Parameters
        ----------
        name : of the run
        make : makes it
        """
        if name not in self.runs:
            self.runs[name] = make()
            self._write()
        return self.runs[name]

    def _write(self) -> None:
        if self.path is None:
            return
        lines = [f"  {json.dumps(name)}: {json.dumps(_plain(row))}" for name, row in self.runs.items()]
        text = f'{{\n "command": {json.dumps(self.command)},\n "settings": {json.dumps(self.settings)},\n "runs": {{\n'
        write_whole(self.path, text + ",\n".join(lines) + "\n }\n}\n")


def _plain(row: Row) -> dict[str, float | str]:
    """JSON has neither infinity nor NaN."""
    return {key: value if isfinite(value) else str(value) for key, value in row.items()}


def read_results(path: Path) -> tuple[dict[str, object], dict[str, Row]]:
    """Settings and runs of a file.

    Parameters
    ----------
    path : of the file

    Raises
    ------
    ResultsError : where it is not a file of `Results`
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        runs = {name: {key: float(value) for key, value in row.items()} for name, row in content["runs"].items()}
        return dict(content["settings"]), runs
    except (ValueError, KeyError, TypeError, AttributeError):
        raise ResultsError(f"{path} holds no results of psp sumo: name another file") from None
