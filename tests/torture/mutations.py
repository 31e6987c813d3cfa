"""Ways to spoil a file: bytes, text, archives and networks."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping

import numpy as np

Rng = np.random.Generator

_TOKENS = (
    b"nan", b"inf", b"-1", b"0", b"1e999", b"-1e-999", b"99999999999999999999999", b"1" * 5000, b"", b'"', b"'", b"\0",
    b"\xff\xfe", b"\xf0\x9f\x9a\x97", b"[" * 3000, b"{" * 3000, b"../../evil", b"/etc/passwd", b"%s%n", b"${x}", b"\r",
    b"\n", b"=", b",", b";", b"<!--", b"&lol;", b"<a>" * 2000, b"null", b"true", b"2147483648", b"1000000000",
)  # fmt: skip


def pick(rng: Rng, values: object) -> object:
    """One of some values."""
    return values[int(rng.integers(len(values)))]


def spoiled(rng: Rng, content: bytes) -> bytes:
    """Bytes flipped, cut out, doubled, cut off, or replaced by what parsers trip over."""
    data = bytearray(content)
    for _ in range(int(rng.integers(1, 4))):
        place = int(rng.integers(len(data) + 1))
        end = min(len(data), place + int(2 ** rng.integers(0, 8)))
        kind = int(rng.integers(6))
        if kind == 0 and place < len(data):
            data[place] ^= 1 << int(rng.integers(8))
        elif kind == 1:
            del data[place:end]
        elif kind == 2:
            data[place:place] = data[place:end] * int(rng.integers(1, 20))
        elif kind == 3 and rng.random() < 0.3:
            del data[place:]
        elif kind == 4:
            data[place:end] = rng.bytes(end - place)
        else:
            data[place:end] = pick(rng, _TOKENS)
    return bytes(data)


def spoiled_text(rng: Rng, content: bytes) -> bytes:
    """Words of a text replaced by what parsers trip over; now and then any bytes."""
    if rng.random() < 0.3:
        return spoiled(rng, content)
    separators = (b"=", b",", b"\n", b'"', b" ", b"]")
    separator: bytes = pick(rng, [s for s in separators if s in content] or [b"\n"])
    words = content.split(separator)
    for _ in range(int(rng.integers(1, 4))):
        place = int(rng.integers(len(words)))
        kind = int(rng.integers(4))
        if kind == 0:
            words[place] = pick(rng, _TOKENS)
        elif kind == 1:
            words.insert(place, words[int(rng.integers(len(words)))])
        elif kind == 2 and len(words) > 1:
            del words[place]
        else:
            other = int(rng.integers(len(words)))
            words[place], words[other] = words[other], words[place]
    return separator.join(words)


def spoiled_archive(rng: Rng, files: Mapping[str, bytes], hostile: Mapping[str, bytes]) -> bytes:
    """A zip file with spoiled or hostile members, or spoiled itself.

    Parameters
    ----------
    files : content by name
    hostile : members to add, by names that want to leave the folder
    """
    members = dict(files)
    kind = int(rng.integers(5))
    if kind == 0:  # a library that another program was written into is no matter of reading files
        name = str(pick(rng, [name for name in members if not name.startswith("binaries/")]))
        members[name] = spoiled_text(rng, members[name])
    elif kind == 1:
        del members[str(pick(rng, list(members)))]
    elif kind == 2:
        name = str(pick(rng, list(hostile)))
        members[name] = hostile[name]
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in members.items():
            info = zipfile.ZipInfo(name)
            info.external_attr = (0o120777 if name.endswith("link") else 0o644) << 16
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, content)
    data = out.getvalue()
    if kind == 3:
        return spoiled(rng, data)
    if kind == 4:  # the directory at the end, where flags, sizes and methods stand
        head, tail = data[: -len(members) * 70], data[-len(members) * 70 :]
        return head + spoiled(rng, tail)
    return data


def spoiled_network(rng: Rng, content: bytes) -> bytes:
    """An ONNX file with a spoiled graph or hostile metadata, or spoiled itself."""
    import onnx

    if rng.random() < 0.3:
        return spoiled(rng, content)
    model = onnx.load_from_string(content)
    graph = model.graph
    kind = int(rng.integers(8))
    if kind == 0:
        graph.node[int(rng.integers(len(graph.node)))].op_type = str(
            pick(rng, ["Loop", "Relu", "Foo", "Sum", "If", ""])
        )
    elif kind == 1:
        del graph.node[int(rng.integers(len(graph.node)))]
    elif kind == 2:
        tensor = graph.initializer[int(rng.integers(len(graph.initializer)))]
        tensor.dims[0] = int(pick(rng, [0, -1, 1, 2**40, 3]))
    elif kind == 3:
        tensor = graph.initializer[int(rng.integers(len(graph.initializer)))]
        tensor.ClearField("raw_data")
        tensor.data_location = onnx.TensorProto.EXTERNAL
        entry = tensor.external_data.add()
        entry.key, entry.value = "location", str(pick(rng, ["../../../etc/passwd", "/etc/passwd", "none.bin"]))
    elif kind == 4:
        tensor = graph.initializer[int(rng.integers(len(graph.initializer)))]
        values = np.frombuffer(tensor.raw_data, np.float32).copy()
        values[int(rng.integers(values.size))] = pick(rng, [np.nan, np.inf, 3e38, -3e38])
        tensor.raw_data = values.tobytes()
    elif kind == 5:
        port = pick(rng, [graph.input, graph.output])[0]
        port.type.tensor_type.shape.dim[-1].dim_value = int(pick(rng, [1, 0, 3, 8, 2**31]))
    else:
        entry = pick(rng, model.metadata_props)
        values = [json.dumps({}), "[1]", "nan", "-3", "1e9", "{", '{"gap_min": "x"}', "[" * 5000, "9" * 5000, "null"]
        entry.value = str(pick(rng, values)) if rng.random() < 0.6 else _spoiled_json(rng, entry.value)
    return bytes(model.SerializeToString())


def _spoiled_json(rng: Rng, text: str) -> str:
    """JSON with one value replaced, or the text spoiled."""
    try:
        table = json.loads(text)
        table[str(pick(rng, list(table)))] = pick(rng, [None, "x", -1, 0, 1e400, [], 10**400, float("nan"), True])
        return json.dumps(table)
    except (ValueError, TypeError, AttributeError):
        return spoiled_text(rng, text.encode()).decode(errors="replace").replace("\0", "")
