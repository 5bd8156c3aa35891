"""A full-body model of OpenSim (.osim, version 4): its bodies, and where its joints are on them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.files import read_regular
from keypose.tracker.geometry.rotations import Array, frozen

LARGEST_BYTES = 64 * 2**20
OLDEST = 40000

SIDES: Final = ("r", "l")
NEEDED: Final = (
    *("pelvis", "torso"),
    *(
        f"{body}_{side}"
        for body in ("femur", "tibia", "talus", "calcn", "humerus", "ulna", "radius", "hand")
        for side in SIDES
    ),
)
"""Bodies after Rajagopal et al. (2016), which this program's body is compared with."""


@dataclass(frozen=True, eq=False)
class ModelJoint:
    """The joint by which a body hangs on its parent: its place in both frames (3,), metres."""

    parent: str
    p_parent: Array
    p_body: Array


@dataclass(frozen=True, eq=False)
class OpenSimModel:
    """name:   of the model.
    bodies:    by name, all of them.
    joints:    by the body that hangs on them.
    coordinates: the names of the joints' coordinates.
    """

    name: str
    bodies: tuple[str, ...]
    joints: Mapping[str, ModelJoint]
    coordinates: tuple[str, ...]


def read_model(path: Path) -> OpenSimModel:
    """The model in a file. FormatError in one sentence where it is none, or not of a whole body."""
    try:
        content = read_regular(path, LARGEST_BYTES)
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}.") from None
    return model_of(path.name, content)


def model_of(file: str, content: bytes) -> OpenSimModel:
    """The model in a file's content; FormatError as `read_model`."""
    root = _document(file, content)
    model = root.find("Model")
    if model is None:
        raise FormatError(f"{file} holds no model of OpenSim.")
    bodies = tuple(body.get("name", "") for body in model.iterfind("BodySet/objects/Body"))
    joints = dict(_joint(file, joint) for joint in model.iterfind("JointSet/objects/*"))
    missing = [name for name in NEEDED if name not in bodies or name not in joints]
    if missing:
        raise FormatError(
            f"{file} has no {missing[0]}: a full-body model with arms is needed whose bodies are "
            "named as in Rajagopal's, such as Pose2Sim's Model_Pose2Sim_simple.osim."
        )
    names = (c.get("name", "") for c in model.iterfind("JointSet/objects/*/coordinates/Coordinate"))
    return OpenSimModel(model.get("name", ""), bodies, joints, tuple(names))


def _document(file: str, content: bytes) -> Element:
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise FormatError(f"{file} declares a document type, which models of OpenSim do not.")
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise FormatError(f"{file} is not XML: {error}.") from None
    version = root.get("Version", "")
    if root.tag != "OpenSimDocument" or not re.fullmatch("[0-9]{1,9}", version):
        raise FormatError(f"{file} is no document of OpenSim.")
    if int(version) < OLDEST:
        raise FormatError(f"{file} is of OpenSim 3 or older: open it in OpenSim 4 and save it.")
    return root


def _joint(file: str, joint: Element) -> tuple[str, ModelJoint]:
    """The body that hangs on a joint, and the joint."""
    frames = {frame.get("name", ""): frame for frame in joint.iterfind("frames/*")}
    parent, p_parent = _base(file, joint, frames, "socket_parent_frame")
    body, p_body = _base(file, joint, frames, "socket_child_frame")
    return body, ModelJoint(parent, p_parent, p_body)


def _base(file: str, joint: Element, frames: dict[str, Element], end: str) -> tuple[str, Array]:
    """The body under one end of a joint, and where on it the joint is."""
    name = joint.findtext(end, "").strip()
    frame = frames.get(name.rpartition("/")[2])
    if frame is None:
        return name.rpartition("/")[2], frozen(np.zeros(3))
    place = _three(file, frame.findtext("translation", "0 0 0"))
    return frame.findtext("socket_parent", "").strip().rpartition("/")[2], place


def _three(file: str, text: str) -> Array:
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.zeros(0)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise FormatError(f"{file} has {text.strip()[:40]!r} where three numbers are due.")
    return frozen(values)
