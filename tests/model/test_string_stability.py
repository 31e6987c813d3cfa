"""The conditions of the theory page for gains of at most 1, against the transfer functions themselves."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

OMEGA = np.logspace(-4, 4, 4001)
S = 1j * OMEGA
EDGE = 0.02


@given(st.floats(0.1, 3), st.floats(0, 1), st.floats(0, 1.5))
def test_behind_one_leader(mu: float, share: float, H: float) -> None:
    assume(abs(share + mu * H - 1.0) > EDGE)
    gain = np.abs((mu * (1 + H * S) + share * S) / (mu + S))
    assert (gain.max() <= 1 + 1e-9) == (share + mu * H <= 1)


@given(st.floats(0.1, 4), st.floats(0.01, 4), st.floats(0, 3), st.floats(0, 1.5))
def test_behind_the_predecessor(m: float, stiffness: float, h: float, H: float) -> None:
    late, spacing = m * H + 0.5 * stiffness * H * H, m * h + 0.5 * stiffness * h * h
    assume(abs(late - 1.0) > EDGE and abs(spacing - 1.0) > EDGE)
    above = m * S * (1 + H * S) + stiffness * (1 + H * S + 0.5 * H * H * S * S)
    gain = np.abs(above / (S * S + (m + stiffness * h) * S + stiffness))
    assert (gain.max() <= 1 + 1e-9) == (late <= 1 and spacing >= 1)
