"""The bundled clips. They are opened as copies: the originals are never written."""

from __future__ import annotations

import secrets
import shutil
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from keypose.tracker.errors import KeyposeError
from keypose.tracker.storage.atomic import make_folder

_COPIED = {".mp4", ".json", ".md", ".ply", ""}
"""Endings of what goes along: clip or surfaces, session, how they are described, the licence."""


@dataclass(frozen=True)
class Sample:
    """A folder of sample_videos and what is in it."""

    name: str
    words: str


SAMPLES = (
    Sample("walk", "A woman walks across a lawn. 153 frames, 8 keyframes, feet pinned."),
    Sample("balance", "A man walks a beam and leans over. 61 frames, 5 keyframes."),
    Sample("person", "A rendered figure walks by. 73 frames, 4 keyframes."),
    Sample("arms", "Three arms close and touch. 19 frames of surfaces, no video, 1 keyframe."),
    Sample("box", "A box tumbles through the picture. 41 frames, 2 keyframes."),
)


def bundled_samples(folder: Path) -> tuple[Sample, ...]:
    """List the samples that are there: a program may be installed without them."""
    return tuple(s for s in SAMPLES if (folder / s.name / "session.json").is_file())


def own_copy(folder: Path, name: str, workspace: Path) -> Path:
    """The session of the workspace's copy of a sample, which is made when there is none yet."""
    if name not in {sample.name for sample in bundled_samples(folder)}:
        raise KeyposeError("This sample does not exist.")
    place = workspace / name
    if not (place / "session.json").is_file():
        make_folder(workspace, error=KeyposeError)
        _copy(folder / name, place)
    return place / "session.json"


def _copy(source: Path, place: Path) -> None:
    """Whole or not at all: the folder gets its name once everything is in it."""
    temporary = place.with_name(f".{place.name}.{secrets.token_hex(6)}.part")
    try:
        for file in source.rglob("*"):
            if file.is_file() and file.suffix in _COPIED:
                copy = temporary / file.relative_to(source)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(file, copy)
        with suppress(FileNotFoundError):
            place.rmdir()  # left empty by hand
        temporary.rename(place)
    except OSError as problem:
        why = problem.strerror or problem
        raise KeyposeError(f"The sample cannot be copied to {str(place)!r}: {why}.") from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
