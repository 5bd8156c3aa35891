"""A view: what one camera saw of the scene."""

from __future__ import annotations

import operator
from typing import Any, Literal, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, rotation_from_quaternion
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.session.camera_motion import CameraKeyframe, CameraMotion
from keypose.tracker.session.counts import few
from keypose.tracker.session.keyframe import Quaternion
from keypose.tracker.session.references import KeypointFile, Surface, VideoReference
from keypose.tracker.session.settings import IgnoreMask, Plain, Position, SceneId, is_unknown

LensSource: TypeAlias = Literal["guess", "file", "person", "calibration", "fitted", "turns"]


class View(Plain):
    """What one camera saw: its film, how it was taken, and what was said of its pictures."""

    id: SceneId = "view"
    video: VideoReference
    camera: Camera
    R_camera_world_wxyz: Quaternion = Field(
        default=(1.0, 0.0, 0.0, 0.0),
        exclude_if=(1.0, 0.0, 0.0, 0.0).__eq__,
        description="How the camera is turned against the world; left out for the first view, "
        "whose camera is the world's frame.",
    )
    p_camera_world: Position = Field(
        default=(0.0, 0.0, 0.0),
        exclude_if=(0.0, 0.0, 0.0).__eq__,
        description="The world's origin in the camera frame, metres; left out for the first view.",
    )
    ignore_masks: tuple[IgnoreMask, ...] = ()
    lens_source: LensSource | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="What the camera's focal length rests on: fitted, with the sizes to keyframes; "
        "turns, estimated from the camera's own motion. Left out where nobody was asked.",
    )
    keypoints: KeypointFile | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="Keypoints that tracking listens to beside the pictures; left out where there "
        "are none.",
    )
    keypoint_corrections: tuple[KeypointCorrection, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Keypoints that a person set right, by frame and joint, each once; left out "
        "where there are none.",
    )
    surface: Surface | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="How to read the meshes, where it shows such; left out otherwise.",
    )

    camera_motion: CameraMotion | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="How the camera turned, zoomed and moved; left out where it stands still or "
        "nobody looked.",
    )
    camera_keyframes: tuple[CameraKeyframe, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="The camera at frames at which a person set it; left out where there are none.",
    )

    @property
    def T_camera_world(self) -> Array:
        """(4, 4) where the world is in the frame of the camera, metres."""
        T = np.eye(4)
        T[:3, :3] = rotation_from_quaternion(np.array(self.R_camera_world_wxyz))
        T[:3, 3] = self.p_camera_world
        return T

    @property
    def lens_is_guess(self) -> bool:
        """Whether distances rest on a lens that nobody knows."""
        return (self.lens_source or self.camera.origin) == "guess"

    @property
    def depth_share(self) -> float | None:
        """By what share distances may be off because the lens is a guess; None where it is
        not.
        """
        return self.camera.usual_spread if self.lens_is_guess else None

    @property
    def given_keypoints(self) -> KeypointFile | None:
        """Imported keypoints, which count in place of those that a network finds."""
        return None if self.keypoints is None or self.keypoints.network else self.keypoints

    @model_validator(mode="before")
    @classmethod
    def _has_no_list_too_long(cls, data: Any) -> Any:
        """Before anything of them is read."""
        return few(data)
