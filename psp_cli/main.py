"""The registry of `psp`'s commands.

The modules imported here import nothing but typer at their top, so that `psp --help` is quick: what a command needs is
imported inside its function.
"""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperGroup

from . import (
    build,
    certify,
    compare,
    dataset,
    doctor,
    evaluate,
    explore,
    figures,
    optimize,
    report,
    simulate,
    sumo,
    train,
)
from .bad_input import of_the_user

EXTRAS = {"matplotlib": "report", "nicegui": "explore", "jax": "offline", "optax": "offline", "pyarrow": "offline"}
"""Which extra brings a package that the default install does without."""


_LONGEST = 1000  # characters of a sentence


class Commands(TyperGroup):
    """All commands; bad input ends in one sentence on stderr and exit code 2, never in a traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was asked for."""
        try:
            return super().invoke(ctx)
        except ModuleNotFoundError as error:
            extra = EXTRAS.get((error.name or "").partition(".")[0])
            if extra is None:
                raise
            typer.echo(f"psp: this needs {error.name}: install it with `pip install 'psp-platoon[{extra}]'`", err=True)
            raise typer.Exit(2) from None
        except OSError as error:
            typer.echo(f"psp: {_one_line(_of_a_file(error))}", err=True)
            raise typer.Exit(2) from None
        except MemoryError:
            typer.echo("psp: there is no memory left for this: ask for less, or give it files of usual size", err=True)
            raise typer.Exit(2) from None
        except Exception as error:
            if not of_the_user(error):
                raise
            typer.echo(f"psp: {_one_line(str(error))}", err=True)
            raise typer.Exit(2) from None


def _one_line(sentence: str) -> str:
    """The sentence on a line of its own, without the middle of what a file may have put into it."""
    line = " ".join(sentence.split())
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"


def _of_a_file(error: OSError) -> str:
    """What is wrong with a file, and the remedy."""
    import errno

    full = error.errno in (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
    remedy = "make room there" if full else "mend that"
    place = error.filename2 or error.filename or "a file"
    return f"{place} cannot be read or written ({error.strerror or error}): {remedy}, or choose another place"


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help: importing rich would more than double the time to show it
)


@app.callback()
def psp() -> None:
    """A vehicle platoon with performance-sensitive potentials: build, run, certify, see and train it."""


app.command("build")(build.build)
app.command("simulate")(simulate.simulate)
app.command("compare")(compare.compare)
app.command("certify")(certify.certify)
app.command("figures")(figures.figures)
app.command("report")(report.report)
app.command("explore")(explore.explore)
app.command("dataset")(dataset.dataset)
app.command("optimize")(optimize.optimize)
app.command("train")(train.train)
app.command("evaluate")(evaluate.evaluate)
app.command("doctor")(doctor.doctor)
app.command("sumo")(sumo.sumo)
