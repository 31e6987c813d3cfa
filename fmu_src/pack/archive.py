"""An FMU as one file: the same content always gives the same bytes."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path

from psp_model.whole_file import whole_file

_EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest time a zip file can hold: builds contain no time stamps


def content_digest(files: Mapping[str, bytes]) -> str:
    """SHA-256 over names and contents, as hexadecimal text.

    Parameters
    ----------
    files : content by name
    """
    digest = sha256()
    for name in sorted(files):
        digest.update(f"{name}\0{len(files[name])}\0".encode())
        digest.update(files[name])
    return digest.hexdigest()


def guid_of(digest: str) -> str:
    """A GUID that is the same for the same content, in the form FMI tools expect.

    Parameters
    ----------
    digest : from `content_digest`
    """
    return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"


def write_fmu(path: Path, files: Mapping[str, bytes]) -> None:
    """Write the archive, whole or not at all; modelDescription.xml comes first, for readers that stream.

    Parameters
    ----------
    path : of the FMU; its folder is made if it is missing
    files : content by name inside the archive
    """
    order = sorted(files, key=lambda name: (name != "modelDescription.xml", name))
    with whole_file(path) as partial, zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in order:
            info = zipfile.ZipInfo(name, _EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3  # Unix, on every system
            info.external_attr = 0o644 << 16
            archive.writestr(info, files[name])
