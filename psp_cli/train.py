"""`psp train`: a network from a data set."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .bad_input import BadInput
from .interrupt import can_go_on
from .options import command_line
from .output import say

if TYPE_CHECKING:
    from psp_model.offline.mixture import Mixture
    from psp_model.offline.recipes import Recipe

PARTS = ("parameters", "ranking")


def train(
    data: Annotated[
        list[Path], typer.Option(help="Data set from psp dataset; repeat for several numbers of vehicles.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="ONNX file.")],
    recipe: Annotated[
        str,
        typer.Option(help="mse, the paper's; cost, on what the answers cost; or any, cost for any number of vehicles."),
    ] = "cost",
    hidden: Annotated[
        str | None, typer.Option(help="Widths of the hidden layers. [default: the recipe's]", show_default=False)
    ] = None,
    most: Annotated[int | None, typer.Option(help="Use the first so many starts of each data set only.", min=1)] = None,
    epochs: Annotated[int | None, typer.Option(help="Most epochs. [default: the recipe's]", min=1)] = None,
    seed: Annotated[int, typer.Option(help="Seed of weights, split and batches.", min=0)] = 0,
    candidates: Annotated[int, typer.Option(help="Candidates to rank for parameter_source 3; 0: none.", min=0)] = 0,
    ranking_hidden: Annotated[str, typer.Option(help="Widths of the hidden layers that rank.")] = "128,128",
    curves: Annotated[Path | None, typer.Option(help="Folder for the curves. [default: out/training]")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where an interrupted run stopped.")] = False,
) -> None:
    """Train a network, check its ONNX file against the training framework, and draw its curves."""
    from dataclasses import replace

    from psp_model.offline.mixture import Mixture
    from psp_model.offline.parquet import read_dataset
    from psp_model.offline.recipes import RECIPES

    if recipe not in RECIPES:
        raise BadInput(f"recipe {recipe!r} is not one of {', '.join(RECIPES)}: choose one of these")
    chosen = RECIPES[recipe]
    if hidden:
        chosen = replace(chosen, hidden=widths(hidden))
    if epochs:
        chosen = replace(chosen, schedule=replace(chosen.schedule, epochs=epochs))
    found = Mixture(tuple(read_dataset(path).first(most) for path in data))
    folder = curves or Path("out/training")
    files = _Files(output, folder, resume)
    again = command_line("--resume")
    can_go_on(lambda: again if any(files.checkpoint(part).exists() for part in PARTS) else None)
    _train(found, chosen, seed, files, candidates, widths(ranking_hidden))
    say(output)


class _Files:
    """Where the results and checkpoints of one training go."""

    def __init__(self, output: Path, folder: Path, resume: bool):
        self.output, self.folder = output, folder
        folder.mkdir(parents=True, exist_ok=True)
        output.parent.mkdir(parents=True, exist_ok=True)
        if not resume:
            for part in PARTS:
                self.checkpoint(part).unlink(missing_ok=True)

    def checkpoint(self, part: str) -> Path:
        return self.folder / f"{self.output.stem}_{part}.checkpoint"

    def picture(self, part: str) -> Path:
        return self.folder / f"{self.output.stem}_{part}.png"


def widths(text: str) -> tuple[int, ...]:
    """Widths of hidden layers from text like 32,16.

    Raises
    ------
    BadInput : where it is something else
    """
    try:
        found = tuple(int(part) for part in text.split(","))
    except ValueError:
        found = ()
    if not found or min(found) < 1:
        raise BadInput(f"{text!r} is not a list of layer widths: write them like 32,16")
    return found


def _train(
    data: Mixture, recipe: Recipe, seed: int, files: _Files, candidates: int, ranking_hidden: tuple[int, ...]
) -> None:
    from psp_model.offline.export import check_export
    from psp_model.offline.onnx_file import Provenance, write_network
    from psp_model.offline.ranking import train_ranking
    from psp_model.offline.recipes import train as fit_parameters
    from psp_view.training import draw_losses, save_png

    from .dataset import made_by

    command = command_line()
    with epochs_done(recipe.name, recipe.schedule.epochs) as watch:
        parameters = fit_parameters(data, recipe, seed, files.checkpoint("parameters"), watch)
    label = "mean squared error" if recipe.name == "mse" else "regret"
    losses = draw_losses(parameters.fit.history, parameters.fit.best_epoch, command, label)
    save_png(losses, files.picture("parameters"), dpi=100)
    say(f"{label} on the test part: {parameters.test_loss:.5f} (epoch {parameters.fit.best_epoch + 1} kept)")
    ranking: Any = None
    dictionary = None
    if candidates:
        with epochs_done("ranking", 0) as watch:
            ranking, dictionary = train_ranking(
                data, parameters.structure, candidates, ranking_hidden, seed, files.checkpoint("ranking"), watch
            )
        losses = draw_losses(ranking.fit.history, ranking.fit.best_epoch, command, "cross entropy")
        save_png(losses, files.picture("ranking"), dpi=100)
    numbers = data.vehicles if recipe.per_spacing else None
    made = "; ".join(made_by(each) for each in data.sets)
    origin = Provenance(data.problem, data.domain, recipe.name, data.sha256, command, seed, made, numbers)
    write_network(files.output, parameters.layers, origin, ranking and ranking.layers, dictionary, parameters.structure)
    check_export(files.output, data, parameters, ranking)


def epochs_done(title: str, epochs: int) -> Any:
    """A bar on stderr for training that reports (epoch, training loss, validation loss)."""
    from contextlib import contextmanager

    from .progress import chunks_done

    @contextmanager
    def bar() -> Any:
        with chunks_done(title) as watch:
            yield lambda epoch, training, validation: watch(epoch + 1, max(epochs, epoch + 1))

    return bar()
