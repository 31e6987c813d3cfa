"""The explorer's page, by NiceGUI: sliders on the left, the response of the model on the right."""

from __future__ import annotations

from math import log10
from typing import Any

import numpy as np
from nicegui import ui

from psp_model.analysis.response import Choice, feasible_edge, respond
from psp_model.law.potential import BEST_FIXED
from psp_model.parameters import ALPHA_MAX, ALPHA_MIN, HILL_WIDTH, P_MAX, P_MIN, PlatoonParameters
from psp_model.state import StartDomain

from .plots import feasible_plot, potential_plots, run_plots

_STYLE = """
.figures { display:grid; grid-template-columns:repeat(auto-fill, minmax(150px, 1fr)); gap:.2rem 1rem; }
.figures span { font-variant-numeric:tabular-nums; font-weight:600; }
.grid-plots { display:grid; gap:.5rem; width:100%; }
.grid-plots { grid-template-columns:repeat(auto-fit, minmax(min(100%, 320px), 1fr)); }
.grid-plots > * { min-width:0; height:260px; }
.body--light .js-plotly-plot text { fill:#1b1f24 !important; }
.body--dark .js-plotly-plot text { fill:#e6edf3 !important; }
.nicegui-content { padding:.75rem; }
"""


class Explorer:
    """One visitor's sliders and plots.

    Parameters
    ----------
    constants : of the model
    vehicles : n
    seed : of the start
    """

    def __init__(self, constants: PlatoonParameters, vehicles: int, seed: int):
        self.constants, self.vehicles = constants, vehicles
        self.sliders: dict[str, Any] = {}
        self.figures: dict[str, Any] = {}
        self._held = False  # while several sliders move at once
        with ui.row().classes("w-full no-wrap max-md:flex-wrap items-start"):
            with ui.column().classes("w-full md:w-80 shrink-0 gap-1"):
                self._controls(seed)
            with ui.column().classes("grow min-w-0 w-full gap-2"):
                self._displays()
        self.draw_start(seed)

    def _controls(self, seed: int) -> None:
        c = self.constants
        self.potential = ui.toggle({False: "V_new", True: "V_old"}, value=False, on_change=self.update).props("no-caps")
        self._slider("alpha", "alpha [1]", log10(ALPHA_MIN), log10(ALPHA_MAX), log10(BEST_FIXED.alpha), 0.05)
        self._slider("r", "r [m]", c.L + 0.1, c.lam - HILL_WIDTH, BEST_FIXED.r, 0.1)
        self._slider("p", "p [1]", P_MIN, P_MAX, BEST_FIXED.p, 0.1)
        with ui.row().classes("items-center"):
            ui.number("start drawn by seed", value=seed, min=0, precision=0, on_change=self._seeded).classes("w-40")
        with ui.expansion("start, vehicle by vehicle").classes("w-full"):
            for i in range(2, self.vehicles + 1):
                self._slider(f"s[{i}]", f"spacing s[{i}] [m]", c.L + 0.1, c.lam + 5.0, 10.0, 0.1)
            for i in range(1, self.vehicles + 1):
                self._slider(f"v[{i}]", f"speed v[{i}] [m/s]", 0.0, c.v_max, c.v_star, 0.1)

    def _slider(self, name: str, label: str, low: float, high: float, value: float, step: float) -> None:
        with ui.row().classes("w-full justify-between no-wrap"):
            ui.label(label)
            shown = ui.label().classes(f"value-{name.strip(']').replace('[', '-')} tabular-nums")
        slider = ui.slider(min=low, max=high, value=value, step=step)
        slider.props(f'aria-label="{label}"').classes(f"slider-{name.strip(']').replace('[', '-')}")
        slider.on("update:model-value", self.update, throttle=0.2, leading_events=False)
        self.sliders[name] = slider
        text = (lambda x: f"{10**x:.3g}") if name == "alpha" else (lambda x: f"{x:.4g}")
        shown.bind_text_from(slider, "value", text)

    def _displays(self) -> None:
        self.problem = ui.label().classes("problem text-orange-700 dark:text-orange-300")
        self.numbers = ui.element("div").classes("figures w-full")
        with ui.element("div").classes("grid-plots"):
            self.plots = [ui.plotly({"data": [], "layout": {}, "config": _CONFIG}).classes("w-full") for _ in range(6)]

    async def _seeded(self, event: Any) -> None:
        if event.value is not None and event.value >= 0:
            self.draw_start(int(event.value))

    def draw_start(self, seed: int) -> None:
        """Draw a start from the networks' training domain and show it.

        Parameters
        ----------
        seed : of the draw
        """
        s, v = StartDomain().draw(np.random.default_rng(seed), self.vehicles, 1)
        self._held = True
        for i, spacing in enumerate(s[:, 0], start=2):
            self.sliders[f"s[{i}]"].value = float(spacing)
        for i, speed in enumerate(v[:, 0], start=1):
            self.sliders[f"v[{i}]"].value = float(speed)
        self._held = False
        self.update()

    def choice(self) -> Choice:
        """The values of the sliders."""
        read = {name: float(slider.value) for name, slider in self.sliders.items()}
        spacings = tuple(read[f"s[{i}]"] for i in range(2, self.vehicles + 1))
        speeds = tuple(read[f"v[{i}]"] for i in range(1, self.vehicles + 1))
        alpha = min(max(10 ** read["alpha"], ALPHA_MIN), ALPHA_MAX)
        return Choice(bool(self.potential.value), alpha, read["r"], read["p"], spacings, speeds)

    def update(self) -> None:
        """Run the model for the values of the sliders, and show the result."""
        if self._held:
            return
        choice = self.choice()
        found = respond(choice, self.constants)
        self.problem.text = found.problem
        self.numbers.clear()
        with self.numbers:
            for figure in found.figures:
                with ui.element("div"):
                    ui.label(figure.label + ("" if figure.unit == "1" else f" [{figure.unit}]")).classes("text-xs")
                    ui.html(f"<span data-figure='{figure.label}'>{figure.value:.6g}</span>", sanitize=False)
        edge = feasible_edge(round(choice.alpha, 9), self.constants)
        drawn = [*run_plots(found), *potential_plots(found), feasible_plot(choice, edge, found, self.constants)]
        for plot, content in zip(self.plots, drawn, strict=True):
            plot.update_figure({**content, "config": _CONFIG})


_CONFIG = {"displayModeBar": False, "responsive": True}


def serve(vehicles: int, seed: int, port: int, show: bool) -> None:
    """Serve the explorer on this machine until it is stopped.

    Parameters
    ----------
    vehicles : n
    seed : of the first start
    port : to listen on
    show : open a browser
    """

    @ui.page("/")
    def index() -> None:
        ui.add_css(_STYLE)
        ui.dark_mode(None)
        ui.label(f"A platoon of {vehicles} vehicles").classes("text-xl font-semibold")
        Explorer(PlatoonParameters(), vehicles, seed)

    ui.run(
        host="127.0.0.1",
        port=port,
        show=show,
        reload=False,
        title="psp explore",
    )
