"""Who selects the potential: the protocol, what each selector refuses, and warnings that are data."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from psp_model import (
    BEST_FIXED,
    Fixed,
    FromNetwork,
    ModelError,
    ObjectiveWeights,
    Old,
    PlatoonParameters,
    PotentialParameters,
    Sampling,
    Selection,
    project_networks,
)
from psp_model.selection.selectors import ParameterSource, Request, Selector, selector_for


class Careful:
    """A selector of somebody's own: nothing to inherit from."""

    def select(self, s: Any, v: Any, constants: PlatoonParameters) -> Selection:
        return Selection(BEST_FIXED, warning="not sure")


SELECTORS: dict[str, Selector] = {"old": Old(), "fixed": Fixed(), "network": FromNetwork({}), "one's own": Careful()}


@pytest.mark.parametrize("name", SELECTORS)
@pytest.mark.parametrize("n", [1, 2, 5])
def test_every_selector_takes_any_number_of_vehicles_and_warns_with_data(name: str, n: int) -> None:
    selection = SELECTORS[name].select([10.0] * (n - 1), [30.0] * n, PlatoonParameters())
    assert isinstance(selection, Selection) and isinstance(selection.potential, PotentialParameters)
    alone = name == "network" and n == 1  # who meets no potential needs no network
    warned = name == "one's own" or (name == "network" and not alone)
    assert (selection.warning is not None) is warned and not selection.by_network
    if name == "network" and not alone:
        assert selection.warning is not None and f"{n} vehicles" in selection.warning
        assert selection.potential == BEST_FIXED


def test_a_fixed_triple_and_a_fallback_have_to_be_feasible() -> None:
    steep = PotentialParameters(1e-3, 11.0, 9.0)
    for selector in (Fixed(steep), FromNetwork({}, steep)):
        with pytest.raises(ModelError) as caught:
            selector.select([9.0], [30.0, 30.0], PlatoonParameters())
        assert caught.value.key == "slope"
    with pytest.raises(ModelError):
        Fixed().select([9.0], [30.0, 30.0], PlatoonParameters(z=0.01))


@pytest.mark.parametrize("source", list(ParameterSource))
@pytest.mark.parametrize("old", [False, True])
def test_what_a_user_of_an_fmu_asks_for_is_the_selector_of_that_name(source: ParameterSource, old: bool) -> None:
    triple = PotentialParameters(2e-3, 12.0, 4.0)
    request = Request(old, source, triple, rollouts=3, horizon=0.5)
    made = selector_for(request, project_networks(3), ObjectiveWeights(), Sampling(0.02))
    expected = {ParameterSource.NETWORK: "FromNetwork", ParameterSource.FIXED: "Fixed"}.get(source, "BestOfRollouts")
    assert type(made).__name__ == ("Old" if old else expected)
    if not old and source != ParameterSource.FIXED:
        assert made.fallback == triple and request.asks_network  # type: ignore[attr-defined]
    for bad in (Request(horizon=0.0), Request(horizon=np.inf), Request(fixed=replace(triple, p=np.nan))):
        with pytest.raises(ModelError):
            selector_for(replace(bad, old=old, source=source), {}, ObjectiveWeights(), Sampling())
