"""List what a person can do: edit and look, and what the store does: jobs, files, kept poses."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeAlias, Union

from pydantic import ConfigDict, Field, FiniteFloat, TypeAdapter, model_validator

from keypose.app.editor import (
    bodies,
    body,
    bonds,
    camera,
    copy_paste,
    films,
    floor,
    keyframes,
    moving_camera,
    notes,
    part_keyframes,
    pins,
    posing,
    tracking,
    update,
)
from keypose.app.editor.message import Editing, Message, PoseId, PoseName, StrokeName
from keypose.app.posing.gesture import Coordinate
from keypose.tracker.body.body import Name
from keypose.tracker.session.schema import MOST_BODIES
from keypose.tracker.session.settings import FrameIndex, SceneId, Title

SessionId: TypeAlias = Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]
"""Of a session among the recent ones, or of one in the trash."""


# --- jobs


class Track(Message):
    """Track segments; of the changed ones or all only those that reach between two frames, where
    they are given."""

    do: Literal["track"] = "track"
    what: Literal["this", "changed", "all"] = "changed"
    first: FrameIndex = 0
    last: FrameIndex | None = None

    @property
    def frames(self) -> tuple[int, int] | None:
        """First and last frame to track between; None for all."""
        return None if self.last is None else (self.first, self.last)


class FitHere(Message):
    """The pose of the present frame improved from its picture."""

    do: Literal["fit_here"] = "fit_here"


class FitSizes(Message):
    """The body's sizes from the pictures of all keyframes; optionally the focal length too."""

    do: Literal["fit_sizes"] = "fit_sizes"
    focal: bool = False


class DraftRest(Message):
    """The frames that a draft was cancelled before."""

    do: Literal["draft_rest"] = "draft_rest"


BoxOfPerson: TypeAlias = tuple[Coordinate, Coordinate, Coordinate, Coordinate]


class Draft(Message):
    """A pose for every frame, from a box around the person on one of them.

    box: left, top, right and bottom, pixels of the video.  others: boxes around more people on that
    frame, each of whom becomes a body.  first, last: of the frames to draft, those of the video
    where left out.
    """

    do: Literal["draft"] = "draft"
    frame: FrameIndex
    box: BoxOfPerson
    others: Annotated[tuple[BoxOfPerson, ...], Field(max_length=MOST_BODIES - 1)] = ()
    first: FrameIndex | None = None
    last: FrameIndex | None = None


class Lift(Message):
    """Drafts that nobody has posed found anew from their keypoints, for what is up by now."""

    do: Literal["lift"] = "lift"


class FindUp(Message):
    """What is up found by upright lines in the pictures, by how the person stands and where."""

    do: Literal["find_up"] = "find_up"


class FindPeople(Message):
    """The people in the picture of a frame, looked for where nothing else is at work."""

    do: Literal["find_people"] = "find_people"
    frame: FrameIndex


class FindCamera(Message):
    """How the film's camera turned, zoomed and moved, found from its background.

    camera: how it moves, where a person knows: static, turns or moves.
    """

    do: Literal["find_camera"] = "find_camera"
    camera: Literal["static", "turns", "moves"] | None = None


class AddFilm(Message):
    """Another film of the motion, known by the library: when it was taken and where its camera
    stands are found."""

    do: Literal["add_film"] = "add_film"
    kind: Literal["file", "upload"]
    id: Annotated[str, Field(min_length=1, max_length=4096)]


class PlaceFilm(Message):
    """Where another film's camera stands, found anew for a frame of the first film, with its
    fraction, at which it begins."""

    do: Literal["place_film"] = "place_film"
    view: SceneId
    begins: films.Moment


class Stand(Message):
    """The tracked motion with its feet on the floor: contacts pinned, keyframes soft in depth, up
    and floor found."""

    do: Literal["stand"] = "stand"


class TrackAhead(Message):
    """The body followed on from the last keyframe, or back from the first."""

    do: Literal["track_ahead"] = "track_ahead"
    direction: Literal["forward", "backward"] = "forward"


class LookBefore(Message):
    """What stood before the last fit is shown, as long as `on`."""

    do: Literal["look_before"] = "look_before"
    on: bool


class PreviewPoses(Message):
    """New sizes are previewed with other poses, or with the poses as they are."""

    do: Literal["preview_poses"] = "preview_poses"
    on: bool


class ApplySizes(Message):
    """The previewed sizes are taken over."""

    do: Literal["apply_sizes"] = "apply_sizes"


class DiscardSizes(Message):
    """The previewed sizes are forgotten."""

    do: Literal["discard_sizes"] = "discard_sizes"


class Reduce(Message):
    """The motion as the fewest keyframes, as a preview.

    first, last: of the frames to reduce, those of the video where left out.  every: one keyframe in
    so many frames; else cm, px: a tolerance, at least one of them.  limbs: names of parts whose
    limbs are keyed alone.  replacing: whether keyframes that are there may go.  stroke: of the
    slider that is dragged, which changes nothing.
    """

    do: Literal["reduce"] = "reduce"
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    every: Annotated[int, Field(ge=1, le=10_000)] | None = None
    cm: Annotated[FiniteFloat, Field(ge=0.01, le=10_000)] | None = None
    px: Annotated[FiniteFloat, Field(ge=0.01, le=100_000)] | None = None
    limbs: Annotated[tuple[Name, ...], Field(max_length=1000)] = ()
    replacing: bool = False
    stroke: StrokeName | None = None

    @model_validator(mode="after")
    def _has_one_goal(self) -> Self:
        if (self.every is None) == (self.cm is None and self.px is None):
            raise ValueError("a tolerance is needed, in cm or in px, or a number of frames")
        return self


class ApplyReduction(Message):
    """The previewed keyframes are taken over."""

    do: Literal["apply_reduction"] = "apply_reduction"


class DiscardReduction(Message):
    """The previewed keyframes are forgotten."""

    do: Literal["discard_reduction"] = "discard_reduction"


class CloseFit(Message):
    """What the last fit did has been read."""

    do: Literal["close_fit"] = "close_fit"


class CloseUp(Message):
    """What was found of the up direction has been read."""

    do: Literal["close_up"] = "close_up"


class Cancel(Message):
    do: Literal["cancel"] = "cancel"


# --- files


class SaveAgain(Message):
    do: Literal["save_again"] = "save_again"


class RenameSession(Message):
    """The same of any recent session."""

    do: Literal["rename_session"] = "rename_session"
    id: SessionId
    title: Title


class DuplicateSession(Message):
    """A copy beside it; its video is not copied."""

    do: Literal["duplicate_session"] = "duplicate_session"
    id: SessionId


class DeleteSession(Message):
    """To the trash of the workspace; its video stays where it is."""

    do: Literal["delete_session"] = "delete_session"
    id: SessionId


class RestoreSession(Message):
    """Back from the trash; `open` where it was deleted while it was open."""

    do: Literal["restore_session"] = "restore_session"
    id: SessionId
    open: bool = False


class Close(Message):
    do: Literal["close"] = "close"


class Open(Message):
    do: Literal["open"] = "open"
    kind: Literal["recent", "file", "sample", "upload"]
    id: Annotated[str, Field(min_length=1, max_length=4096)]
    video: Annotated[str, Field(min_length=1, max_length=4096)] | None = Field(
        default=None, description="For a recent session whose video was moved: the file it is now."
    )


# --- kept poses


class KeepPose(Message):
    """The pose shown here is kept under a name, for every session."""

    do: Literal["keep_pose"] = "keep_pose"
    name: PoseName


class RenamePose(Message):
    do: Literal["rename_pose"] = "rename_pose"
    id: PoseId
    name: PoseName


class DeletePose(Message):
    """A kept pose is deleted; RestorePose has it back."""

    do: Literal["delete_pose"] = "delete_pose"
    id: PoseId


class RestorePose(Message):
    do: Literal["restore_pose"] = "restore_pose"
    id: PoseId


class InsertPose(Message):
    """A kept pose becomes that of the present frame, where the body stands."""

    do: Literal["insert_pose"] = "insert_pose"
    id: PoseId
    mirrored: bool = False


@dataclass(frozen=True)
class FilmToAdd:
    """What `AddFilm` asks for, once the library has found the file."""

    path: Path
    do: Literal["add_film"] = "add_film"


Previewing: TypeAlias = PreviewPoses | ApplySizes | DiscardSizes
Reducing: TypeAlias = Reduce | ApplyReduction | DiscardReduction
Fitting: TypeAlias = (
    FitHere
    | FitSizes
    | Draft
    | DraftRest
    | Lift
    | FindUp
    | FindPeople
    | FindCamera
    | AddFilm
    | PlaceFilm
    | Stand
    | TrackAhead
    | LookBefore
    | CloseFit
    | CloseUp
    | Previewing
)
Shelving: TypeAlias = RenameSession | DuplicateSession | DeleteSession | RestoreSession
PoseKeeping: TypeAlias = KeepPose | RenamePose | DeletePose | RestorePose
Running: TypeAlias = Track | Fitting | Reducing | Cancel | SaveAgain | Close | Open | Shelving
"""What the store does: jobs and files."""

Action: TypeAlias = Editing | Running | PoseKeeping | InsertPose

MESSAGES = tuple(
    kind
    for subject in (
        bodies,
        body,
        bonds,
        camera,
        copy_paste,
        films,
        floor,
        keyframes,
        moving_camera,
        notes,
        part_keyframes,
        pins,
        posing,
        tracking,
        update,
    )
    for kind in subject.MESSAGES
)
"""What `update` does: each file lists its own."""

_KINDS: Any = Union[(*MESSAGES, Running, PoseKeeping, InsertPose)]
ACTIONS: TypeAdapter[Action] = TypeAdapter(
    Annotated[_KINDS, Field(discriminator="do")], config=ConfigDict(defer_build=True)
)
