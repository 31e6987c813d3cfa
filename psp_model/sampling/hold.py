"""The exact sampled-data model: what a constant acceleration does to gaps and speeds (paper, eq. 10)."""

from __future__ import annotations

from typing import Any


def relative(y: Any) -> Any:
    """y_{i-1} - y_i, as the gaps are defined (paper, section II).

    Parameters
    ----------
    y : (n, ...) array, one value for each vehicle, leader first

    Returns
    -------
    (n-1, ...) array, one value for each gap
    """
    return y[:-1] - y[1:]


def advance(s: Any, v: Any, a: Any, tau: Any) -> tuple[Any, Any]:
    """Gaps and speeds a time tau after a sampling instant, exactly.

    s(tau) = s + D(tau v + tau^2/2 a) and v(tau) = v + tau a, with D the difference between vehicle i-1 and vehicle i.
    Gaps are integrated rather than positions, so that they keep their precision however far the platoon drives (ours).

    Parameters
    ----------
    s : (n-1, ...) array, gaps [m]
    v : (n, ...) array, speeds [m/s]
    a : (n, ...) array, accelerations held since the sampling instant [m/s2]
    tau : time since the sampling instant [s]

    Returns
    -------
    s, v : arrays of the same shapes, a time tau later [m], [m/s]
    """
    return gaps_after(s, travelled(v, a, tau)), v + tau * a


def gaps_after(s: Any, moved: Any) -> Any:
    """Gaps once every vehicle has travelled some distance (paper, eq. 10).

    Parameters
    ----------
    s : (n-1, ...) array, gaps before [m]
    moved : (n, ...) array, distance travelled since [m], from `travelled`

    Returns
    -------
    (n-1, ...) array, gaps after [m]
    """
    return s + relative(moved)


def travelled(v: Any, a: Any, tau: Any) -> Any:
    """Distance tau v + tau^2/2 a that each vehicle covers (paper, eq. 10).

    Parameters
    ----------
    v : (n, ...) array, speeds at the sampling instant [m/s]
    a : (n, ...) array, accelerations held since [m/s2]
    tau : time since the sampling instant [s]

    Returns
    -------
    (n, ...) array [m]
    """
    return tau * (v + 0.5 * tau * a)
