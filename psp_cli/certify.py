"""`psp certify`: Lemma 1, or the exact period, for a start or a whole run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import (
    FIXED_INSTEAD,
    Duration,
    Json,
    Network,
    ScenarioFile,
    Seed,
    Set,
    Vehicles,
    gather,
    network_file,
    say_no_network,
)
from .output import json_place, keep_stdout, say, say_on_stderr, write_json

if TYPE_CHECKING:
    from psp_model.analysis.certificate import Certificate


def certify(
    vehicles: Vehicles = None,
    assignments: Set = None,
    scenario: ScenarioFile = None,
    seed: Seed = None,
    duration: Duration = None,
    network: Network = None,
    start_only: Annotated[bool, typer.Option("--start-only", help="Judge the start, not the whole run.")] = False,
    json: Json = None,
) -> None:
    """Report whether T is certified, and who limits it.

    When, by how much, and the largest T that holds throughout: by Lemma 1, or with --set certificate=2 by the exact
    period.

    The exit code is 0 where the period is certified and 1 where it is not.
    """
    from dataclasses import replace

    from psp_model import Lemma1Policy
    from psp_model.analysis.cases import run_case
    from psp_model.analysis.certificate import largest_certified_period

    from .settings import setup

    keep_stdout(place := json_place(json))
    wanted = gather(vehicles, scenario, assignments, seed, duration)
    trained = network_file(wanted.vehicles, network)
    if trained is None and "parameter_source" not in wanted.values:
        say_no_network(wanted.vehicles, FIXED_INSTEAD)
    asked = setup(wanted.values, wanted.vehicles, trained is not None)
    T = asked.sampling.T
    asked = replace(asked, sampling=replace(asked.sampling, policy=Lemma1Policy.WARN))
    length = T if start_only else wanted.duration
    case = run_case("run", asked, trained, max(length, T))
    certificate, shape = case.certificate, case.shape
    for sentence in case.warnings:
        say_on_stderr(f"psp: warning: {sentence}")
    say(f"potential: alpha = {shape.alpha:.6g}, r = {shape.r:.6g} m, p = {shape.p:.6g} ({case.origin})")
    say(f"at the start: {_line(certificate, 0)}")
    certified = bool(certificate.certified[0] if start_only else certificate.certified.all())
    found: dict[str, Any] = {"certified": certified, "alpha": shape.alpha, "r": shape.r, "p": shape.p}
    found |= {"origin": case.origin, "warnings": case.warnings, "start": _instant(certificate, 0)}
    if not start_only:
        found |= _whole_run(certificate)
        law, chosen = asked.cooperation, asked.sampling.certificate
        largest = largest_certified_period(asked.start, shape, wanted.duration, cooperation=law, certificate=chosen)
        found["T_largest"] = largest
        say(f"largest T found that holds throughout {wanted.duration:g} s: {found['T_largest']:.6g} s")
    if place is not None:
        write_json(place, found)
    raise typer.Exit(0 if certified else 1)


def _whole_run(certificate: Certificate) -> dict[str, Any]:
    """Say what holds after the start, and give it for JSON."""
    say(f"tightest: {_line(certificate, certificate.tightest)}")
    refused = [[float(begin), float(end)] for begin, end in certificate.refused()]
    for begin, end in refused:
        say(f"not certified from t = {begin:.6g} s to {end:.6g} s")
    return {"tightest": _instant(certificate, certificate.tightest), "not_certified": refused}


def _instant(certificate: Certificate, k: int) -> dict[str, Any]:
    """One time of a certificate, for JSON."""
    verdict = bool(certificate.certified[k])
    at = {"t": certificate.time[k], "T": certificate.T, certificate.bound: certificate.T_max[k], "certified": verdict}
    return at | {"who": certificate.who(k)}


def _line(certificate: Certificate, k: int) -> str:
    """T against T_max at one time, and who sets it."""
    T, bound, name = certificate.T, certificate.T_max[k], certificate.bound
    verdict = "certified" if certificate.certified[k] else "not certified"
    return (
        f"t = {certificate.time[k]:.6g} s: T = {T:.6g} s, {name} = {bound:.6g} s, {verdict} "
        f"({name}/T = {bound / T:.4g}); {certificate.who(k)}"
    )
