"""What one keyframe is fitted to: its pictures, and what frames near it show of the body.

The other keyframes were posed by eye too, and poses tracked from a keyframe share its error: both
are used with that in mind.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.pose.outline import Outline, separation
from keypose.tracker.fitting.pose.refinement import PosedKeyframe, refine
from keypose.tracker.fitting.pose.texture import Texture, TextureMatch, texture_of, without_parts
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import ClipLoader, WorkingSize
from keypose.tracker.video.pyramid import IGNORED, Picture

REACH = 40
"""Frames beyond which another keyframe shows too little of the same."""
BESIDE = (4, 8)
"""Tracked frames that are used, counted from the keyframe to either side."""
AT_ONCE = 24
"""Most frames whose pictures are held at a time."""
SAME_SIGMAS = 1e-3
WRONG_SIGMAS = 3.5
"""In sigmas of the pose as set: a tracked pose nearer than the one was led through this keyframe; a
limb tracked further off than the other was tracked wrongly."""
CLEAR_COLOURS = 0.25
"""Share of the outline that colour must place for it to be used."""


@dataclass(frozen=True, eq=False)
class FitInputs:
    """The pose as set, the scene, the frame's pictures and its colours."""

    keyframe: PosedKeyframe
    scene: Scene
    frame: int
    loader: ClipLoader
    pictures: Sequence[Picture]
    rgb: NDArray[np.uint8] | None

    @classmethod
    def of(
        cls,
        video: Video,
        camera: Camera,
        skeleton: Skeleton,
        frame: int,
        pose: Pose,
        masks: Sequence[IgnoreMask],
        steady: SteadyCamera | None = None,
    ) -> FitInputs:
        """Load one frame."""
        size = WorkingSize.for_camera(camera, AT_ONCE)
        loader = ClipLoader(video, camera, size, masks, steady=steady)
        scene = Scene.of(skeleton, size.camera(camera), [pose])
        pictures = _pictures(loader, frame)
        keyframe = PosedKeyframe(scene, pose, Limits.of(skeleton.body))
        return cls(keyframe, scene, frame, loader, pictures, _colours(loader, frame))

    def at(self, frame: int, pose: Pose) -> FitInputs:
        """The same for another keyframe."""
        keyframe = PosedKeyframe(self.scene, pose, self.keyframe.limits)
        pictures, rgb = _pictures(self.loader, frame), _colours(self.loader, frame)
        return replace(self, keyframe=keyframe, frame=frame, pictures=pictures, rgb=rgb)

    def outline(self) -> Outline | None:
        """The frame's colours about the body, without what may not be used; None where they do not
        separate it from the background.
        """
        if self.rgb is None:
            return None
        scene, usable, pose = self.scene, self.pictures[0][..., 3] != IGNORED, self.keyframe.pose
        outline = Outline.of(scene.skeleton, scene.camera, self.rgb, usable, pose)
        if outline is None or separation(outline, pose) < CLEAR_COLOURS:
            return None
        return outline


def _colours(loader: ClipLoader, frame: int) -> NDArray[np.uint8] | None:
    """A frame in colour at the working size, or None where it is missing or damaged."""
    (_, rgb), *_ = loader.video.sound_frames(frame, frame + 1)
    return None if rgb is None else loader.working(rgb, frame)


def _pictures(loader: ClipLoader, frame: int) -> list[Picture]:
    """One frame's pyramid."""
    clip = loader.load(frame, frame)
    slot = int(clip.slots(frame, frame)[0])
    return [_without_border(level[slot]) for level in clip.levels]


def _without_border(picture: Picture) -> Picture:
    """The picture with one more pixel around what is ignored, where interpolation looks between
    pixels: a tracked segment keeps a trace of what was ignored, a single frame need not."""
    if (picture[..., 3] != IGNORED).all():
        return picture
    usable = picture.copy()
    usable[..., 3] = cv2.erode(picture[..., 3], np.ones((3, 3), np.uint8))
    return usable


def keyframes_near(inputs: FitInputs, keyposes: Mapping[int, Pose]) -> dict[int, Pose]:
    """The keyframes next to this one, as far as they are within reach."""
    before = [f for f in keyposes if 0 < inputs.frame - f <= REACH]
    after = [f for f in keyposes if 0 < f - inputs.frame <= REACH]
    return {f: keyposes[f] for f in (*sorted(before)[-1:], *sorted(after)[:1])}


def fit_to_outlines(
    inputs: FitInputs, near: Mapping[int, Pose], cancelled: Callable[[], bool]
) -> dict[int, Pose]:
    """The same keyframes, each fitted to its own outline: they were posed by eye as well."""
    outlined = {}
    for frame, pose in near.items():
        outline = inputs.at(frame, pose).outline()
        outlined[frame] = pose
        if outline is not None:
            keyframe = PosedKeyframe(inputs.scene, pose, inputs.keyframe.limits)
            outlined[frame] = refine(keyframe, pose, None, outline, cancelled).pose
    return outlined


def align_textures(
    inputs: FitInputs,
    near: Mapping[int, Pose],
    outlined: Mapping[int, Pose],
    pose: Pose,
    cancelled: Callable[[], bool],
) -> dict[int, Pose]:
    """The keyframes near, from `outlined` on, fitted to the textures of this frame at `pose` and of
    the others, and to their own outlines: errors of the outlines average out."""
    aligned = dict(outlined)
    for frame in near:
        there = inputs.at(frame, near[frame])
        others = {inputs.frame: pose, **{f: p for f, p in aligned.items() if f != frame}}
        weight = 1.0 / len(others)
        textures = [
            texture_of(inputs.scene, _pictures(inputs.loader, f), p, weight)
            for f, p in others.items()
        ]
        match = TextureMatch(inputs.scene, there.pictures, textures)
        aligned[frame] = refine(
            there.keyframe, aligned[frame], match, there.outline(), cancelled, coarsest=0
        ).pose
    return aligned


def textures_near(
    inputs: FitInputs, near: Mapping[int, Pose], tracked: Mapping[int, Pose]
) -> list[Texture]:
    """What keyframes and tracked frames near show of the body; together they weigh one."""
    keyframes = [(pose, frame) for frame, pose in near.items()]
    wrong = np.zeros(inputs.scene.skeleton.part_count, np.bool_)
    if _is_independent(inputs, tracked):
        if inputs.frame in tracked:
            wrong = _wrong_parts(inputs, tracked[inputs.frame])
        beside = {inputs.frame + side * n for n in BESIDE for side in (-1, 1)}
        tracked_near = [(tracked[f], f) for f in sorted(beside) if f in tracked and f not in near]
    else:
        tracked_near = []
    weight = 1.0 / max(1, len(keyframes) + len(tracked_near))
    textures = [
        texture_of(inputs.scene, _pictures(inputs.loader, f), p, weight) for p, f in keyframes
    ]
    for pose, frame in tracked_near:
        texture = texture_of(inputs.scene, _pictures(inputs.loader, frame), pose, weight)
        textures.append(without_parts(texture, wrong))
    return [texture for texture in textures if texture.starts[0][-1] > 0]


def _is_independent(inputs: FitInputs, tracked: Mapping[int, Pose]) -> bool:
    """Whether tracking is independent of this keyframe: poses that were led through it share
    its error.
    """
    if inputs.frame not in tracked:
        return bool(tracked)
    away = inputs.keyframe.away(tracked[inputs.frame]) * np.sqrt(inputs.keyframe.precision)
    return bool(np.abs(away).max(initial=0.0) > SAME_SIGMAS)


def _wrong_parts(inputs: FitInputs, tracked: Pose) -> NDArray[np.bool_]:
    """(P,) parts tracked further off than a person misses by, and those that hang on them."""
    skeleton = inputs.scene.skeleton
    far = np.abs(inputs.keyframe.away(tracked)) * np.sqrt(inputs.keyframe.precision) > WRONG_SIGMAS
    return np.asarray(skeleton.below[:, skeleton.dof_part[far]].any(axis=1))
