"""The session file's contents: plain numbers, validated once when read.

Every error message names the field and what is allowed. Lengths are metres, angles radians,
rotations unit quaternions [w, x, y, z] of a part in its parent's frame. Fields that are not known
are kept as they are: another program may have its own.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal, Self, TypeAlias

import numpy as np
from pydantic import (
    Field,
    FiniteFloat,
    field_validator,
    model_validator,
)

from keypose.tracker.body.body import Body, Name
from keypose.tracker.body.pose import Pose, part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import quaternion_wxyz, rotation_from_quaternion
from keypose.tracker.session.ahead import Ahead, require_ahead
from keypose.tracker.session.corrections import KeypointCorrection, require_corrections
from keypose.tracker.session.drafted import Drafted
from keypose.tracker.session.evidence import Evidence, evidence_of
from keypose.tracker.session.notes import NoteList, require_notes
from keypose.tracker.session.part_keyframes import require_part_keyframes
from keypose.tracker.session.pins import PinList, require_pins
from keypose.tracker.session.results import Results
from keypose.tracker.session.reviewed import ReviewedList
from keypose.tracker.session.settings import (
    FrameIndex,
    IgnoreMask,
    Plain,
    TrackSettings,
    Units,
    UpAxis,
    Weights,
    is_unknown,
)
from keypose.tracker.session.versions import PRESENT

Quaternion: TypeAlias = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
Metres: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e5, le=1e5)]
Position: TypeAlias = tuple[Metres, Metres, Metres]
LensSource: TypeAlias = Literal["guess", "file", "person", "calibration", "fitted"]
Title: TypeAlias = Annotated[str, Field(max_length=120)]
Seconds: TypeAlias = Annotated[FiniteFloat, Field(ge=0, le=1e7)]


AT_REST: Quaternion = (1.0, 0.0, 0.0, 0.0)
NEAREST_M = 0.05
"""The least depth of a joint."""

MOST: Mapping[str, int] = {
    "keyframes": 10_000,
    "part_keyframes": 10_000,
    "drafts": 10_000,
    "ignore_masks": 10_000,
    "keypoint_corrections": 10_000,
    "pins": 1_000,
    "notes": 1_000,
    "reviewed": 10_000,
    "ahead": 100,
}
"""Far above what a person sets in a session."""

POSES_AT_A_TIME = 500


class VideoReference(Plain):
    """Which video the session is about, and how to know that it is that one."""

    path: Annotated[str, Field(min_length=1)] = Field(
        description="Path of the video, relative to the session file or absolute."
    )
    fingerprint: str = Field(description="Content fingerprint; empty when not yet known.")
    frame_count: Annotated[int, Field(ge=1, le=100_000_000)]
    width: Annotated[int, Field(ge=2)]
    height: Annotated[int, Field(ge=2)]
    stands_still: bool | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="Whether the camera stands still, as found in the frames when the session was "
        "begun; left out where nobody looked.",
    )


class Surface(Plain):
    """Observed surfaces instead of a film: `video.path` then leads to the meshes, one per frame."""

    units: Units = Field(default="m", description="What one unit of the meshes' files is.")
    up: UpAxis = Field(default="+y", description="The axis of the meshes' files that is up.")
    p_camera_surface: Position = Field(
        description="The origin of the meshes' files in the camera frame, metres."
    )
    fps: Annotated[FiniteFloat, Field(ge=0.001, le=10_000)] = Field(
        default=25.0, description="Meshes a second."
    )
    cameras: str | None = Field(
        default=None,
        description="Path of the calibrated cameras' file, whose images tell what of the "
        "surfaces is to be believed; relative to the session file or absolute.",
    )
    cameras_fingerprint: str = Field(
        default="",
        description="Content fingerprint of that file; empty when not yet known.",
    )
    model_frame: FrameIndex | None = Field(
        default=None,
        description="The keyframe in whose mesh the body was posed most carefully: its surface is "
        "what moves with the body. Null: the first keyframe.",
    )
    weights: Weights = Field(
        default="both",
        description="What makes a place of the surfaces count less: contact of parts, cameras "
        "that do not agree on it, both, or nothing.",
    )
    distance: Literal["plane", "point"] = Field(
        default="plane", description="Distances to the surface, or to its nearest point."
    )
    binding: Literal["nearest", "smooth"] = Field(
        default="nearest",
        description="Whether a place of the surface moves with the nearest part alone.",
    )


class Keyframe(Plain):
    """A pose that a person set at one frame. It is never changed by tracking."""

    frame: FrameIndex
    time_s: Seconds = Field(description="Time of the frame from the video's first, seconds.")
    root_m: Position = Field(description="The root part's origin in the camera frame, metres.")
    rotations_wxyz: dict[Name, Quaternion] = Field(
        description="Each part's rotation in its parent's frame; parts left out are at rest."
    )
    soft: bool = Field(
        default=False,
        exclude_if=operator.not_,
        description="The motion need only come near it: mostly its depth gives way to pins and "
        "smoothness. Left out where it is met exactly.",
    )
    followed: bool = Field(
        default=False,
        exclude_if=operator.not_,
        description="Of a draft: found by tracking ahead, and not changed by a person since. Left "
        "out otherwise.",
    )

    drafted: bool = Field(
        default=False,
        exclude_if=operator.not_,
        description="Of a draft: found by drafting the film, not changed by a person since. Left "
        "out otherwise.",
    )

    @property
    def is_found(self) -> bool:
        """Whether a draft is as it was found in the film: what is tracked later replaces it."""
        return self.followed or self.drafted

    @field_validator("rotations_wxyz")
    @classmethod
    def _are_rotations(cls, rotations: dict[str, Quaternion]) -> dict[str, Quaternion]:
        for name, q in rotations.items():
            if abs(math.sqrt(sum(c * c for c in q)) - 1.0) > 1e-3:
                raise ValueError(f"the rotation of {name!r} is not a unit quaternion [w, x, y, z]")
        return rotations

    @classmethod
    def of(cls, skeleton: Skeleton, pose: Pose, frame: int, time_s: float) -> Keyframe:
        """The keyframe of a pose."""
        quaternions = quaternion_wxyz(pose.Rs_parent_part)
        names = skeleton.body.names
        return cls(
            frame=frame,
            time_s=time_s,
            root_m=_triple(pose.p_camera_root),
            rotations_wxyz={n: _quad(q) for n, q in zip(names, quaternions, strict=True)},
        )

    def pose(self, skeleton: Skeleton) -> Pose:
        """The pose it holds."""
        quaternions = np.array(_quaternions(self, skeleton.body.names))
        return Pose(rotation_from_quaternion(quaternions), np.array(self.root_m))


class PartKeyframe(Keyframe):
    """A keyframe of some parts alone: these are exact at its frame, the rest is tracked.

    Its pose is of the whole body as it stood when it was set. Its parts are seen where that pose
    has them, and as far from the root in depth; the rest of it is shown until the frame is tracked.
    """

    parts: Annotated[tuple[Name, ...], Field(min_length=1, max_length=1000)] = Field(
        description="The parts that are exact, each once; what hangs on one belongs to it."
    )


class OwnRun(Plain):
    """Frames of a first motion that are the session's own motion, from before it was reduced."""

    first_frame: FrameIndex
    last_frame: FrameIndex
    digest: Annotated[str, Field(pattern=r"^[0-9a-f]{12}$")] = Field(
        description="Of these poses: what starts from them is outdated when they change."
    )


class FirstMotion(Plain):
    """A motion from elsewhere, fitted to the body: a start for tracking, not its result. Or the
    session's own motion, from before it was reduced to keyframes."""

    file: Annotated[str, Field(pattern=r"^first-[0-9a-f]{12}\.npz$")] = Field(
        description="File of the motion, beside the session file."
    )
    source: str = Field(description="Name of the file that it was imported from.")
    matched: dict[str, str] = Field(
        default_factory=dict, description="The joints of that file with the body's own."
    )
    own: tuple[OwnRun, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Where it is the session's own motion, which segments there start from, as it "
        "is, unless another start is asked for. It has no other frames. Left out where it was "
        "imported.",
    )

    def own_run(self, first: int, last: int) -> OwnRun | None:
        """The run that reaches over these frames, of the session's own motion."""
        runs = (run for run in self.own if run.first_frame <= first and last <= run.last_frame)
        return next(runs, None)


class KeypointFile(Plain):
    """Keypoints of the person in the film: evidence beside its pictures."""

    file: Annotated[str, Field(pattern=r"^keypoints-[0-9a-f]{12}\.npz$")] = Field(
        description="File of the keypoints, beside the session file."
    )
    source: str = Field(
        description="What found them: a network's name, or the file they were imported from."
    )
    network: str = Field(
        default="", description="Fingerprint of the network; empty for an imported file."
    )
    seeds: tuple[FrameIndex, ...] = Field(
        default=(), description="Frames where it was said where the person is."
    )


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
        """What the body is compared with."""
        return evidence_of(self)

    @property
    def lens_is_guess(self) -> bool:
        """Whether distances rest on a lens that nobody knows."""
        return (self.lens_source or self.camera.origin) == "guess"

    @property
    def depth_share(self) -> float | None:
        """By what share distances may be off because the lens is a guess; None where it is not."""
        return self.camera.usual_spread if self.lens_is_guess else None

    @property
    def has_static_camera(self) -> bool:
        """Whether the camera is taken to stand still: as the settings say, else as it was found;
        False where nobody looked."""
        chosen, found = self.settings.static_camera, self.video.stands_still
        return bool(found if chosen is None else chosen)

    @property
    def given_keypoints(self) -> KeypointFile | None:
        """Imported keypoints, which count in place of those that the bundled network finds."""
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
        """Whether a newer Keypose wrote it: it can then be viewed but not changed."""
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


def _quaternions(keyframe: Keyframe, names: Sequence[str]) -> list[Quaternion]:
    return [keyframe.rotations_wxyz.get(name, AT_REST) for name in names]


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
    quaternions = np.array([_quaternions(keyframe, names) for keyframe in keyframes])
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


def _triple(values: np.ndarray) -> Position:
    x, y, z = (float(v) for v in values)
    return x, y, z


def _quad(values: np.ndarray) -> Quaternion:
    w, x, y, z = (float(v) for v in values)
    return w, x, y, z
