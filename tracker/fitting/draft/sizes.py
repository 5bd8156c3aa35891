"""The preset's proportions scaled to the person's, as far as keypoints tell.

Height and distance show only together in a picture: the body keeps its height. What can be seen is
how long a limb is beside the others, in frames where it lies across the view: its pixels over those
that a metre takes at the body's distance. That is believed only when many frames say so and do not
contradict each other, and never beyond what people differ by.
"""

from __future__ import annotations

import numpy as np

from tracker.body.body import Body
from tracker.body.scaling import height, resized, with_height
from tracker.body.skeleton import Skeleton
from tracker.fitting.draft.first_poses import first_pose
from tracker.fitting.draft.limbs import Bone, Joints
from tracker.fitting.draft.observed import Observed
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array

MOST_FRAMES = 120
"""Frames that are looked at, spread over the clip."""
SURE = 0.8
"""Visibility of both ends of a bone that is measured."""
ACROSS = 0.5
"""Largest share of a bone's length that lies in depth where it is measured."""
FEWEST = 12
"""Measurements that tell a length."""
USUAL = 0.06
"""Standard deviation of people's proportions."""
LARGEST = 0.12
"""By which a length is changed at most."""


def with_proportions(body: Body, camera: Camera, observed: Observed) -> Body:
    """The body with upper arms, forearms, thighs and shins as long as they are seen, its height as
    it was."""
    joints = Joints.of(Skeleton.of(body))
    ratios = _ratios(joints, camera, observed)
    factors: dict[str, float] = {}
    for left, right in zip(
        joints.bones[:2] + joints.bones[4:6], joints.bones[2:4] + joints.bones[6:], strict=True
    ):
        own = np.concatenate([ratios[left], ratios[right]])
        factors[body.names[left.part]] = _believed(own)
    changed = body
    for name, factor in factors.items():
        changed = resized(changed, name, length_factor=factor)
    return with_height(changed, height(body))


def _believed(ratios: Array) -> float:
    """The median, drawn toward 1 by how uncertain it is and how little people differ."""
    if len(ratios) < FEWEST:
        return 1.0
    middle = float(np.median(ratios))
    spread = 1.48 * float(np.median(np.abs(ratios - middle)))
    # neighbouring frames err alike: so many measurements count as few
    doubt = spread**2 / FEWEST + (0.5 * USUAL) ** 2
    share = USUAL**2 / (USUAL**2 + doubt)
    return 1.0 + float(np.clip(share * (middle - 1.0), -LARGEST, LARGEST))


def _ratios(joints: Joints, camera: Camera, observed: Observed) -> dict[Bone, Array]:
    """By bone its length as seen over the body's, in all frames that tell it."""
    usable = np.flatnonzero(observed.usable)
    some = usable[:: max(1, len(usable) // MOST_FRAMES)]
    ratios: dict[Bone, list[float]] = {bone: [] for bone in joints.bones}
    for n in some:
        uv, sure, p = observed.uv[n], observed.visibility[n], observed.p_hips[n]
        pose = first_pose(joints, camera, uv, sure, p)
        metre = camera.fy / float(camera.depth(pose.p_camera_root))
        for bone in joints.bones:
            both = [bone.near, bone.far]
            along = p[bone.far] - p[bone.near]
            length = float(np.linalg.norm(along))
            if sure[both].min() < SURE or not abs(along[2]) < ACROSS * length:
                continue
            seen = float(np.linalg.norm(uv[bone.far] - uv[bone.near])) / metre
            whole = seen / np.sqrt(1 - (along[2] / length) ** 2)
            ratios[bone].append(whole / joints.length_m(bone))
    return {bone: np.array(values) for bone, values in ratios.items()}
