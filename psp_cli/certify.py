"""`psp certify`: Lemma 1 for a start or a whole run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .options import (
    FIXED_INSTEAD,
    Duration,
    Network,
    ScenarioFile,
    Seed,
    Set,
    Vehicles,
    gather,
    network_file,
    say_no_network,
)

if TYPE_CHECKING:
    from psp_view.certificate import Certificate


def certify(
    vehicles: Vehicles = None,
    assignments: Set = None,
    scenario: ScenarioFile = None,
    seed: Seed = None,
    duration: Duration = None,
    network: Network = None,
    start_only: Annotated[bool, typer.Option("--start-only", help="Judge the start, not the whole run.")] = False,
) -> None:
    """Say whether Lemma 1 certifies T, and who limits it.

    When, by how much, and the largest T that holds throughout.

    The exit code is 0 where the period is certified and 1 where it is not.
    """
    from dataclasses import replace

    from psp_model import Lemma1Policy
    from psp_view.cases import run_case
    from psp_view.certificate import largest_certified_period

    from .settings import setup

    wanted = gather(vehicles, scenario, assignments, seed, duration)
    trained = network_file(wanted.vehicles, network)
    if trained is None and "parameter_source" not in wanted.values:
        say_no_network(wanted.vehicles, FIXED_INSTEAD)
    asked = setup(wanted.values, wanted.vehicles, trained is not None)
    T = asked.sampling.T
    asked = replace(asked, sampling=replace(asked.sampling, policy=Lemma1Policy.WARN))
    length = T if start_only else wanted.duration
    case = run_case("run", asked, trained, max(length, T))
    certificate = case.certificate
    shape = case.shape
    typer.echo(f"potential: alpha = {shape.alpha:.6g}, r = {shape.r:.6g} m, p = {shape.p:.6g} ({case.origin})")
    typer.echo(f"at the start: {_line(certificate, 0)}")
    if start_only:
        raise typer.Exit(0 if certificate.certified[0] else 1)
    typer.echo(f"tightest: {_line(certificate, certificate.tightest)}")
    for begin, end in certificate.refused():
        typer.echo(f"not certified from t = {begin:.6g} s to {end:.6g} s")
    largest = largest_certified_period(case.setup.start, shape, wanted.duration)
    typer.echo(f"largest T found that holds throughout {wanted.duration:g} s: {largest:.6g} s")
    raise typer.Exit(0 if certificate.certified.all() else 1)


def _line(certificate: Certificate, k: int) -> str:
    """T against T_max at one time, and who sets it."""
    T, bound = certificate.T, certificate.T_max[k]
    verdict = "certified" if certificate.certified[k] else "not certified"
    return (
        f"t = {certificate.time[k]:.6g} s: T = {T:.6g} s, T_max = {bound:.6g} s, {verdict} "
        f"(T_max/T = {bound / T:.4g}); {certificate.who(k)}"
    )
