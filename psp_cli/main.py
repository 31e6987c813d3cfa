"""The registry of `psp`'s commands.

The modules imported here import nothing but typer at their top, so that `psp --help` is quick: what a command needs is
imported inside its function.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Annotated, Any

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
    interrupt,
    optimize,
    output,
    report,
    simulate,
    sumo,
    train,
)
from .bad_input import of_the_user
from .extras import CheckedCommand

_LONGEST = 1000  # characters of a sentence


class Commands(TyperGroup):
    """All commands; bad input ends in one sentence on stderr and exit code 2, never in a traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was asked for."""
        interrupt.can_go_on(lambda: None)
        try:
            with output.speaking():
                return super().invoke(ctx)
        except KeyboardInterrupt:  # where `psp` runs inside another program
            typer.echo(interrupt.sentence(), err=True)
            raise typer.Exit(interrupt.CODE) from None
        except BrokenPipeError:
            raise  # whoever read the output has seen enough: typer ends quietly
        except ImportError as error:
            from psp_model.installed.extras import MissingExtra, explained

            sentence = error if isinstance(error, MissingExtra) else explained(error, f"psp {ctx.invoked_subcommand}")
            if sentence is None:
                raise
            typer.echo(f"psp: {_one_line(str(sentence))}", err=True)
            raise typer.Exit(2) from None
        except OSError as error:
            typer.echo(f"psp: {_one_line(_of_a_file(error))}", err=True)
            raise typer.Exit(2) from None
        except MemoryError:
            typer.echo(
                "psp: out of memory: reduce the number of starts or of vehicles, or the size of the files", err=True
            )
            raise typer.Exit(2) from None
        except Exception as error:
            if not of_the_user(error):
                raise
            from .remedies import said_of

            typer.echo(f"psp: {_one_line(said_of(error))}", err=True)
            raise typer.Exit(2) from None


def _one_line(sentence: str) -> str:
    """The sentence on a line of its own, without the middle of what a file may have put into it."""
    line = " ".join(sentence.split())
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"


def _of_a_file(error: OSError) -> str:
    """What is wrong with a file, and the remedy."""
    import errno

    full = error.errno in (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
    remedy = "make room there" if full else "fix its permissions"
    place = error.filename2 or error.filename or "a file"
    return f"{place} cannot be read or written ({error.strerror or error}): {remedy}, or choose another place"


class Command(CheckedCommand):
    """A command whose `--json` may stand alone: for standard output, as with `-`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Give `--json` its value where it has none."""
        end = args.index("--") if "--" in args else len(args)
        arguments = any(one.param_type_name == "argument" for one in self.params)  # an FMU is not taken for its file
        for i in [i for i in range(end) if args[i] == "--json"]:
            following = args[i + 1] if i + 1 < end else "--"
            named = following.lower().endswith(".json") or not (arguments or following.startswith("-"))
            if following != output.STDOUT and not named:
                args[i] = f"--json={output.STDOUT}"
        return super().parse_args(ctx, args)


Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]


def _with_quiet(command: Callable[..., None]) -> Callable[..., None]:
    """The command with an option --quiet besides its own."""

    @wraps(command)
    def run(*arguments: Any, quiet: bool = False, **options: Any) -> None:
        if quiet:
            output.be_quiet()
        command(*arguments, **options)

    own = inspect.signature(command, eval_str=True)
    kind = inspect.Parameter.KEYWORD_ONLY
    parameters = [*own.parameters.values(), inspect.Parameter("quiet", kind, default=False, annotation=Quiet)]
    run.__signature__ = own.replace(parameters=parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {one.name: one.annotation for one in parameters} | {"return": None}
    return run


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help: importing rich would more than double the time to show it
)


def _version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        from importlib.metadata import PackageNotFoundError, version

        try:
            typer.echo(f"psp {version('psp-platoon')}")
        except PackageNotFoundError:
            typer.echo("psp, not installed: run from its sources")
        raise typer.Exit


Version = Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")]


@app.callback()
def psp(
    version: Version = False,
    quiet: Quiet = False,
) -> None:
    """A vehicle platoon with performance-sensitive potentials: build, run, certify, see and train it."""
    if quiet:
        output.be_quiet()


for _command in (
    build.build,
    simulate.simulate,
    compare.compare,
    certify.certify,
    figures.figures,
    report.report,
    explore.explore,
    dataset.dataset,
    optimize.optimize,
    train.train,
    evaluate.evaluate,
    doctor.doctor,
    sumo.sumo,
):
    app.command(_command.__name__, cls=Command)(_with_quiet(_command))
