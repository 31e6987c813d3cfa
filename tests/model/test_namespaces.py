"""One source, three array libraries: NumPy, JAX and CasADi give the same, and a batch is its members one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from psp_model import V_OLD, ObjectiveWeights, PaperLaw, feedback, largest_period, potential, potential_slope
from psp_model.law.feedback import f, feedback_towards, g, gain, repulsion
from psp_model.law.potential import PotentialParameters
from psp_model.objective import running_cost
from psp_model.parameters import generic
from psp_model.sampling.exact import exact_period
from psp_model.sampling.hold import IDEAL, advance, travelled
from psp_model.sampling.lemma1 import period_bounds
from psp_model.sampling.period import decide, hold
from strategies import CONSTANTS, feasible_triple

TAU = 0.007  # [s]
RELATIVE = 1e-12  # libraries round powers and sums differently
WEIGHTS = ObjectiveWeights()


def model(s: Any, v: Any, shape: Any) -> list[Any]:
    """Everything that one sampling period computes."""
    a = feedback(s, v, shape, CONSTANTS)
    u = repulsion(s, shape, CONSTANTS)
    return [
        potential(s, shape, CONSTANTS),
        potential_slope(s, shape, CONSTANTS),
        u,
        f(u, CONSTANTS.epsilon),
        g(u, CONSTANTS),
        gain(u, CONSTANTS),
        a,
        *period_bounds(s, v, a, CONSTANTS),
        largest_period(s, v, a, CONSTANTS),
        exact_period(s, v, a, CONSTANTS),
        *whole_period(s, v, shape),
        *(feedback_towards(s, v, shape, CONSTANTS, desired) for desired in (0.0, 0.2, 17.0, 34.9)),
        *advance(s, v, a, TAU),
        travelled(v, a, TAU),
        *running_cost(s, v, a, TAU, WEIGHTS),
    ]


def whole_period(s: Any, v: Any, shape: Any) -> list[Any]:
    """The same by what runs, rollouts and the search's engine repeat."""
    vehicles = IDEAL.begin(0.0 * v[0], s, v)
    _, a, bound = decide(PaperLaw(shape, CONSTANTS), None, vehicles)
    after, terms = hold(IDEAL, vehicles, a, TAU, WEIGHTS)
    return [a, bound, after.x, after.s, after.v, *terms]


def batch(vehicles: int, count: int) -> tuple[Any, Any, Any]:
    """Spacings on the hill, below r, beyond lambda and near L; speeds at both ends; a triple for every member."""
    rng = np.random.default_rng(vehicles)
    s, v = rng.uniform(5.1, 22, (vehicles - 1, count)), rng.uniform(0, 35, (vehicles, count))
    s[0, 0], v[0, 0], v[-1, 1] = 5.001, 0.0, 35.0
    triples = [V_OLD, *(feasible_triple(seed) for seed in range(count - 1))]
    columns = {name: np.array([getattr(one, name) for one in triples]) for name in ("alpha", "r", "p", "hill")}
    return s, v, generic(PotentialParameters, **columns)


def member(shape: Any, j: int) -> Any:
    return PotentialParameters(**{name: float(column[j]) for name, column in vars(shape).items()})


@pytest.mark.parametrize("vehicles", [2, 3, 7, 12])
def test_batch_equals_its_members_one_by_one(vehicles: int) -> None:
    s, v, shape = batch(vehicles, 9)
    together = model(s, v, shape)
    for j in range(9):
        for many, one in zip(together, model(s[:, j], v[:, j], member(shape, j)), strict=True):
            np.testing.assert_allclose(many[..., j], one, rtol=1e-14, atol=1e-14)


def test_batches_may_have_two_axes() -> None:
    s, v, shape = batch(5, 6)
    folded = generic(PotentialParameters, **{name: column.reshape(2, 3) for name, column in vars(shape).items()})
    for flat, deep in zip(model(s, v, shape), model(s.reshape(4, 2, 3), v.reshape(5, 2, 3), folded), strict=True):
        np.testing.assert_allclose(deep.reshape(flat.shape), flat, rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("vehicles", [2, 7])
def test_jax_equals_numpy(vehicles: int) -> None:
    jax = pytest.importorskip("jax")
    s, v, shape = batch(vehicles, 9)
    with jax.enable_x64(True):
        run = jax.jit(lambda s, v, columns: model(s, v, generic(PotentialParameters, **columns)))
        results = run(s, v, vars(shape))
    for ours, theirs in zip(model(s, v, shape), results, strict=True):
        assert theirs.dtype == np.float64
        np.testing.assert_allclose(np.asarray(theirs), ours, rtol=RELATIVE, atol=RELATIVE)


def test_jax_derivatives_are_finite_off_the_hill_and_right_on_it() -> None:
    jax = pytest.importorskip("jax")

    @jax.jit  # type: ignore[untyped-decorator]
    def slope(theta: Any, s: Any) -> Any:
        shape = generic(PotentialParameters, alpha=theta[0], r=theta[1], p=theta[2], hill=1.0)
        return potential_slope(s, shape, CONSTANTS)

    with jax.enable_x64(True):
        theta, s = jax.numpy.array([1e-3, 11.0, 5.5]), jax.numpy.array([8.0, 11.0, 12.3, 13.7, 14.0, 19.0, 20.0, 30.0])
        jacobian = np.asarray(jax.jit(jax.jacobian(slope))(theta, s))
        assert np.isfinite(jacobian).all()
        for k, step in enumerate([1e-8, 1e-6, 1e-6]):
            change = np.zeros(3)
            change[k] = step
            upper, lower = slope(theta + change, s), slope(theta - change, s)
            np.testing.assert_allclose(jacobian[:, k], (upper - lower) / (2 * step), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("vehicles", [2, 7])
def test_casadi_equals_numpy(vehicles: int) -> None:
    casadi = pytest.importorskip("casadi")
    s, v, shape = batch(vehicles, 9)
    names = ("alpha", "r", "p", "hill")
    symbols = [casadi.SX.sym("s", vehicles - 1), casadi.SX.sym("v", vehicles), *(casadi.SX.sym(name) for name in names)]
    symbolic_shape = generic(PotentialParameters, **dict(zip(names, symbols[2:], strict=True)))
    function = casadi.Function("model", symbols, model(symbols[0], symbols[1], symbolic_shape))
    for j in range(9):
        one = member(shape, j)
        results = function(s[:, j], v[:, j], one.alpha, one.r, one.p, one.hill)
        for ours, theirs in zip(model(s[:, j], v[:, j], one), results, strict=True):
            flat = np.array(theirs).ravel()
            np.testing.assert_allclose(flat, np.ravel(ours), rtol=RELATIVE, atol=RELATIVE)


def test_casadi_derivatives_are_finite_off_the_hill() -> None:
    casadi = pytest.importorskip("casadi")
    theta, s = casadi.SX.sym("theta", 3), casadi.SX.sym("s", 4)
    shape = generic(PotentialParameters, alpha=theta[0], r=theta[1], p=theta[2], hill=1.0)
    jacobian = casadi.Function("jacobian", [theta, s], [casadi.jacobian(potential_slope(s, shape, CONSTANTS), theta)])
    assert np.isfinite(np.array(jacobian([1e-3, 11.0, 3.0], [8.0, 11.0, 14.0, 25.0]))).all()
