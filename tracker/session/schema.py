"""The session file's contents: plain numbers, validated once when read, each alone and together.

Every error message names the field and what is allowed. Lengths are metres, angles radians,
rotations unit quaternions [w, x, y, z] of a part in its parent's frame. Fields that are not known
are kept as they are: another program may have its own.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import rotation_from_quaternion
from keypose.tracker.session.annotations import (
    Ahead,
    Drafted,
    KeypointCorrection,
    NoteList,
    ReviewedList,
    require_ahead,
    require_corrections,
    require_notes,
)
from keypose.tracker.session.evidence import Evidence, evidence_of
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe, quaternions_of
from keypose.tracker.session.migrate import PRESENT
from keypose.tracker.session.pins import PinList, require_pins
from keypose.tracker.session.references import FirstMotion, KeypointFile, Surface, VideoReference
from keypose.tracker.session.results import Results
from keypose.tracker.session.settings import (
    IgnoreMask,
    Metres,
    Plain,
    Position,
    TrackSettings,
    is_unknown,
)


def require_part_keyframes(session: Session) -> None:
    """ValueError in one sentence unless each names parts of the body besides its root, at a frame
    of a film that is no keyframe."""
    if not session.part_keyframes:
        return
    if session.surface is not None:
        raise ValueError(
            "part_keyframes: a body is fitted to surfaces as a whole; make them keyframes"
        )
    root, keyed = session.body.names[0], {keyframe.frame for keyframe in session.keyframes}
    for each in session.part_keyframes:
        if each.frame in keyed:
            raise ValueError(f"part_keyframes: frame {each.frame} is a keyframe; one is allowed")
        unknown = sorted(set(each.parts) - set(session.body.names))
        if unknown:
            raise ValueError(
                f"part_keyframes: frame {each.frame} names {unknown[0]!r}, which the body does not "
                f"have; its parts are {', '.join(session.body.names)}"
            )
        if root in each.parts:
            raise ValueError(
                f"part_keyframes: frame {each.frame} names {root!r}, which carries all others; "
                "make it a keyframe"
            )
        if len(set(each.parts)) < len(each.parts):
            raise ValueError(f"part_keyframes: frame {each.frame} names a part twice")


NEAREST_M = 0.05
"""The least depth of a joint."""

MOST: Mapping[str, int] = {
    "keyframes": 10_000,
    "part_keyframes": 10_000,
    "drafts": 10_000,
    "ignore_masks": 10_000,
    "keypoint_corrections": 10_000,
    "pins": 10_000,
    "notes": 1_000,
    "reviewed": 10_000,
    "ahead": 100,
}
"""Far above what a person sets in a session, and above what standing on the floor pins."""

POSES_AT_A_TIME = 500


def require_fit(session: Session, poses: Sequence[Keyframe]) -> None:
    """ValueError in one sentence unless the session's values, each valid by itself, fit together.

    poses: the keyframes, of parts too, and drafts to check against body and video; the others are
        known to fit.
    """
    require_few({name: getattr(session, name) for name in MOST})
    camera, video = session.camera, session.video
    if (camera.width, camera.height) != (video.width, video.height):
        raise ValueError(
            f"camera.width × height is {camera.width}×{camera.height} but video.width × height is "
            f"{video.width}×{video.height}; the sizes must agree, both the video's own"
        )
    _require_sorted(session.keyframes)
    _require_sorted(session.drafts)
    _require_sorted(session.part_keyframes)
    require_part_keyframes(session)
    _require_direction(session.up_camera)
    _require_parts(session.settings.left_out, session.body)
    require_pins(session.pins, session.body, video.frame_count)
    require_notes(session.notes, video.frame_count)
    require_ahead(session.ahead, session.body, video.frame_count)
    require_corrections(session.keypoint_corrections, video.frame_count, video.width, video.height)
    for keyframe in poses:
        _require_in_video(keyframe, video.frame_count)
        _require_known_parts(keyframe, session.body)
    skeleton = Skeleton.of(session.body)
    for start in range(0, len(poses), POSES_AT_A_TIME):
        _require_before_camera(poses[start : start + POSES_AT_A_TIME], skeleton)


def _require_sorted(keyframes: Sequence[Keyframe]) -> None:
    for one, other in pairwise(keyframes):
        before, after = one.frame, other.frame
        if before == after:
            raise ValueError(f"keyframes: frame {before} has two keyframes; one is allowed")
        if before > after:
            raise ValueError(f"keyframes: frame {after} stands after {before}; sort them by frame")
        if one.time_s >= other.time_s:
            raise ValueError(
                f"keyframes: time_s of frame {after} is {other.time_s:g}; it must be later than "
                f"{one.time_s:g}, the time of frame {before}"
            )


def _require_parts(left_out: tuple[str, ...], body: Body) -> None:
    unknown = sorted(set(left_out) - set(body.names))
    if unknown:
        raise ValueError(
            f"settings.left_out names {unknown[0]!r}, which the body does not have; its parts are "
            f"{', '.join(body.names)}"
        )


def _require_direction(up_camera: Position | None) -> None:
    if up_camera is not None and math.hypot(*up_camera) < 1e-6:
        raise ValueError("up_camera: [0, 0, 0] is no direction")


def _require_in_video(keyframe: Keyframe, frame_count: int) -> None:
    if keyframe.frame >= frame_count:
        raise ValueError(
            f"keyframes: frame {keyframe.frame} is beyond the video, "
            f"whose frames are 0 to {frame_count - 1}"
        )


def _require_known_parts(keyframe: Keyframe, body: Body) -> None:
    unknown = sorted(keyframe.rotations_wxyz.keys() - set(body.names))
    if unknown:
        raise ValueError(
            f"keyframes: frame {keyframe.frame} poses {unknown[0]!r}, which the body does not "
            f"have; its parts are {', '.join(body.names)}"
        )


def _require_before_camera(keyframes: Sequence[Keyframe], skeleton: Skeleton) -> None:
    names = skeleton.body.names
    quaternions = np.array([quaternions_of(keyframe, names) for keyframe in keyframes])
    roots = np.array([keyframe.root_m for keyframe in keyframes])
    z = part_transforms(skeleton, rotation_from_quaternion(quaternions), roots)[..., 2, 3]
    behind = np.flatnonzero(~(z.min(axis=-1) > NEAREST_M))
    if len(behind):
        first = behind[0]
        raise ValueError(
            f"keyframes: frame {keyframes[first].frame} has {names[int(np.argmin(z[first]))]!r} "
            f"behind the camera; every joint needs a depth of more than {NEAREST_M} m"
        )


def require_few(data: Mapping[str, Any]) -> None:
    """ValueError when a list is longer than a session may have; checked before any of it is read,
    which could take minutes."""
    for name, most in MOST.items():
        given = data.get(name)
        if isinstance(given, list | tuple) and len(given) > most:
            raise ValueError(f"{name}: {len(given)} are more than the {most} a session may have")


LensSource: TypeAlias = Literal["guess", "file", "person", "calibration", "fitted"]
Title: TypeAlias = Annotated[str, Field(max_length=120)]


class Session(Plain):
    """All about one video: the camera, the body, the keyframes, the settings, the results."""

    schema_version: Annotated[int, Field(ge=1)] = Field(
        default=PRESENT, description=f"{PRESENT}; a greater one is of a newer Keypose."
    )
    title: Title = Field(
        default="",
        exclude_if=operator.not_,
        description="What a person calls it; left out where it is called as its folder.",
    )
    video: VideoReference
    camera: Camera
    body: Body
    keyframes: tuple[Keyframe, ...] = ()
    part_keyframes: tuple[PartKeyframe, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Keyframes of some parts alone, at frames that are no keyframes; left out "
        "where there are none.",
    )
    drafts: tuple[Keyframe, ...] = Field(
        default=(), description="Poses begun at frames that are no keyframes yet; not tracked."
    )
    up_camera: Position | None = Field(
        default=None,
        description="The world's up direction in the camera frame; null: the camera's own, −y.",
    )
    up_from_feet: bool = Field(
        default=False,
        exclude_if=operator.not_,
        description="Whether up_camera was found from pinned feet.",
    )
    pins: PinList = ()
    floor_m: Metres | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The floor's height along up, from the camera, metres; left out where it is "
        "not known.",
    )
    notes: NoteList = ()
    ignore_masks: tuple[IgnoreMask, ...] = ()
    settings: TrackSettings = TrackSettings()
    lens_source: LensSource | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="What the camera's focal length rests on; left out where nobody was asked.",
    )
    first_motion: FirstMotion | None = Field(
        default=None, description="An imported motion that tracking may start from."
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
    drafted: Drafted | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="What drafting the film found besides the drafts; left out where nobody did.",
    )
    reviewed: ReviewedList = ()
    ahead: tuple[Ahead, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="How far the body was followed from keyframes, and why no farther; left out "
        "where it was not.",
    )
    surface: Surface | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="How to read the meshes, where the session is about such; left out otherwise.",
    )
    results: Results | None = None

    @property
    def evidence(self) -> Evidence:
        """Return what the body is compared with."""
        return evidence_of(self)

    @property
    def lens_is_guess(self) -> bool:
        """Return whether distances rest on a lens that nobody knows."""
        return (self.lens_source or self.camera.origin) == "guess"

    @property
    def depth_share(self) -> float | None:
        """Return by what share distances may be off because the lens is a guess; None where it is
        not.
        """
        return self.camera.usual_spread if self.lens_is_guess else None

    @property
    def has_static_camera(self) -> bool:
        """Return whether the camera is taken to stand still: as the settings say, else as it was
        found; False where nobody looked.
        """
        chosen, found = self.settings.static_camera, self.video.stands_still
        return bool(found if chosen is None else chosen)

    def with_up(self, up_camera: Iterable[float] | None, *, from_feet: bool = False) -> Self:
        """Set what is up, rounded to 1e-6; None where nobody knows."""
        up = None if up_camera is None else tuple(round(float(v), 6) + 0.0 for v in up_camera)
        return self.model_copy(update={"up_camera": up, "up_from_feet": from_feet})

    @property
    def given_keypoints(self) -> KeypointFile | None:
        """Imported keypoints, which count in place of those that a network finds."""
        return None if self.keypoints is None or self.keypoints.network else self.keypoints

    @property
    def spans(self) -> tuple[tuple[int, int], ...]:
        """First and last frame of every segment: between two keyframes, and of surfaces also
        before the first and after the last."""
        return self.evidence.spans([keyframe.frame for keyframe in self.keyframes])

    @property
    def model_keyframe(self) -> Keyframe | None:
        """The keyframe whose mesh moves with the body; None without surfaces or keyframes."""
        return self.evidence.model_keyframe(self.keyframes)

    @property
    def is_newer(self) -> bool:
        """Return whether a newer Keypose wrote it: it can then be viewed but not changed."""
        return self.schema_version > PRESENT

    @model_validator(mode="before")
    @classmethod
    def _is_of_usable_size(cls, data: Any) -> Any:
        if isinstance(data, dict):
            require_few(data)
        return data

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        require_fit(self, (*self.keyframes, *self.part_keyframes, *self.drafts))
        return self
