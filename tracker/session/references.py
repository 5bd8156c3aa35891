"""The files that a session refers to: its video or surfaces, a first motion, keypoints."""

from __future__ import annotations

import operator
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import Field, FiniteFloat

from keypose.tracker.session.settings import (
    FrameIndex,
    Plain,
    Position,
    Units,
    UpAxis,
    Weights,
    is_unknown,
)

FramesPerSecond: TypeAlias = Annotated[FiniteFloat, Field(ge=0.001, le=1_000_000)]


class Repeats(Plain):
    """Frames of a film that are copies of the one before."""

    frames: tuple[FrameIndex, ...] = Field(default=(), description="Their numbers, ascending.")
    even: bool = Field(
        default=True,
        description="Whether copies were put in between, as by a change of the frame rate, so that "
        "the other frames are evenly spaced in time; otherwise each took the place of a frame.",
    )


class VideoReference(Plain):
    """The video a session is about, and how to know that it is that one."""

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
    repeats: Repeats | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="Repeated frames, as found when frames were decoded; left out where there are "
        "none.",
    )
    recorded_fps: FramesPerSecond | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="Frames a second as they were recorded, where the file has another rate, as of "
        "slow motion, or none, as a folder of images; left out where the file's times count.",
    )
    deinterlace: bool = Field(
        default=True,
        exclude_if=bool,
        description="Whether interlaced frames are made progressive as they are read; left out "
        "where they are.",
    )

    @property
    def pictures(self) -> str:
        """What the pictures are known by: another name where the same file gives others."""
        return self.fingerprint if self.deinterlace else f"{self.fingerprint} woven"


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


KEYPOINT_RUN: Final = 128
"""Frames of which a segment's key counts the keypoints together."""


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
    model: str = Field(
        default="", description="SHA-256 of that network's file, if segments are tracked by them."
    )
    masks: bool = Field(
        default=False, description="Whether the file has the person's outlines, too."
    )
    together: bool = Field(
        default=False,
        exclude_if=operator.not_,
        description="Whether the people around were followed as well, so that whoever is unseen is "
        "hidden; left out where they were not.",
    )
    runs: tuple[Annotated[str, Field(pattern=r"^[0-9a-f]{8}$")], ...] = Field(
        default=(),
        description=f"Digests of what is in each {KEYPOINT_RUN} frames of the film, with which "
        "segments are tracked whose keyframes lie on the keypoints. Empty where none are.",
    )
