"""T_max over time against T (not in the paper)."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib
from matplotlib.figure import Figure

from psp_model.analysis.certificate import Certificate

from .palette import colours
from .style import LINE_STYLES, RC, caption, new_figure


def draw_periods(certificates: Mapping[str, Certificate], command: str) -> Figure:
    """Lemma 1's bound T_max, or the exact period, over time for several runs, and the period that it must exceed.

    Parameters
    ----------
    certificates : of runs by name
    command : the command that makes this very picture, for the caption

    Returns
    -------
    the figure
    """
    with matplotlib.rc_context(RC):
        figure = new_figure(7.5, 4.2)
        axes = figure.subplots()
        for index, (name, certificate) in enumerate(certificates.items()):
            style, colour = LINE_STYLES[index % len(LINE_STYLES)], colours(len(certificates))[index]
            axes.plot(certificate.time, certificate.T_max, style, color=colour, label=name)
            k = certificate.tightest
            axes.plot(certificate.time[k], certificate.T_max[k], "o", color=colour, markersize=5)
        for T in sorted({certificate.T for certificate in certificates.values()}):
            axes.axhline(T, color="black", linewidth=1.0)
            axes.annotate(f"T = {T:g} s", (1.0, T), xycoords=("axes fraction", "data"), ha="right", va="bottom")
        bound = " or ".join(sorted({certificate.bound for certificate in certificates.values()}))
        axes.set(xlabel="time [s]", ylabel=f"{bound} [s]", yscale="log")
        axes.margins(x=0.0)
        axes.legend()
        by = "Lemma 1: " if bound == "T_max" else ""
        text = f"{by}T is certified where it is below {bound}. Smallest {bound} (dots): "
        text += "; ".join(
            f"{name} {c.T_max[c.tightest]:.4g} s, {c.who(c.tightest)}" for name, c in certificates.items()
        )
        caption(figure, text + ".", command)
    return figure
