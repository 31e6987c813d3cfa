"""The platoon on the road as a film: GIF by Pillow, MP4 by ffmpeg."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from shutil import which

import matplotlib
import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from psp_model.analysis.cases import Case
from psp_model.analysis.motion import moving_frame
from psp_model.errors import PspError
from psp_model.parameters import PlatoonParameters
from psp_model.whole_file import whole_file

from .palette import colours
from .style import RC, new_figure

FRAMES_PER_SECOND = 15
CAR = 0.84  # length of a drawn vehicle, in L: at the smallest allowable spacing two vehicles do not touch
_WIDTH = 2.0  # [m] of a drawn vehicle
_MARKS = 12.0  # [m] between lane markings


class FilmError(PspError):
    """The film cannot be made; one sentence with the remedy."""


def writer_for(path: Path) -> AbstractMovieWriter:
    """The writer for a film of this kind.

    Parameters
    ----------
    path : file ending in .gif or .mp4

    Raises
    ------
    FilmError : if the kind is unknown, or if ffmpeg is needed and missing
    """
    if path.suffix.lower() == ".gif":
        return PillowWriter(fps=FRAMES_PER_SECOND)
    if path.suffix.lower() != ".mp4":
        raise FilmError(f"{path} is neither .mp4 nor .gif: name the film one of these")
    program = which("ffmpeg") or _bundled_ffmpeg()
    if program is None:
        raise FilmError(f"{path} needs ffmpeg: install it, or `pip install imageio-ffmpeg`, or write a .gif")
    matplotlib.rcParams["animation.ffmpeg_path"] = program
    return FFMpegWriter(fps=FRAMES_PER_SECOND, extra_args=["-pix_fmt", "yuv420p"])


def _bundled_ffmpeg() -> str | None:
    """The program in the package imageio-ffmpeg, if that is installed."""
    try:
        import imageio_ffmpeg
    except ImportError:
        return None
    return str(imageio_ffmpeg.get_ffmpeg_exe())


def bodies(front: NDArray[np.float64], length: float) -> list[NDArray[np.float64]]:
    """Corners of the drawn vehicles.

    Parameters
    ----------
    front : (n,) places of the front ends [m]
    length : of a vehicle [m]

    Returns
    -------
    n arrays (4, 2) [m]
    """
    half = _WIDTH / 2
    return [np.array([[x - length, -half], [x, -half], [x, half], [x - length, half]]) for x in front]


def frame_times(duration: float) -> NDArray[np.float64]:
    """Times of the frames [s], the last at or just before the end.

    Parameters
    ----------
    duration : of the run [s]
    """
    return np.arange(int(duration * FRAMES_PER_SECOND + 1e-9) + 1) / FRAMES_PER_SECOND


def write_film(cases: Sequence[Case], path: Path) -> None:
    """One lane per run, all at the same time and scale, seen from a frame that drives at v*.

    Parameters
    ----------
    cases : the runs
    path : .mp4 or .gif; missing folders are made

    Raises
    ------
    FilmError : as `writer_for` does
    """
    writer = writer_for(path)
    constants = cases[0].setup.start.constants
    places = [moving_frame(case.run, constants.v_star) for case in cases]
    with matplotlib.rc_context(RC | {"axes.grid": False}):
        figure, lanes, marks = _road(cases, places, constants)
        with whole_file(path) as partial, writer.saving(figure, str(partial), dpi=100):
            for time in frame_times(max(float(case.run.time[-1]) for case in cases)):
                for case, place, cars, dashes in zip(cases, places, lanes, marks, strict=True):
                    at = [np.interp(time, case.run.time, column) for column in place.T]
                    cars.set_verts(bodies(np.array(at), CAR * constants.L))
                    dashes.set_verts(markings(*figure.axes[0].get_xlim(), constants.v_star * time))
                figure.suptitle(f"t = {time:.2f} s")
                writer.grab_frame()


def _road(
    cases: Sequence[Case], places: Sequence[NDArray[np.float64]], constants: PlatoonParameters
) -> tuple[Figure, list[PolyCollection], list[PolyCollection]]:
    """The figure with a lane per run; its vehicles and its markings are moved frame by frame."""
    left = min(float(place.min()) for place in places) - 8.0
    right = max(float(place.max()) for place in places) + 4.0
    figure = new_figure(10.0, 0.6 + 0.9 * len(cases))
    figure.suptitle("t = 0.00 s")
    lanes: list[PolyCollection] = []
    marks: list[PolyCollection] = []
    for axes, case in zip(figure.subplots(len(cases), 1, sharex=True, squeeze=False)[:, 0], cases, strict=True):
        axes.set(title=case.name, xlim=(left, right), ylim=(-2.5, 2.5), yticks=[], facecolor="#e4e7ea")
        axes.title.set_fontsize(8)
        lanes.append(PolyCollection([], facecolors=colours(case.run.x.shape[1])))
        marks.append(PolyCollection([], facecolors="white"))
        axes.add_collection(marks[-1], autolim=False)
        axes.add_collection(lanes[-1], autolim=False)
    axes.set_xlabel("place in a frame that drives at v* [m]")
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # the layout stays as it is now: finding it again would take most of the time
    return figure, lanes, marks


def markings(left: float, right: float, travelled: float) -> list[NDArray[np.float64]]:
    """Corners of the lane markings, which are fixed to the road and therefore move in the picture.

    Parameters
    ----------
    left, right : what is seen [m]
    travelled : how far the frame has driven [m]

    Returns
    -------
    arrays (4, 2) [m]
    """
    starts = np.arange(np.floor(left / _MARKS), right / _MARKS + 1) * _MARKS - travelled % _MARKS
    return [
        np.array([[x, y - 0.08], [x + 4, y - 0.08], [x + 4, y + 0.08], [x, y + 0.08]]) for x in starts for y in (-2, 2)
    ]
