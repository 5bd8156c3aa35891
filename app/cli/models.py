"""`keypose models`: the networks that find keypoints; add one, or remove it."""

from __future__ import annotations

import argparse
from http.client import HTTPException
from urllib.request import urlopen

from keypose.app.cli.json_output import print_json
from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.joint_kinds import KINDS
from keypose.tracker.keypoints.known_person import ENOUGH, SEEN_JOINTS
from keypose.tracker.keypoints.layouts import NETWORK_LAYOUTS
from keypose.tracker.keypoints.model_files import (
    LARGEST_BYTES,
    MODELS,
    Model,
    added_names,
    adding,
    find_model,
)
from keypose.tracker.storage.networks import (
    add_content,
    add_from_file,
    add_own,
    remove_network,
)

PACKAGE = "https://cdn.jsdelivr.net/npm/@mediapipe/pose@0.5.1675469404"
"""Where MediaPipe publishes the networks, file by file."""
TIMEOUT_S = 30.0
"""Until a server that says nothing is given up."""


def run(arguments: argparse.Namespace) -> int:
    action, name = arguments.what, arguments.name
    own = name not in [model.name for model in MODELS] and arguments.file is not None
    if arguments.animals and (action != "add" or not own):
        raise KeypointError("--animals belongs to `keypose models add NAME --from FILE`.")
    option = "--from" if arguments.file is not None else "--sha256"
    if action != "add" and (arguments.file is not None or arguments.sha256 is not None):
        raise KeypointError(f"{option} belongs to `keypose models add NAME`.")
    if action == "list":
        return _list(arguments.json)
    if name is None:
        raise KeypointError(f"Name the network to {action}, as in `keypose models {action} heavy`.")
    if action == "remove":
        remove_network(name)
        return 0
    model = _added(name, arguments)
    if arguments.json:
        print_json(_facts(model))
    else:
        print(f"{model.name}: {model.path}")
        for words in _seen_words(model):
            print(words)
    return 0


def _list(as_json: bool) -> int:
    models, problems = list(MODELS), []
    for name in added_names():
        try:
            models.append(find_model(name))
        except KeypointError as problem:
            problems.append({"name": name, "problem": str(problem)})
    if as_json:
        print_json({"models": [*map(_facts, models), *problems]})
        return 0
    wide = max(len(name) for name in (*added_names(), "thunder"))
    for model in models:
        state = str(model.path) if model.is_here else f"not here: {adding(model)}"
        own = "" if model in MODELS else f"  {_kind(model)}"
        print(f"{model.name:{wide}} {model.size_mb:5.1f} MB  {state}{own}")
    for each in problems:
        print(f"{each['name']:{wide}}           {each['problem']}")
    return 0


def _added(name: str, arguments: argparse.Namespace) -> Model:
    if name not in [model.name for model in MODELS] and arguments.file is not None:
        return add_own(name, arguments.file, arguments.sha256, animals=arguments.animals)
    model = find_model(name)
    if model.bundled:
        raise KeypointError(f"The {name} network comes with Keypose.")
    if model not in MODELS:
        raise KeypointError(f"Name the file of the network: `{adding(model)}`.")
    if arguments.sha256 is not None:
        raise KeypointError(f"The SHA-256 of the {name} network is known: leave out --sha256.")
    if arguments.file is not None:
        add_from_file(model, arguments.file)
    else:
        add_content(model, _downloaded(model), "The download")
    return model


def _facts(model: Model) -> dict[str, object]:
    return {
        "name": model.name,
        "here": model.is_here,
        "path": str(model.path),
        "sha256": model.sha256,
        **({} if model.heads is None else model.heads.model_dump(mode="json")),
    }


def _kind(model: Model) -> str:
    heads = model.heads
    assert heads is not None
    whose = " of animals" if heads.of_animals else ""
    joints = f"{len(NETWORK_LAYOUTS[heads.layout])} joints{whose}"
    return f"{KINDS[heads.kind].title}, {joints}, {heads.width} × {heads.height}"


def _seen_words(model: Model) -> list[str]:
    """What a network finds in the test picture, and what was decided for it."""
    heads = model.heads
    if heads is not None and heads.of_animals:
        return ["It is of animals: it drafts a dog or a horse."]
    if heads is None or heads.finds is None:
        return []
    words = [f"It finds {heads.finds} of {SEEN_JOINTS} joints of a person in a test picture."]
    if heads.levels is not None:
        order, levels = "RGB" if heads.levels.rgb else "BGR", heads.levels
        mean, std = (", ".join(f"{v:g}" for v in each) for each in (levels.mean, levels.std))
        words.append(f"It is shown {order}, less {mean}, over {std}.")
    if heads.finds < ENOUGH:
        words.append(
            "That is few: it may be of something else than people, or want its pictures prepared "
            "in another way."
        )
    if heads.needs_fast:
        words.append("OpenCV computes it otherwise: ONNX Runtime is used, on every computer.")
    return words


def _downloaded(model: Model) -> bytes:
    try:
        with urlopen(f"{PACKAGE}/{model.file}", timeout=TIMEOUT_S) as answer:
            content: bytes = answer.read(LARGEST_BYTES)
    except (OSError, HTTPException) as error:
        reason = getattr(error, "reason", None) or error
        raise KeypointError(
            f"The network cannot be downloaded ({reason}): fetch {PACKAGE}/{model.file} elsewhere "
            f"and run `keypose models add {model.name} --from FILE`."
        ) from None
    return content
