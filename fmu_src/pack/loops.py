"""Controller, vehicles and a leader as one flat .ssp: the loop of ideal vehicles, and real ones behind a leader."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from zipfile import ZipFile

from psp_model.vehicles.leader import LeaderSpeed, Wave, profile_of

from ..errors import ParameterError
from .ssp import (
    SCENARIOS,
    Connector,
    System,
    SystemComponent,
    Values,
    parameter_connectors,
    parameters_of,
    with_values,
    write_ssp,
)

_PROFILE = "resources/profile.csv"  # in a leader that was built with one
_WAVE = ("v_high", "v_low", "begin", "period")


def loop_connections(vehicles: int) -> list[tuple[Connector, Connector]]:
    """Plant to controller and back.

    Parameters
    ----------
    vehicles : n
    """
    measured = [f"s[{i}]" for i in range(2, vehicles + 1)] + [f"v[{i}]" for i in range(1, vehicles + 1)]
    forth = [(("plant", name), ("controller", name)) for name in measured]
    return forth + [(("controller", f"a[{i}]"), ("plant", f"a[{i}]")) for i in range(1, vehicles + 1)]


def loop_parameters(fmus: Mapping[str, Path], values: Values) -> dict[str, dict[str, dict[str, float]]]:
    """Parameters of the loop's components by component and scenario; "given" are the values unchanged.

    Parameters
    ----------
    fmus : by component; one is the controller
    values : by name; each component takes its own

    Raises
    ------
    ParameterError : where a name belongs to no component, or a value is none that its parameter can have
    """
    parameters = {name: parameters_of(fmu) for name, fmu in fmus.items()}
    own = set().union(*parameters.values())
    unknown = sorted(set(values) - own)
    if unknown:
        raise ParameterError(f"{unknown[0]} is no parameter of {', '.join(fmus)}", "leave it out, or correct its name")
    scenarios = {"given": values} | {name: {**values, **changed} for name, changed in SCENARIOS.items()}
    half = 0.5 * with_values(parameters["controller"], values)["T"]
    return {
        name: {title: with_values(starts, {"phase": half, **chosen}) for title, chosen in scenarios.items()}
        for name, starts in parameters.items()
    }


def write_loop(
    path: Path, plant: Path, controller: Path, vehicles: int, values: Mapping[str, float], leader: Path | None = None
) -> Path:
    """A platoon of a plant, a controller and perhaps a leader FMU, with a communication step of T/4.

    Masters that exchange values between steps only pass the command one step late: the controller samples in the
    middle of the plant's period the state at its beginning, and the plant applies the command to the whole period.

    Parameters
    ----------
    path : of the .ssp file
    plant, controller : the FMUs
    vehicles : n
    values : parameters by name, start values of the FMUs where there is none; each component takes its own.
        SystemStructure.ssd binds them as they are, scenario1.ssd and scenario2.ssd with what these scenarios change
    leader : FMU whose speed is the desired speed of all

    Returns
    -------
    path

    Raises
    ------
    ParameterError : where a name belongs to no component, or a value is none that its parameter can have
    """
    fmus, connections = {"plant": plant, "controller": controller}, loop_connections(vehicles)
    if leader is not None:
        fmus |= {"leader": leader}
        connections.append((("leader", "v"), ("controller", "v_desired")))
    return write_connected(path, fmus, connections, loop_parameters(fmus, values))


def write_connected(
    path: Path,
    fmus: Mapping[str, Path],
    connections: Sequence[tuple[Connector, Connector]],
    sets: Mapping[str, Mapping[str, Values]],
    watched: Mapping[str, Sequence[str]] | None = None,
) -> Path:
    """FMUs around a controller as a flat archive, with a communication step of T/4.

    Parameters
    ----------
    path : of the .ssp file
    fmus, connections : by component; one is the controller
    sets : parameters by component and scenario, "given" by default
    watched : further outputs that are connectors, by component: some masters record no others

    Returns
    -------
    path
    """
    components = {}
    for name, fmu in fmus.items():
        inputs = {variable: ("input", "Real") for _, (owner, variable) in connections if owner == name}
        outputs = {variable: ("output", "Real") for (owner, variable), _ in connections if owner == name}
        outputs |= {variable: ("output", "Real") for variable in (watched or {}).get(name, ())}
        connectors = parameter_connectors(sets[name]["given"]) | inputs | outputs
        components[name] = SystemComponent(fmu, connectors, sets[name])
    step_size = 0.25 * sets["controller"]["given"]["T"]
    system = System(path.stem, components, connections, step_size=step_size)
    return write_ssp(path, system, "given", tuple(SCENARIOS))


def speed_of(leader: Path, values: Mapping[str, float]) -> LeaderSpeed:
    """What a leader FMU drives over the time since `begin`, where it has a profile, else since the start.

    Parameters
    ----------
    leader : the FMU
    values : its parameters
    """
    with ZipFile(leader) as archive:
        if _PROFILE in archive.namelist():
            return profile_of(archive.read(_PROFILE).decode("utf-8-sig"))
    return Wave(*(values[name] for name in _WAVE))


def road_connections(vehicles: int) -> list[tuple[Connector, Connector]]:
    """Plant to controller and back, but for the first vehicle, which is the leader.

    That it drives itself is an output of the leader: masters treat inputs that nothing is connected to differently.

    Parameters
    ----------
    vehicles : n
    """
    loop = [(one, other) for one, other in loop_connections(vehicles) if one != ("controller", "a[1]")]
    told = {"v": [("controller", "v_desired")]}
    told |= {"a": [("plant", "a[1]"), ("controller", "a_measured[1]")]}
    told |= {"automated": [("plant", "automated[1]"), ("controller", "automated[1]")]}
    return [*loop, *((("leader", output), target) for output, targets in told.items() for target in targets)]


def write_road_loop(
    path: Path, plant: Path, controller: Path, leader: Path, vehicles: int, values: Mapping[str, float]
) -> Path:
    """Real vehicles behind a leader who drives himself: a plant, a controller and a leader FMU; see `write_loop`.

    Vehicle 1 has the leader's acceleration, which the controller is told, and is automated for nobody.  It begins at
    the leader's speed unless v_start[1] is given, and is as much ahead of the leader as the last step of a period, 3/4
    T.  Dead time, lags, limits and lengths are those of the plant for the controller too.

    Parameters
    ----------
    path : of the .ssp file
    plant, controller, leader : the FMUs
    vehicles : n
    values : parameters by name, as for `write_loop`

    Returns
    -------
    path

    Raises
    ------
    ParameterError : where a name belongs to no component, or a value is none that its parameter can have
    ModelError : where the leader's wave is none
    """
    fmus = {"plant": plant, "controller": controller, "leader": leader}
    sets = loop_parameters(fmus, values)
    for scenario, parameters in sets["leader"].items():
        profile = "v_high" not in parameters
        begins = speed_of(leader, parameters).speed(-parameters["begin"] if profile else 0.0)
        if "v_start[1]" not in values:
            sets["plant"][scenario]["v_start[1]"] = begins
        for i in range(1, vehicles + 1):
            sets["controller"][scenario][f"length[{i}]"] = sets["plant"][scenario][f"length[{i}]"]
    watched = {"plant": [f"clearance[{i}]" for i in range(2, vehicles + 1)]}
    return write_connected(path, fmus, road_connections(vehicles), sets, watched)
