"""What lies ready when one keyframe is fitted: its pictures, and what frames near show of the body.

Other keyframes were posed by hand too, and what is tracked beside a keyframe leans on it: both are
looked at with that in mind.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from tracker.body.joint_limits import Limits
from tracker.body.pose import Pose
from tracker.body.skeleton import Skeleton
from tracker.fitting.pose.likeness import Likeness, Texture, texture_of, without_parts
from tracker.fitting.pose.outline import Outline, separation
from tracker.fitting.pose.settling import Hand, settle
from tracker.geometry.camera import Camera
from tracker.session.settings import IgnoreMask
from tracker.tracking.scene import Scene
from tracker.video import Video
from tracker.video.clip_loader import ClipLoader, WorkingSize
from tracker.video.pyramid import IGNORED, Picture

REACH = 40
"""Frames beyond which another keyframe shows too little of the same."""
BESIDE = (4, 8)
"""Tracked frames that are asked, counted from the keyframe to either side."""
AT_ONCE = 24
"""Most frames whose pictures are held at a time."""
OWN_WORD = 1e-3
FOREIGN = 3.5
"""In units of the hand's uncertainty: tracked nearer than the one, a pose is the hand's own; a limb
tracked further off than the other was tracked wrongly."""
CLEAR_COLOURS = 0.25
"""Share of the outline that colour must tell for it to be asked."""


@dataclass(frozen=True, eq=False)
class FitInputs:
    """All that lies ready: the hand's pose, the scene, the frame's pictures and its colours."""

    hand: Hand
    scene: Scene
    frame: int
    loader: ClipLoader
    pictures: Sequence[Picture]
    rgb: NDArray[np.uint8] | None

    @classmethod
    def of(
        cls, video: Video, camera: Camera, skeleton: Skeleton, frame: int, pose: Pose,
        masks: Sequence[IgnoreMask],
    ) -> FitInputs:  # fmt: skip
        """Load one frame."""
        size = WorkingSize.for_camera(camera, AT_ONCE)
        loader = ClipLoader(video, camera, size, masks)
        scene = Scene.of(skeleton, size.camera(camera), [pose])
        pictures = _pictures(loader, frame)
        hand = Hand(scene, pose, Limits.of(skeleton.body))
        return cls(hand, scene, frame, loader, pictures, _colours(loader, frame))

    def at(self, frame: int, pose: Pose) -> FitInputs:
        """The same for another keyframe."""
        hand = Hand(self.scene, pose, self.hand.limits)
        pictures, rgb = _pictures(self.loader, frame), _colours(self.loader, frame)
        return replace(self, hand=hand, frame=frame, pictures=pictures, rgb=rgb)

    def outline(self) -> Outline | None:
        """The frame's colours about the body; None where they do not part it from what is behind.

        What may not be used is left out.
        """
        if self.rgb is None:
            return None
        scene, usable, pose = self.scene, self.pictures[0][..., 3] != IGNORED, self.hand.pose
        outline = Outline.of(scene.skeleton, scene.camera, self.rgb, usable, pose)
        if outline is None or separation(outline, pose) < CLEAR_COLOURS:
            return None
        return outline


def _colours(loader: ClipLoader, frame: int) -> NDArray[np.uint8] | None:
    """A frame in colour at the working size, or None where it is missing or damaged."""
    (_, rgb), *_ = loader.video.sound_frames(frame, frame + 1)
    return None if rgb is None else loader.size.picture(loader.camera.rectify(rgb))


def _pictures(loader: ClipLoader, frame: int) -> list[Picture]:
    """One frame's pyramid."""
    clip = loader.load(frame, frame)
    slot = int(clip.slots(frame, frame)[0])
    return [_without_border(level[slot]) for level in clip.levels]


def _without_border(picture: Picture) -> Picture:
    """The picture with one more pixel around what is ignored, where interpolation looks between
    pixels: a tracked stretch bears a trace of what was ignored, a single frame need not."""
    if (picture[..., 3] != IGNORED).all():
        return picture
    kept = picture.copy()
    kept[..., 3] = cv2.erode(picture[..., 3], np.ones((3, 3), np.uint8))
    return kept


def keyframes_near(inputs: FitInputs, keyposes: Mapping[int, Pose]) -> dict[int, Pose]:
    """The keyframes next to this one, as far as they are within reach."""
    before = [f for f in keyposes if 0 < inputs.frame - f <= REACH]
    after = [f for f in keyposes if 0 < f - inputs.frame <= REACH]
    return {f: keyposes[f] for f in (*sorted(before)[-1:], *sorted(after)[:1])}


def fit_to_outlines(
    inputs: FitInputs, near: Mapping[int, Pose], cancelled: Callable[[], bool]
) -> dict[int, Pose]:
    """The same keyframes, each laid into its own outline: they were posed by hand as well."""
    tidy = {}
    for frame, pose in near.items():
        outline = inputs.at(frame, pose).outline()
        tidy[frame] = pose
        if outline is not None:
            hand = Hand(inputs.scene, pose, inputs.hand.limits)
            tidy[frame] = settle(hand, pose, None, outline, cancelled).pose
    return tidy


def align_textures(
    inputs: FitInputs,
    near: Mapping[int, Pose],
    tidy: Mapping[int, Pose],
    pose: Pose,
    cancelled: Callable[[], bool],
) -> dict[int, Pose]:
    """The keyframes near, from `tidy` on, settled on what this frame, posed so, and the others
    show, and on their own outlines: what each outline has wrong is evened out."""
    settled = dict(tidy)
    for frame in near:
        there = inputs.at(frame, near[frame])
        others = {inputs.frame: pose, **{f: p for f, p in settled.items() if f != frame}}
        weight = 1.0 / len(others)
        textures = [
            texture_of(inputs.scene, _pictures(inputs.loader, f), p, weight)
            for f, p in others.items()
        ]
        likeness = Likeness(inputs.scene, there.pictures, textures)
        settled[frame] = settle(
            there.hand, settled[frame], likeness, there.outline(), cancelled, coarsest=0
        ).pose
    return settled


def textures_near(
    inputs: FitInputs, near: Mapping[int, Pose], tracked: Mapping[int, Pose]
) -> list[Texture]:
    """What keyframes and tracked frames near show of the body; together they weigh one."""
    asked = [(pose, frame) for frame, pose in near.items()]
    foreign = np.zeros(inputs.scene.skeleton.part_count, np.bool_)
    if _is_own_word(inputs, tracked):
        if inputs.frame in tracked:
            foreign = _foreign(inputs, tracked[inputs.frame])
        beside = {inputs.frame + side * n for n in BESIDE for side in (-1, 1)}
        tracked_near = [(tracked[f], f) for f in sorted(beside) if f in tracked and f not in near]
    else:
        tracked_near = []
    weight = 1.0 / max(1, len(asked) + len(tracked_near))
    found = [texture_of(inputs.scene, _pictures(inputs.loader, f), p, weight) for p, f in asked]
    for pose, frame in tracked_near:
        texture = texture_of(inputs.scene, _pictures(inputs.loader, frame), pose, weight)
        found.append(without_parts(texture, foreign))
    return [texture for texture in found if texture.starts[0][-1] > 0]


def _is_own_word(inputs: FitInputs, tracked: Mapping[int, Pose]) -> bool:
    """Whether tracking speaks for itself here: had it been led through this very keyframe, its
    poses beside would lean on the keyframe's error."""
    if inputs.frame not in tracked:
        return bool(tracked)
    away = inputs.hand.away(tracked[inputs.frame]) * np.sqrt(inputs.hand.precision)
    return bool(np.abs(away).max(initial=0.0) > OWN_WORD)


def _foreign(inputs: FitInputs, tracked: Pose) -> NDArray[np.bool_]:
    """(P,) parts that tracking has elsewhere than a hand could have missed by, and what hangs on
    them."""
    skeleton = inputs.scene.skeleton
    far = np.abs(inputs.hand.away(tracked)) * np.sqrt(inputs.hand.precision) > FOREIGN
    return np.asarray(skeleton.below[:, skeleton.dof_part[far]].any(axis=1))
