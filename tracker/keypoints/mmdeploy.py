"""Read how MMDeploy's `pipeline.json` says that a network is shown its pictures."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, Final

from pydantic import ValidationError

from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.model_files import Levels

PREPROCESS: Final = "Preprocess"
AS_WE_DO: Final = frozenset(
    {
        "LoadImage",
        "LoadImageFromFile",
        "GetBBoxCenterScale",
        "TopDownGetBboxCenterScale",
        "TopDownAffine",
        "TopdownAffine",
        "ToTensor",
        "ImageToTensor",
        "DefaultFormatBundle",
        "Collect",
        "PackPoseInputs",
    }
)
"""Steps that cut out the person and hand the picture over, which every network here is shown."""
UNIT: Final = 255.0
"""Levels that `NormalizeTensor` counts as 1."""


def levels_of(content: bytes, size: tuple[int, int], source: str) -> Levels | None:
    """How pictures are prepared; None where the file does not say it.

    size: width and height of the network's input, pixels.  source: what the file is called in a
    sentence. KeypointError where it is damaged, or says what cannot be followed.
    """
    try:
        steps = _steps(json.loads(content))
        levels = None
        for step in steps:
            kind = step.get("type")
            if kind in ("Normalize", "NormalizeTensor"):
                levels = _levels(step, UNIT if kind == "NormalizeTensor" else 1.0)
            elif kind not in AS_WE_DO:
                raise KeypointError(
                    f"The pipeline.json in {source} prepares pictures by {str(kind)[:40]!r}, which "
                    "is not followed here."
                )
            _require_size(step, size, source)
    except (ValueError, TypeError, LookupError, AttributeError, ValidationError):
        raise KeypointError(f"The pipeline.json in {source} is damaged.") from None
    return levels


def _steps(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    tasks = document.get("pipeline", {}).get("tasks", [])
    return [
        step
        for task in tasks
        if task.get("name") == PREPROCESS
        for step in task.get("transforms", [])
    ]


def _levels(step: Mapping[str, Any], unit: float) -> Levels:
    mean, std = ([unit * float(value) for value in step[name]] for name in ("mean", "std"))
    rgb = bool(step.get("to_rgb", True))
    return Levels.model_validate({"mean": mean, "std": std, "rgb": rgb})


def _require_size(step: Mapping[str, Any], size: tuple[int, int], source: str) -> None:
    said = step.get("image_size")
    if said is not None and tuple(said) != size:
        raise KeypointError(
            f"The pipeline.json in {source} is of an input of {said[0]} × {said[1]} pixels, and "
            f"the network has {size[0]} × {size[1]}."
        )
