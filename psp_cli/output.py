"""What a command says, and where: results on standard output, warnings on stderr, less of both where asked for.

Where data goes to standard output (`--csv -`, `--json -`), nothing else does, whoever writes it: all that is said
besides goes to stderr, also what a library writes to file descriptor 1.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from math import isfinite
from pathlib import Path
from typing import IO, Any

import typer

from .bad_input import BadInput

STDOUT = "-"


class _Voice:
    """How the command that runs now speaks.

    Attributes
    ----------
    quiet : errors only
    data : standard output, where it is kept for data
    """

    def __init__(self) -> None:
        self.quiet = False
        self.data: IO[str] | None = None


_NOW = _Voice()


@contextmanager
def speaking() -> Iterator[None]:
    """A command runs; afterwards standard output is what it was."""
    stdout = sys.stdout
    try:
        yield
    finally:
        data, descriptor = _NOW.data, _descriptor(stdout)
        _NOW.__init__()  # type: ignore[misc]
        if data is not None:
            sys.stdout = stdout
            if descriptor is not None and data is not stdout:
                os.dup2(data.fileno(), descriptor)
            with suppress(OSError):  # who reads it may have seen enough
                data.flush()
                if data is not stdout:
                    data.close()


def be_quiet() -> None:
    """Print errors only from now on."""
    _NOW.quiet = True


def is_quiet() -> bool:
    """Whether errors only are to be said."""
    return _NOW.quiet


def say(text: object) -> None:
    """Say a result to whoever looks at the terminal.

    Parameters
    ----------
    text : a line or several
    """
    if not _NOW.quiet:
        typer.echo(text, err=_NOW.data is not None)


def say_on_stderr(text: object) -> None:
    """Say what is no result: what was left out, or a warning.

    Parameters
    ----------
    text : a line
    """
    if not _NOW.quiet:
        typer.echo(text, err=True)


def console(width: int | None = None) -> Any:
    """A rich console for tables, where results are said.

    Parameters
    ----------
    width : columns; those of the terminal by default
    """
    from rich.console import Console

    return Console(stderr=_NOW.data is not None, quiet=_NOW.quiet, width=width)


def keep_stdout(*wanted: str | Path | None) -> None:
    """Keep standard output for data where one of the options wants it.

    Parameters
    ----------
    wanted : values of options that take a file or `-`

    Raises
    ------
    BadInput : where two want it
    """
    claims = sum(str(one) == STDOUT for one in wanted)
    if claims > 1:
        raise BadInput("two options write to standard output: give one of them a file instead of -")
    if not claims or _NOW.data is not None:
        return
    sys.stdout.flush()
    descriptor = _descriptor(sys.stdout)
    if descriptor is None:
        _NOW.data = sys.stdout
    else:
        _NOW.data = os.fdopen(os.dup(descriptor), "w", encoding="utf-8", newline="")
        os.dup2(2, descriptor)
    sys.stdout = sys.stderr


def _descriptor(stream: Any) -> int | None:
    """The file descriptor below a stream, None where it is none of this process's own."""
    try:
        return 1 if stream.fileno() == 1 else None
    except (AttributeError, OSError, ValueError):
        return None


def kept_stdout() -> IO[str]:
    """Standard output for data, after `keep_stdout` has kept it."""
    assert _NOW.data is not None
    return _NOW.data


def json_place(given: str | None) -> str | None:
    """Where `--json` writes, checked.

    Parameters
    ----------
    given : the option's value

    Raises
    ------
    BadInput : where it is neither `-` nor the name of a JSON file
    """
    if given is not None and given != STDOUT and Path(given).suffix.lower() != ".json":
        raise BadInput(f"--json {given} does not end in .json: give it such a name, or - for standard output")
    return given


def write_json(place: str, content: Mapping[str, Any]) -> None:
    """Write a result as JSON; numbers that JSON lacks become the texts "inf", "-inf" and "nan".

    Parameters
    ----------
    place : from `json_place`
    content : of the file; the command is added
    """
    from .options import command_line

    text = json.dumps({"command": command_line()} | _plain(content), indent=1, ensure_ascii=False) + "\n"
    if place == STDOUT:
        kept_stdout().write(text)
        return
    from psp_model.whole_file import write_whole

    write_whole(Path(place), text)


def _plain(value: Any) -> Any:
    """What JSON can hold."""
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, bool | str | int) or value is None:
        return value
    if isinstance(value, Path):
        return str(value)
    number = float(value)
    return number if isfinite(number) else str(number)
