"""What a person can do, each as a small frozen message; also what the page sends, word for word.

Every value is checked here, where it enters. An action with a `stroke` is part of one gesture: the
gesture is applied to the document as it was before, so moves that are lost or merged do no harm.
Frames are video frame numbers; angles degrees, sizes centimetres, as on the page.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    StringConstraints,
    TypeAdapter,
    model_validator,
)

from keypose.app.editor.copied import Copied
from keypose.app.posing import Gesture, Way
from keypose.tracker.body.body import Body, Dof, Name, Point
from keypose.tracker.session.history import MOST_STEPS
from keypose.tracker.session.notes import LONGEST
from keypose.tracker.session.schema import Title
from keypose.tracker.session.settings import (
    ALL_CUES,
    Cue,
    Cues,
    CueWeight,
    FrameIndex,
    Initial,
    MethodName,
    NetworkName,
    Quality,
    Units,
    UpAxis,
    Weights,
)

Axis: TypeAlias = Literal["x", "y", "z"]
Degrees: TypeAlias = Annotated[FiniteFloat, Field(ge=-1080, le=1080)]
Centimetres: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
Metres: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e4, le=1e4)]
Coordinate: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
Spot: TypeAlias = tuple[Coordinate, Coordinate]
Polygon: TypeAlias = Annotated[tuple[Spot, ...], Field(min_length=3, max_length=500)]
Stroke: TypeAlias = Annotated[str, Field(min_length=1, max_length=60)]
StepCount: TypeAlias = Annotated[int, Field(ge=0, le=MOST_STEPS)]
PinIndex: TypeAlias = Annotated[int, Field(ge=0, le=1000)]
NoteText: TypeAlias = Annotated[str, Field(max_length=LONGEST)]
PoseName: TypeAlias = Annotated[
    str,
    StringConstraints(
        strip_whitespace=True, min_length=1, max_length=60, pattern=r"^[^\x00-\x1f]+$"
    ),
]
PoseId: TypeAlias = Annotated[str, Field(pattern=r"^[0-9a-f]{12}$")]
Frames: TypeAlias = Annotated[tuple[FrameIndex, ...], Field(min_length=1, max_length=10_000)]
Landmarks: TypeAlias = Annotated[tuple[Name, ...], Field(max_length=20)]


class Message(BaseModel):
    """One message; fields it does not know are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Edit(Message):
    """An action that changes the document; those of one stroke are one undo step."""

    stroke: Stroke | None = None


# --- where one looks


class Go(Message):
    do: Literal["go"] = "go"
    frame: FrameIndex


class Select(Message):
    do: Literal["select"] = "select"
    part: Name | None = None


class Show(Message):
    """How the body is drawn over the picture, and by what an observed surface is coloured."""

    do: Literal["display"] = "display"
    mode: Literal["wire", "solid", "both"] | None = None
    opacity: Annotated[FiniteFloat, Field(ge=0, le=1)] | None = None
    ghosts: bool | None = None
    trail: bool | None = None
    floor: bool | None = None
    tint: Literal["clay", "contact", "photo", "distance"] | None = None


class Live(Message):
    do: Literal["live"] = "live"
    on: bool


class Limits(Message):
    do: Literal["limits"] = "limits"
    on: bool


class Axes(Message):
    do: Literal["axes"] = "axes"
    frame: Literal["part", "parent", "view"]


class Link(Message):
    """Whether sizes of left and right change together."""

    do: Literal["link"] = "link"
    on: bool


class BeginGuide(Message):
    """The guide through the first pose once more: none of its steps is done."""

    do: Literal["begin_guide"] = "begin_guide"


# --- posing


class Drag(Edit, Gesture):
    """partial: the limbs it moves become a part keyframe of the present frame."""

    do: Literal["drag"] = "drag"
    partial: bool = False


class Angles(Edit):
    """Some angles of a part; `free` where its joint limits have been lifted."""

    do: Literal["angles"] = "angles"
    part: Name
    free: bool = False
    x: Degrees | None = None
    y: Degrees | None = None
    z: Degrees | None = None


class Root(Edit):
    do: Literal["root"] = "root"
    x: Metres | None = None
    y: Metres | None = None
    z: Metres | None = None


class Face(Edit):
    """The whole body turned about what is up, to face a way as seen in the picture."""

    do: Literal["face"] = "face"
    way: Way


class ResetPart(Edit):
    do: Literal["reset_part"] = "reset_part"
    part: Name


class ResetPose(Edit):
    do: Literal["reset_pose"] = "reset_pose"


class Exchange(Edit):
    """Left and right exchanged, where they are seen."""

    do: Literal["exchange"] = "exchange"


class TurnInDepth(Edit):
    """What points toward the camera points away from it, seen where it was: of a part and what
    hangs on it, or of the whole body."""

    do: Literal["turn_in_depth"] = "turn_in_depth"
    part: Name | None = None


class CopyPose(Message):
    """These keyframes, or the pose shown at the present frame."""

    do: Literal["copy_pose"] = "copy_pose"
    frames: Annotated[tuple[FrameIndex, ...], Field(max_length=10_000)] = ()


class PastePose(Edit):
    """What was copied: a pose here, keyframes from here on.

    copied: from elsewhere; left out, what was copied in this session.  onto_body: the first pose
    stands where the body does, not where it was copied.  replace: keyframes that are in the way.
    name: of a pose of the library.
    """

    do: Literal["paste_pose"] = "paste_pose"
    mirrored: bool = False
    copied: Copied | None = None
    onto_body: bool = False
    replace: bool = False
    name: PoseName | None = None


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


class CopyKey(Edit):
    """The pose of another keyframe, here."""

    do: Literal["copy_key"] = "copy_key"
    from_frame: FrameIndex


class TakeTracked(Edit):
    do: Literal["take_tracked"] = "take_tracked"


# --- keyframes


class AddKey(Edit):
    """The pose shown at a frame becomes its keyframe; where it is already, nothing changes."""

    do: Literal["add_key"] = "add_key"
    frame: FrameIndex


class DeleteKey(Edit):
    """The keyframe of a frame, or its part keyframe; the same for the next two."""

    do: Literal["delete_key"] = "delete_key"
    frame: FrameIndex


class MoveKey(Edit):
    do: Literal["move_key"] = "move_key"
    frame: FrameIndex
    to: FrameIndex


class DuplicateKey(Edit):
    do: Literal["duplicate_key"] = "duplicate_key"
    frame: FrameIndex
    to: FrameIndex


class KeyParts(Edit):
    """Limbs as they are shown at a frame become its part keyframe: those of these parts; left out,
    those that were posed there, else the selected part's."""

    do: Literal["key_parts"] = "key_parts"
    frame: FrameIndex
    parts: Annotated[tuple[Name, ...], Field(max_length=1000)] = ()


class UnkeyParts(Edit):
    """The limbs of these parts are tracked at a frame again."""

    do: Literal["unkey_parts"] = "unkey_parts"
    frame: FrameIndex
    parts: Annotated[tuple[Name, ...], Field(min_length=1, max_length=1000)]


class DeleteKeys(Edit):
    do: Literal["delete_keys"] = "delete_keys"
    frames: Frames


class RetimeKeys(Edit):
    """Several keyframes at other frames, one for each, in the same order: moved or stretched.
    copy_them: they stay where they are, too."""

    do: Literal["retime_keys"] = "retime_keys"
    frames: Frames
    to: Frames
    copy_them: bool = False

    @model_validator(mode="after")
    def _one_for_each(self) -> Self:
        if len(self.frames) != len(self.to):
            raise ValueError("give one frame for each keyframe")
        for frames in (self.frames, self.to):
            if any(a >= b for a, b in pairwise(frames)):
                raise ValueError("give frames in ascending order, each once")
        return self

    @property
    def is_shift(self) -> bool:
        """Whether all of them move by as much."""
        return len({b - a for a, b in zip(self.frames, self.to, strict=True)}) == 1


class KeyAngle(Edit):
    """One angle of a part at some keyframe: a point of the curve, dragged."""

    do: Literal["key_angle"] = "key_angle"
    frame: FrameIndex
    part: Name
    axis: Axis
    deg: Degrees


class SoftenKey(Edit):
    """The motion need only come near a keyframe."""

    do: Literal["soften_key"] = "soften_key"
    frame: FrameIndex


class ExactKey(Edit):
    """The motion meets a keyframe exactly, as it does unless it was softened."""

    do: Literal["exact_key"] = "exact_key"
    frame: FrameIndex


# --- notes


class SetNote(Edit):
    """A note at a frame, or other words for the one that is there; empty for a mere flag."""

    do: Literal["set_note"] = "set_note"
    frame: FrameIndex
    text: NoteText = ""


class MoveNote(Edit):
    """A note at another frame, where there is none yet."""

    do: Literal["move_note"] = "move_note"
    frame: FrameIndex
    to: FrameIndex


class DeleteNote(Edit):
    do: Literal["delete_note"] = "delete_note"
    frame: FrameIndex


# --- pins and the floor


class SetPin(Edit):
    """A part pinned at a frame, and over the frames around it at which it stands still.

    first, last: these frames instead.  landmarks: of the part, its heel and toe where left out and
    it has them, else its joint.  point_m: a point in the part's frame instead, metres; corner: the
    corner of the part that is seen nearest to these pixels of the camera's view.
    floor: it stands on the floor, which is laid under it where nobody knows its height.
    """

    do: Literal["set_pin"] = "set_pin"
    part: Name
    frame: FrameIndex
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    landmarks: Landmarks | None = None
    point_m: Point | None = None
    corner: Spot | None = None
    floor: bool = False


class ChangePin(Edit):
    """Fields that are left out stay. An end that would run into another pin of the same points
    stops there; both ends moved by as much move the pin."""

    do: Literal["change_pin"] = "change_pin"
    index: PinIndex
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    landmarks: Landmarks | None = None
    floor: bool | None = None


class DeletePin(Edit):
    do: Literal["delete_pin"] = "delete_pin"
    index: PinIndex


class SplitPin(Edit):
    """Two pins instead of one, the second from this frame on."""

    do: Literal["split_pin"] = "split_pin"
    index: PinIndex
    frame: FrameIndex


class AcceptPins(Edit):
    """The proposed pins of a part, or of a part from a frame on; all where neither is named."""

    do: Literal["accept_pins"] = "accept_pins"
    part: Name | None = None
    first: FrameIndex | None = None


class DismissPins(Message):
    """The proposed pins, as for AcceptPins, are not shown until others are proposed."""

    do: Literal["dismiss_pins"] = "dismiss_pins"
    part: Name | None = None
    first: FrameIndex | None = None


class Floor(Edit):
    """The floor's height along up from the camera, or that of the pinned feet, or of a part as it
    stands at the present frame; none of them: it is not known."""

    do: Literal["floor"] = "floor"
    height_m: Metres | None = None
    pinned_feet: bool = False
    under: Name | None = None


# --- the review


class AcceptPlace(Edit):
    """The motion is right at this place to review: of a part, or of the whole body."""

    do: Literal["accept_place"] = "accept_place"
    frame: FrameIndex
    part: Name | None = None


class CannotTell(Edit):
    """Whether it is right there nobody can tell from the picture."""

    do: Literal["cannot_tell"] = "cannot_tell"
    frame: FrameIndex
    part: Name | None = None


# --- the body


class Shape(Edit):
    """A part of another shape, about as large."""

    do: Literal["shape"] = "shape"
    part: Name
    kind: Annotated[str, Field(max_length=40)]


class Size(Edit):
    do: Literal["size"] = "size"
    part: Name
    key: Annotated[str, Field(max_length=40)]
    cm: Centimetres


class Joint(Edit):
    do: Literal["joint"] = "joint"
    part: Name
    x: Centimetres | None = None
    y: Centimetres | None = None
    z: Centimetres | None = None


class Height(Edit):
    do: Literal["height"] = "height"
    cm: Centimetres


class Preset(Edit):
    do: Literal["preset"] = "preset"
    name: Name


class SetBody(Edit):
    """A body of one's own, as in its file."""

    do: Literal["body"] = "body"
    body: Body


class AddPart(Edit):
    """One more part, at the far end of another."""

    do: Literal["add_part"] = "add_part"
    parent: Name
    name: Name


class DeletePart(Edit):
    """A part and all that hangs on it."""

    do: Literal["delete_part"] = "delete_part"
    part: Name


class RenamePart(Edit):
    do: Literal["rename_part"] = "rename_part"
    part: Name
    name: Name


class ResetBody(Edit):
    do: Literal["reset_body"] = "reset_body"


class Clavicles(Edit):
    """Whether shoulders move on the chest."""

    do: Literal["clavicles"] = "clavicles"
    on: bool


class Tracked(Edit):
    """Which motions of a part the tracker estimates."""

    do: Literal["tracked"] = "tracked"
    part: Name
    dofs: Annotated[tuple[Dof, ...], Field(max_length=6)]


# --- the camera


class Intrinsics(Edit):
    do: Literal["camera"] = "camera"
    fx: FiniteFloat | None = None
    fy: FiniteFloat | None = None
    cx: FiniteFloat | None = None
    cy: FiniteFloat | None = None


class FieldOfView(Edit):
    do: Literal["field_of_view"] = "field_of_view"
    deg: Annotated[FiniteFloat, Field(ge=1, le=170)]


class Lens(Edit):
    """The lens that shows as much on 35 mm film, and who says so; without `mm` a guess.

    bent: whether it bends straight edges, as an action camera's does; left out, as before.
    """

    do: Literal["lens"] = "lens"
    mm: Annotated[FiniteFloat, Field(ge=4, le=2000)] | None = None
    known: Literal["person", "file", "guess"] = "person"
    bent: bool | None = None


class Distortion(Edit):
    do: Literal["distortion"] = "distortion"
    k1: FiniteFloat | None = None
    k2: FiniteFloat | None = None
    p1: FiniteFloat | None = None
    p2: FiniteFloat | None = None
    k3: FiniteFloat | None = None


class Vertical(Edit):
    """A line drawn on the picture along something upright, in pixels."""

    do: Literal["vertical"] = "vertical"
    a: Spot
    b: Spot


class UpFromFeet(Edit):
    """Up so that the pinned feet stand level."""

    do: Literal["up_from_feet"] = "up_from_feet"


class ResetUp(Edit):
    do: Literal["reset_up"] = "reset_up"


# --- masks and settings


class AddMask(Edit):
    do: Literal["add_mask"] = "add_mask"
    polygon: Polygon
    first: FrameIndex
    last: FrameIndex


class ChangeMask(Edit):
    do: Literal["change_mask"] = "change_mask"
    index: Annotated[int, Field(ge=0, le=10_000)]
    polygon: Polygon | None = None
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    note: Annotated[str, Field(max_length=200)] | None = None


class DeleteMask(Edit):
    do: Literal["delete_mask"] = "delete_mask"
    index: Annotated[int, Field(ge=0, le=10_000)]


class Settings(Edit):
    """Fields that are left out stay; `passes` may be given as null, the method's own number,
    `static_camera`, as it was found, and `smooth`, not. cue_weights: those left out are 1."""

    do: Literal["settings"] = "settings"
    method: MethodName | None = None
    quality: Quality | None = None
    initial: Initial | None = None
    left_out: Annotated[tuple[Name, ...], Field(max_length=1000)] | None = None
    passes: Annotated[int, Field(ge=1, le=50)] | None = None
    static_camera: bool | None = None
    smooth: bool | None = None
    cues: Annotated[Cues, Field(max_length=len(ALL_CUES))] | None = None
    cue_weights: dict[Cue, CueWeight] | None = None
    network: NetworkName | None = None


class CorrectKeypoint(Edit):
    """Where a joint is seen in a frame. at: pixels of the main view."""

    do: Literal["correct_keypoint"] = "correct_keypoint"
    frame: FrameIndex
    joint: Name
    at: Spot


class IgnoreKeypoint(Edit):
    """What was found of a joint in a frame does not count."""

    do: Literal["ignore_keypoint"] = "ignore_keypoint"
    frame: FrameIndex
    joint: Name


class RestoreKeypoint(Edit):
    """A joint is where it was found in a frame."""

    do: Literal["restore_keypoint"] = "restore_keypoint"
    frame: FrameIndex
    joint: Name


class Observe(Edit):
    """How observed surfaces are read and fitted. Fields that are left out stay; `model_frame` may
    be null, the first keyframe. about: the point, camera frame, that other axes turn about."""

    do: Literal["observe"] = "observe"
    units: Units | None = None
    up: UpAxis | None = None
    about: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.0)
    fps: Annotated[FiniteFloat, Field(ge=0.001, le=10_000)] | None = None
    model_frame: FrameIndex | None = None
    weights: Weights | None = None
    distance: Literal["plane", "point"] | None = None
    binding: Literal["nearest", "smooth"] | None = None


# --- history, tracking, the session


class Undo(Message):
    do: Literal["undo"] = "undo"


class Redo(Message):
    do: Literal["redo"] = "redo"


class GoToStep(Message):
    """Undo or redo, until so many steps are done. of: how many there are in all, as the page knows
    it; other ones may have been made meanwhile."""

    do: Literal["go_to_step"] = "go_to_step"
    done: StepCount
    of: StepCount


class EndStroke(Message):
    do: Literal["end_stroke"] = "end_stroke"
    stroke: Stroke


class CancelStroke(Message):
    do: Literal["cancel_stroke"] = "cancel_stroke"
    stroke: Stroke


class Track(Message):
    do: Literal["track"] = "track"
    what: Literal["this", "changed", "all"] = "changed"


class FitHere(Message):
    """The pose of the present frame improved from its picture."""

    do: Literal["fit_here"] = "fit_here"


class FitSizes(Message):
    """The body's sizes from the pictures of all keyframes; optionally the focal length too."""

    do: Literal["fit_sizes"] = "fit_sizes"
    focal: bool = False


class Draft(Message):
    """A pose for every frame, from a box around the person on one of them.

    box: left, top, right and bottom, pixels of the video.  first, last: of the frames to draft,
    those of the video where left out.
    """

    do: Literal["draft"] = "draft"
    frame: FrameIndex
    box: tuple[Coordinate, Coordinate, Coordinate, Coordinate]
    first: FrameIndex | None = None
    last: FrameIndex | None = None


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

    first, last: of the frames to reduce, those of the video where left out.  cm, px: the tolerance,
    at least one of them.  limbs: names of parts whose limbs are keyed alone.  replacing: whether
    keyframes that are there may go.  stroke: of the slider that is dragged, which changes nothing.
    """

    do: Literal["reduce"] = "reduce"
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    cm: Annotated[FiniteFloat, Field(ge=0.01, le=10_000)] | None = None
    px: Annotated[FiniteFloat, Field(ge=0.01, le=100_000)] | None = None
    limbs: Annotated[tuple[Name, ...], Field(max_length=1000)] = ()
    replacing: bool = False
    stroke: Stroke | None = None

    @model_validator(mode="after")
    def _has_a_tolerance(self) -> Self:
        if self.cm is None and self.px is None:
            raise ValueError("a tolerance is needed, in cm or in px")
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


class Cancel(Message):
    do: Literal["cancel"] = "cancel"


class SaveAgain(Message):
    do: Literal["save_again"] = "save_again"


class Rename(Edit):
    """What a person calls the open session; empty: as its folder is called."""

    do: Literal["rename"] = "rename"
    title: Title


SessionId: TypeAlias = Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]
"""Of a session among the recent ones, or of one in the trash."""


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


Looking: TypeAlias = (
    Go | Select | Show | Live | Limits | Axes | Link | BeginGuide | CopyPose | DismissPins
)
Posing: TypeAlias = (
    Drag
    | Angles
    | Root
    | Face
    | ResetPart
    | ResetPose
    | Exchange
    | TurnInDepth
    | PastePose
    | CopyKey
    | TakeTracked
)
Noting: TypeAlias = SetNote | MoveNote | DeleteNote
Keying: TypeAlias = (
    AddKey
    | DeleteKey
    | MoveKey
    | DuplicateKey
    | DeleteKeys
    | RetimeKeys
    | KeyParts
    | UnkeyParts
    | KeyAngle
    | SoftenKey
    | ExactKey
)
Pinning: TypeAlias = SetPin | ChangePin | DeletePin | SplitPin | AcceptPins | Floor
Reviewing: TypeAlias = AcceptPlace | CannotTell
Shaping: TypeAlias = (
    Shape
    | Size
    | Joint
    | Height
    | Preset
    | SetBody
    | AddPart
    | DeletePart
    | RenamePart
    | ResetBody
    | Clavicles
    | Tracked
)
Filming: TypeAlias = Intrinsics | FieldOfView | Lens | Distortion | Vertical | UpFromFeet | ResetUp
Choosing: TypeAlias = AddMask | ChangeMask | DeleteMask | Settings | Observe
Seeing: TypeAlias = CorrectKeypoint | IgnoreKeypoint | RestoreKeypoint
Rewinding: TypeAlias = Undo | Redo | GoToStep | EndStroke | CancelStroke
Editing: TypeAlias = (
    Looking
    | Posing
    | Keying
    | Noting
    | Pinning
    | Reviewing
    | Shaping
    | Filming
    | Choosing
    | Seeing
    | Rename
    | Rewinding
)
"""What `keypose.app.editor.update` knows to apply."""

Previewing: TypeAlias = PreviewPoses | ApplySizes | DiscardSizes
Reducing: TypeAlias = Reduce | ApplyReduction | DiscardReduction
Shelving: TypeAlias = RenameSession | DuplicateSession | DeleteSession | RestoreSession
Fitting: TypeAlias = FitHere | FitSizes | Draft | TrackAhead | LookBefore | CloseFit | Previewing
Running: TypeAlias = Track | Fitting | Reducing | Cancel | SaveAgain | Close | Open | Shelving
"""What the store does: jobs and files."""

PoseKeeping: TypeAlias = KeepPose | RenamePose | DeletePose | RestorePose
"""What the store does with the kept poses."""

Action: TypeAlias = Annotated[
    Editing | Running | PoseKeeping | InsertPose, Field(discriminator="do")
]

ACTIONS: TypeAdapter[Action] = TypeAdapter(Action)
