"""Show a new network a picture of a person whose joints are known, and count which it finds.

What a network is shown, red or blue first, less which mean, no file says; shown otherwise than it
was trained it answers without a word, only wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.joint_kinds import IMAGENET
from keypose.tracker.keypoints.joint_network import JointNetwork
from keypose.tracker.keypoints.model_files import THUNDER, JointHeads, Levels, Model
from keypose.tracker.keypoints.region import Region
from keypose.tracker.keypoints.runtimes import Runtime

PICTURE: Final = Path(__file__).with_name("models") / "person.jpg"
REGION: Final = Region(159.5, 244.5, 550.0)
"""Around the man in it."""
HEIGHT_PX: Final = 440.0
FOUND: Final = 0.05
"""A joint is found that lies so near to where it is, a share of the man's height."""
SEEN_JOINTS: Final = 17
"""COCO's, which every network here finds."""
ENOUGH: Final = 9
"""A network that finds fewer of them sees no person, or a picture that it cannot read."""
CLEARLY: Final = 4
"""Joints that another way to show the picture has to find more, to be taken in place of the usual
one of its kind."""
WAYS: Final = (
    IMAGENET,
    Levels(mean=IMAGENET.mean[::-1], std=IMAGENET.std[::-1], rgb=False),
    Levels(mean=IMAGENET.mean, std=IMAGENET.std, rgb=False),
    Levels(mean=(0.0, 0.0, 0.0), std=(255.0, 255.0, 255.0), rgb=True),
    Levels(mean=(0.0, 0.0, 0.0), std=(255.0, 255.0, 255.0), rgb=False),
    Levels(mean=(103.53, 116.535, 122.4), std=(255.0, 255.0, 255.0), rgb=True),
    Levels(mean=(0.0, 0.0, 0.0), std=(1.0, 1.0, 1.0), rgb=False),
    Levels(mean=(127.5, 127.5, 127.5), std=(127.5, 127.5, 127.5), rgb=True),
)
"""How networks of joints are shown pictures: as MMPose's are; the same blue first; blue first with
red's mean, as ailia's PoseResNet; levels from 0 to 1; as AlphaPose's FastPose; as they are; from −1
to 1."""


def seen_on_person(heads: JointHeads, runtime: Runtime) -> JointHeads:
    """What a network is shown, with how many joints of the man it finds so. Where nothing says how
    it is to be shown a picture, the way by which it finds clearly most."""
    usual = heads.model_copy(update={"finds": _found(heads, runtime)})
    if heads.levels is not None or heads.kind not in ("simcc", "maps"):
        return usual
    best = max(
        (_shown(heads, levels, runtime) for levels in WAYS), key=lambda each: each.finds or 0
    )
    finds, usually = best.finds or 0, usual.finds or 0
    return best if finds >= max(ENOUGH, usually + CLEARLY) else usual


def _shown(heads: JointHeads, levels: Levels, runtime: Runtime) -> JointHeads:
    joint_heads = heads.model_copy(update={"levels": levels})
    return joint_heads.model_copy(update={"finds": _found(joint_heads, runtime)})


def _found(heads: JointHeads, runtime: Runtime) -> int:
    """How many of the man's joints the network finds."""
    nobody = Model("", "", "0" * 64, 0.0, bundled=False, heads=heads)
    network = JointNetwork(nobody, heads, runtime)
    uv = network.infer(_picture(), REGION).uv
    uv_of_joint = _joints()
    at = [list(network.names).index(name) for name in uv_of_joint]
    away = np.linalg.norm(uv[at] - np.array(list(uv_of_joint.values())), axis=1)
    return int((away <= FOUND * HEIGHT_PX).sum())


@lru_cache(maxsize=1)
def _picture() -> NDArray[np.uint8]:
    content = np.frombuffer(PICTURE.read_bytes(), np.uint8)
    picture = cv2.imdecode(content, cv2.IMREAD_COLOR)
    return np.asarray(cv2.cvtColor(np.asarray(picture), cv2.COLOR_BGR2RGB), dtype=np.uint8)


@lru_cache(maxsize=1)
def _joints() -> dict[str, Array]:
    """Pixels (2,) of COCO's 17 joints by name, as the bundled network sees them."""
    network = JointNetwork.open(THUNDER, fast=False)
    uv: Sequence[Array] = list(network.infer(_picture(), REGION).uv)
    return dict(zip(network.names, uv, strict=True))
