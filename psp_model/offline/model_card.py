"""The model card that stands beside a network."""

from __future__ import annotations

from pathlib import Path

from .evaluate import Evaluation, as_markdown
from .whole_file import write_whole

_TEXT = """# {name}

Gives alpha, r, p of the potential for a platoon of {vehicles} vehicles from its initial gaps and speeds.

- **Recipe** `{recipe}`; layers {layers}{ranking}.
- **Made by** `{made}`, seed {seed}
- **Data** `{data_command}`, SHA-256 of the content `{data}`.
- **Trained for** starts with {domain} (m, m/s, s), objective {objective}.
- **Input** `initial_condition` float32 [batch, {columns}]: s_2..s_n [m], v_1..v_n [m/s]; **output** `parameters`
  float32 [batch, 3]: alpha [1], r [m], p [1], to be projected into the feasible set. All scaling is in the weights.

## On the road

Closed-loop regret J/J* - 1 on the first {starts} starts of `{held_command}`
(SHA-256 `{held}`), none of them trained on; J* from the global search.
MSE is against the global optima, parameters scaled to [0, 1] by their bounds.
{outside:.1%} of the starts lie outside the training domain.

{table}

Made by `{command}`.
"""


def write_card(path: Path, evaluation: Evaluation, command: str) -> Path:
    """Write the card of a network next to its file.

    Parameters
    ----------
    path : the ONNX file
    evaluation : with this network among its answers
    command : that evaluated it

    Returns
    -------
    the card's path
    """
    import onnx

    model = onnx.load(str(path))
    about = {entry.key: entry.value for entry in model.metadata_props}
    shapes = {tensor.name: list(tensor.dims) for tensor in model.graph.initializer}
    widths = {
        prefix: [dims for name, dims in shapes.items() if name.startswith(f"{prefix}_W")]
        for prefix in ("parameters", "scores")
    }
    ranking = ""
    if widths["scores"]:
        ranking = f"; ranks {shapes['dictionary_values'][0]} candidates by layers {_chain(widths['scores'])}"
    text = _TEXT.format(
        name=path.name,
        vehicles=about["psp_vehicles"],
        recipe=about["psp_recipe"],
        layers=_chain(widths["parameters"]),
        ranking=ranking,
        made=about["psp_command"],
        seed=about["psp_seed"],
        data=about["psp_data_sha256"],
        data_command=about["psp_data_command"],
        domain=about["psp_domain"],
        objective=about["psp_objective"],
        columns=2 * int(about["psp_vehicles"]) - 1,
        starts=len(evaluation.data.J),
        held=evaluation.data.sha256,
        held_command=evaluation.data.command,
        outside=evaluation.out_of_domain.get(path.stem, 0.0),
        table=as_markdown(evaluation.scores),
        command=command,
    )
    card = path.with_suffix(".md")
    write_whole(card, text)
    return card


def _chain(shapes: list[list[int]]) -> str:
    return "-".join(str(width) for width in [shapes[0][0], *(dims[1] for dims in shapes)])
