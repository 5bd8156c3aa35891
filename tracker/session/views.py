"""A view: what one camera saw of the scene."""

from __future__ import annotations

import operator
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import Field, FiniteFloat, model_validator

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import Array, rotation_from_quaternion
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.session.camera_motion import CameraKeyframe, CameraMotion
from keypose.tracker.session.counts import few
from keypose.tracker.session.keyframe import Quaternion
from keypose.tracker.session.references import KeypointFile, Surface, VideoReference
from keypose.tracker.session.settings import IgnoreMask, Plain, Position, SceneId, is_unknown

LensSource: TypeAlias = Literal["guess", "file", "person", "calibration", "fitted", "turns"]


class Clock(Plain):
    """When a film was taken, on the clock of the first view's film."""

    begins: Annotated[FiniteFloat, Field(ge=-1e8, le=1e8)] = Field(
        description="The frame of the first film, with its fraction, at which frame 0 was taken; "
        "negative where it began before."
    )
    rate: Annotated[FiniteFloat, Field(ge=0.01, le=100)] = Field(
        default=1.0, description="Frames of it per frame of the first film."
    )
    sigma: Annotated[FiniteFloat, Field(gt=0)] | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The standard deviation of begins, frames of the first film; left out where "
        "somebody set it.",
    )
    also: tuple[FiniteFloat, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Where it may begin as well, where the motion repeats itself; left out where "
        "nothing else is likely.",
    )

    @property
    def of_film(self) -> FilmClock:
        """The clock itself."""
        return FilmClock(self.begins, self.rate)


class Placed(Plain):
    """What the place of a view's camera beside the first rests on."""

    source: Literal["body", "file", "person"] = Field(
        description="body, found from a body that both films show; file, read from a calibration."
    )
    turn_sigma_rad: Annotated[FiniteFloat, Field(gt=0)] | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The standard deviation of how it is turned, radians.",
    )
    place_sigma_m: Annotated[FiniteFloat, Field(gt=0)] | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The standard deviation of where it is, metres.",
    )
    measured_m: Annotated[FiniteFloat, Field(gt=0)] | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="How far it is from the first camera by a calibration in known units, metres: "
        "the body alone shows distances as multiples of its own size.",
    )


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
    clock: Clock | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="When its film was taken beside the first view's; left out for the first view, "
        "and where both have the same frames.",
    )
    placed: Placed | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="What the place of its camera rests on; left out for the first view.",
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
    def film_clock(self) -> FilmClock:
        """How its frames lie beside those of the first view."""
        return FilmClock() if self.clock is None else self.clock.of_film

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
