"""The session file's contents: plain numbers, validated once when read.

Every error message names the field and what is allowed. Lengths are metres, angles radians,
rotations unit quaternions [w, x, y, z] of a part in its parent's frame. Fields that are not known
are kept as they are: another program may have its own.
"""

from __future__ import annotations

import operator
from typing import Annotated, Any, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from keypose.tracker.body.body import Body
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session.ahead import Ahead
from keypose.tracker.session.annotations import Drafted, KeypointCorrection, ReviewedList
from keypose.tracker.session.checks import require_few, require_fit
from keypose.tracker.session.evidence import Evidence, evidence_of
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.migrate import PRESENT
from keypose.tracker.session.notes import NoteList
from keypose.tracker.session.pins import PinList
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
