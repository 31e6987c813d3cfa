"""Which vehicle each one follows, where some are not automated (ours)."""

from __future__ import annotations

from ..namespaces import Array, Number, array_namespace

NEAREST, PREDECESSOR = 1, 2
"""Values of `following`: the nearest vehicle ahead that is not automated, or the predecessor."""


def followed_by(automated: Array, following: int = NEAREST) -> Array:
    """The number of the vehicle whose speed each vehicle takes on, counted from 1; 0 for none (ours).

    Parameters
    ----------
    automated : (n, ...) array, 0 for a vehicle that drives itself, 1 else
    following : NEAREST or PREDECESSOR

    Returns
    -------
    (n, ...) array [1]; 0 for vehicles that drive themselves
    """
    xp = array_namespace(automated)
    rows = [0.0 * automated[:1]]
    for i in range(1, automated.shape[0]):
        foreign = automated[i - 1 : i] < 0.5
        rows.append(0.0 * automated[:1] + i if following == PREDECESSOR else xp.where(foreign, float(i), rows[-1]))
    return xp.where(automated < 0.5, 0.0, xp.concat(rows))


def speeds_followed(
    v: Array, a: Array, automated: Array | None, following: int, free: tuple[Number, Number]
) -> tuple[Array, Array]:
    """The speed that each vehicle takes on, and its derivative (ours).

    Parameters
    ----------
    v, a : (n, ...) speeds [m/s] and accelerations [m/s2]
    automated : (n, ...) array, 0 for a vehicle that drives itself, 1 else; None where all are automated
    following : NEAREST or PREDECESSOR
    free : speed [m/s] and acceleration [m/s2] for vehicles that follow no vehicle

    Returns
    -------
    speed, rate : (n, ...) arrays; with PREDECESSOR the rate is 0 behind the first vehicle
    """
    xp = array_namespace(v)
    speed, rate = 0.0 * v[:1] + free[0], 0.0 * v[:1] + free[1]
    if following == PREDECESSOR:
        return xp.concat([speed, v[:-1]]), xp.concat([rate, 0.0 * v[:-1]])
    speeds, rates = [speed], [rate]
    for i in range(1, v.shape[0]):
        if automated is not None:
            foreign = automated[i - 1 : i] < 0.5
            speed, rate = xp.where(foreign, v[i - 1 : i], speed), xp.where(foreign, a[i - 1 : i], rate)
        speeds.append(speed)
        rates.append(rate)
    return xp.concat(speeds), xp.concat(rates)


def shares_along(share: Array, automated: Array | None, following: int) -> Array:
    """The sum of the shares of all spacings between each vehicle and the one that it follows (ours).

    Parameters
    ----------
    share : (n-1, ...) array, one value for each spacing
    automated, following : as for `speeds_followed`; with PREDECESSOR that is one spacing

    Returns
    -------
    (n, ...) array, 0 for the first vehicle
    """
    xp = array_namespace(share)
    if share.shape[0] == 0:
        return xp.zeros((1, *share.shape[1:]))
    none = 0.0 * share[:1]
    if following == PREDECESSOR:
        return xp.concat([none, share])
    sums = [none]
    for i in range(share.shape[0]):
        before = sums[-1]
        if automated is not None:
            before = xp.where(automated[i : i + 1] < 0.5, 0.0, before)
        sums.append(before + share[i : i + 1])
    return xp.concat(sums)
