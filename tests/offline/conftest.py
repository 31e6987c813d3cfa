"""What the tests of the offline half share."""

from __future__ import annotations

import pytest

pytest.importorskip("casadi")
pytest.importorskip("ziglang")

from psp_model.offline.plan import Plan
from psp_model.selection.search import search
from small_problems import PLAN, TINY


@pytest.fixture
def tiny_plan(monkeypatch: pytest.MonkeyPatch) -> Plan:
    """A data set of 3 vehicles over 2 s that is solved at once."""
    monkeypatch.setitem(search.EFFORTS, "tiny", TINY)
    return PLAN
