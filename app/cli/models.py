"""`keypose models`: the networks that find keypoints, and how to add one."""

from __future__ import annotations

import argparse
from http.client import HTTPException
from urllib.request import urlopen

from keypose.app.cli.json_output import print_json
from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.model_files import MODELS, Model, find_model
from keypose.tracker.storage.cache import LARGEST_PACKAGE_BYTES, add_content, add_from_file

PACKAGE = "https://cdn.jsdelivr.net/npm/@mediapipe/pose@0.5.1675469404"
"""Where MediaPipe publishes the networks, file by file."""
TIMEOUT_S = 30.0


def run(arguments: argparse.Namespace) -> int:
    if arguments.what == "list":
        if arguments.file is not None:
            raise KeypointError("--from belongs to `keypose models add NAME`.")
        return _list(arguments.json)
    return _add(arguments)


def _list(as_json: bool) -> int:
    if as_json:
        print_json({"models": [_facts(model) for model in MODELS]})
        return 0
    for model in MODELS:
        state = str(model.path) if model.is_here else f"not here: keypose models add {model.name}"
        print(f"{model.name:6} {model.size_mb:5.1f} MB  {state}")
    return 0


def _add(arguments: argparse.Namespace) -> int:
    if arguments.name is None:
        raise KeypointError("Name the network to add, as in `keypose models add heavy`.")
    model = find_model(arguments.name)
    if model.bundled:
        raise KeypointError(f"The {model.name} network comes with Keypose.")
    if arguments.file is not None:
        path = add_from_file(model, arguments.file)
    else:
        path = add_content(model, _downloaded(model), "The download")
    if arguments.json:
        print_json(_facts(model))
    else:
        print(f"{model.name}: {path}")
    return 0


def _facts(model: Model) -> dict[str, object]:
    return {
        "name": model.name,
        "here": model.is_here,
        "path": str(model.path),
        "sha256": model.sha256,
    }


def _downloaded(model: Model) -> bytes:

    try:
        with urlopen(f"{PACKAGE}/{model.file}", timeout=TIMEOUT_S) as answer:
            content: bytes = answer.read(LARGEST_PACKAGE_BYTES)
    except (OSError, HTTPException) as error:
        reason = getattr(error, "reason", None) or error
        raise KeypointError(
            f"The network cannot be downloaded ({reason}): fetch {PACKAGE}/{model.file} elsewhere "
            f"and run `keypose models add {model.name} --from FILE`."
        ) from None
    return content
