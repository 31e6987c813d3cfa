"""The model card that stands beside a network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..whole_file import write_whole
from .by_number import by_number_dict, regret_markdown
from .evaluate import Evaluation, as_markdown

_TEXT = """# {name}

Gives alpha, r, p of the potential for a platoon of {vehicles} vehicles from its initial spacings and speeds.

- **Recipe** `{recipe}`; layers {layers}{ranking}.
- **Made by** `{made}`, seed {seed}
{data}
- **Trained for** starts with {domain} (m, m/s, s), objective {objective}.
- **Input** {input}; **output** `parameters`
  float32 [batch, 3]: alpha [1], r [m], p [1], to be projected into the feasible set. All scaling is in the weights.

## On the road

{judged}
MSE is against the global optima, parameters scaled to [0, 1] by their bounds.
{outside:.1%} of the starts lie outside the training domain.

{table}

Made by `{command}`.
"""
_JUDGED = """Closed-loop regret J/J* - 1 on the first {starts} starts of `{command}`
(SHA-256 `{sha256}`), none of them trained on; J* from the global search."""
_DATA = "- **Data** `{command}`, SHA-256 of the content `{sha256}`."
_EXACT = "`initial_condition` float32 [batch, {columns}]: s_2..s_n [m], v_1..v_n [m/s]"
_ANY = "`gaps` float32 [batch, n-1]: s_2..s_n [m], `speeds` float32 [batch, n]: v_1..v_n [m/s], n = {vehicles}"


def write_card(path: Path, judged: Sequence[Evaluation], command: str, data_commands: Sequence[str]) -> Path:
    """Write the card of a network next to its file.

    Parameters
    ----------
    path : the ONNX file
    judged : evaluations with this network among their answers, one for each number of vehicles
    command : that evaluated it
    data_commands : that made the data of each evaluation

    Returns
    -------
    the card's path
    """
    import onnx

    model = onnx.load(str(path))
    about = {entry.key: entry.value for entry in model.metadata_props}
    tables = [as_markdown(judged[0].scores)] if len(judged) == 1 else [_by_number(judged)]
    sets = zip(about["psp_data_command"].split("; "), about["psp_data_sha256"].split(), strict=False)
    shares = [each.out_of_domain.get(path.stem, 0.0) for each in judged]
    text = _TEXT.format(
        name=path.name,
        recipe=about["psp_recipe"],
        made=about["psp_command"],
        seed=about["psp_seed"],
        data="\n".join(_DATA.format(command=name, sha256=digest) for name, digest in sets),
        domain=about["psp_domain"],
        objective=about["psp_objective"],
        judged="\n".join(map(_judged, judged, data_commands)),
        outside=max(shares),
        table="\n\n".join(tables),
        command=command,
        **_shape(model, about),
    )
    card = path.with_suffix(".md")
    write_whole(card, text)
    return card


def _by_number(judged: Sequence[Evaluation]) -> str:
    head = "Mean regret by number of vehicles, its 95 % quantile in brackets:"
    parts = [f"{each.data.problem.vehicles} vehicles:\n\n{as_markdown(each.scores)}" for each in judged]
    return "\n\n".join([head, regret_markdown(by_number_dict(judged)), *parts])


def _judged(evaluation: Evaluation, command: str) -> str:
    data = evaluation.data
    return _JUDGED.format(starts=len(data.J), command=command, sha256=data.sha256)


def _shape(model: Any, about: Mapping[str, str]) -> dict[str, str]:
    """The words of the card on layers, input and number of vehicles."""
    shapes = {tensor.name: list(tensor.dims) for tensor in model.graph.initializer}
    chains = {
        prefix: _chain([dims for name, dims in shapes.items() if name.startswith(f"{prefix}_W")])
        for prefix in ("parameters", "scores")
    }
    ranking = ""
    if chains["scores"]:
        ranking = f"; ranks {shapes['dictionary_values'][0]} candidates by layers {chains['scores']}"
    if "psp_vehicles" in about:
        vehicles = about["psp_vehicles"]
        port = _EXACT.format(columns=2 * int(vehicles) - 1)
    else:
        vehicles = f"{about['psp_vehicles_min']} to {about['psp_vehicles_max']}"
        port = _ANY.format(vehicles=vehicles)
    return {"vehicles": vehicles, "layers": chains["parameters"], "ranking": ranking, "input": port}


def _chain(shapes: list[list[int]]) -> str:
    """Widths of a chain of layers, a bar where spacings are pooled: the next layer takes twice as much."""
    words = [str(shapes[0][0])] if shapes else []
    for (_, width), (taken, _) in zip(shapes, [*shapes[1:], [0, 0]], strict=True):
        words.append(f"{width} | {taken}" if taken > width else str(width))
    return "-".join(words)
