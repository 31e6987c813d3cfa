"""`psp explore`: sliders in front of the model."""

from __future__ import annotations

from typing import Annotated

import typer

from .bad_input import BadInput


def explore(
    vehicles: Annotated[int, typer.Option("--vehicles", "-n", help="Number of vehicles.")] = 7,
    seed: Annotated[int, typer.Option(help="Seed of the first start.", min=0)] = 1,
    port: Annotated[int, typer.Option(help="Port to serve the page on.", min=1, max=65535)] = 8080,
    show: Annotated[bool, typer.Option("--show/--no-show", help="Open a browser.")] = True,
) -> None:
    """Serve a page with sliders in front of the model.

    On this machine only, until Ctrl-C.
    """
    if not 2 <= vehicles <= 30:
        raise BadInput(f"{vehicles} vehicles do not fit on the page: choose 2 to 30")
    from psp_view.explore.page import serve

    serve(vehicles, seed, port, show)
