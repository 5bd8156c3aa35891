"""Orders to track and fit, and reports about them: all that passes between the
processes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session.annotations import Direction
from keypose.tracker.session.settings import Quality
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.storage.stretches import SegmentRun
from keypose.tracker.tracking.result import SegmentResult

if TYPE_CHECKING:
    from keypose.app.editor.reduced import Reducible
    from keypose.tracker.fitting.draft import Proposal
    from keypose.tracker.fitting.sizes import Proposal as SizesProposal
    from keypose.tracker.reduction.result import Goal, Reduction
    from keypose.tracker.tracking.ahead.follow import FoundAhead

Wanted: TypeAlias = tuple[int, int, str]
"""First frame, last frame and key of a segment to track."""


Unit: TypeAlias = Literal["pass", "step"]


@dataclass(frozen=True)
class Order:
    """Track these segments, all at the first quality, then all at the next.

    session: JSON of a session that holds at least their keyframes.
    folder: of the session's file, where its imported motion lies.
    """

    job: int
    session: bytes
    video_path: str
    wanted: tuple[Wanted, ...]
    stages: tuple[Quality, ...]
    folder: str = ""


@dataclass(frozen=True, eq=False)
class PoseOrder:
    """Fit the pose of one frame to its picture.

    session: JSON of a session with the body, the camera, the masks and all keyframes.
    tracked: the tracked poses of frames near, by frame.
    folder: of the session's file.
    """

    session: bytes
    video_path: str
    frame: int
    pose: Pose
    tracked: Mapping[int, Pose] = field(default_factory=dict)
    folder: str = ""
    job: int = 0


@dataclass(frozen=True)
class SizesOrder:
    """Fit the body's sizes to its keyframes' pictures; optionally the camera's focal length too."""

    session: bytes
    video_path: str
    focal: bool = False
    job: int = 0


@dataclass(frozen=True)
class DraftOrder:
    """Draft a pose of every frame from a box around the person on one of them.

    session: JSON of a session with the body and the camera, without poses.
    frame, box: the frame of the box, and left, top, right, bottom in pixels.
    frames: first and last to draft.
    proportions: whether the body's limbs may be scaled to the person's.
    """

    session: bytes
    video_path: str
    frame: int
    box: Box
    frames: tuple[int, int]
    proportions: bool
    job: int = 0


@dataclass(frozen=True)
class AheadOrder:
    """Follow the body from a keyframe as far as the evidence carries.

    session: JSON of a session with its keyframes.
    folder: of the session's file.
    """

    session: bytes
    video_path: str
    frame: int
    direction: Direction
    folder: str = ""
    job: int = 0


@dataclass(frozen=True, eq=False)
class ReduceOrder:
    """Reduce a motion to keyframes.

    session: JSON of a session with the body and the camera.
    """

    session: bytes
    video_path: str
    found: Reducible
    goal: Goal
    job: int = 0


@dataclass(frozen=True, eq=False)
class SpaceOrder:
    """Solve for the motion in space of these stretches, which were tracked before.

    session: JSON of a session with its keyframes and pins.
    """

    session: bytes
    stretches: tuple[SegmentRun, ...]
    job: int = 0


@dataclass(frozen=True)
class LearnOrder:
    """Solve anew for drafts near keyframes that are new, with what these give.

    session: JSON of a session with its keyframes and drafts, as far as they are near.
    around: frames of the new keyframes.
    folder: of the session's file, where the keypoints lie.
    """

    session: bytes
    video_path: str
    around: tuple[int, ...]
    folder: str
    job: int = 0


FitOrder: TypeAlias = PoseOrder | SizesOrder | DraftOrder | AheadOrder | ReduceOrder | LearnOrder
AnyOrder: TypeAlias = Order | FitOrder | SpaceOrder


@dataclass(frozen=True)
class Cancel:
    """Leave a job within one pass."""

    job: int


@dataclass(frozen=True)
class Pause:
    """Pause during a drag (`on`), or continue: each pass waits, though not for long."""

    on: bool


@dataclass(frozen=True)
class Warming:
    """The worker is getting ready; the job, if there is one, waits for it."""

    words: str
    job: int | None = None


@dataclass(frozen=True)
class Ready:
    """The worker can track."""

    job: int | None = None


@dataclass(frozen=True)
class Started:
    """Work on a job has begun. stages: those that there will be."""

    job: int
    wanted: tuple[Wanted, ...]
    stages: tuple[Quality, ...]


@dataclass(frozen=True, eq=False)
class PassFinished:
    """One more trajectory of a segment, the `number`th (from 0) of about `of`. Not of previews."""

    job: int
    number: int
    of: int
    result: SegmentResult

    @property
    def unit(self) -> Unit:
        """Return what is counted: of surfaces it is the steps of time that are done."""
        return "step" if self.result.steps == ("fit",) else "pass"

    @property
    def words(self) -> str:
        """Such as "pass 3 of 8"."""
        return f"{self.unit} {self.number + 1} of {max(self.of, self.number + 1)}"


@dataclass(frozen=True, eq=False)
class SegmentFinished:
    """A segment is done at one quality; also reported of a job that has been cancelled since."""

    job: int
    result: SegmentResult


@dataclass(frozen=True, eq=False)
class SpaceSolved:
    """The motion of a stretch in space is known."""

    job: int
    result: SpaceResult


@dataclass(frozen=True)
class JobFinished:
    """Nothing more will come of a job: all is done, or it was cancelled or replaced by a newer."""

    job: int
    cancelled: bool


@dataclass(frozen=True)
class JobFailed:
    """A job ended by something a person should know: one sentence. What was finished is reported
    before and stays good."""

    job: int
    words: str


@dataclass(frozen=True, eq=False)
class PoseFitted:
    """The pose of a frame as its picture shows it, and what that changed, in words.

    found: whether the picture showed anything; without it the pose is as it was.
    """

    job: int
    pose: Pose
    found: bool
    words: str


@dataclass(frozen=True, eq=False)
class SizesFitted:
    """What fits the keyframes' pictures better, to be chosen from.

    error_px: of the body's outline as it is.  alone: other sizes, poses as they are; with_poses:
    limbs posed anew as well.  Either is None where it fits no better; unseen: parts.
    """

    job: int
    words: str
    error_px: float = 0.0
    alone: SizesProposal | None = None
    with_poses: SizesProposal | None = None
    unseen: tuple[str, ...] = ()


@dataclass(frozen=True)
class Drafting:
    """How far a draft is: frames that the network has looked at, then frames that are posed."""

    job: int
    stage: Literal["keypoints", "poses"]
    done: int
    expected: int


@dataclass(frozen=True, eq=False)
class Drafted:
    """A pose for every frame that shows the person well enough.

    body: with the person's proportions.  keypoints: what the poses were made from.
    network: its fingerprint.  proposals: the poses to confirm as keyframes.
    """

    job: int
    body: Body
    poses: Mapping[int, Pose]
    keypoints: Keypoints
    network: str
    proposals: tuple[Proposal, ...]


@dataclass(frozen=True, eq=False)
class FollowingAhead:
    """How far the body was followed from the keyframe at a frame: the motion so far, by frame, of
    about so many steps."""

    job: int
    frame: int
    motion: Trajectory
    of: int


@dataclass(frozen=True, eq=False)
class FollowedAhead:
    """The body was followed, perhaps no farther than its keyframe."""

    job: int
    found: FoundAhead


@dataclass(frozen=True)
class Reducing:
    """How far a reduction is: frames that are reached."""

    job: int
    done: int
    expected: int


@dataclass(frozen=True, eq=False)
class Reduced:
    """The frames to keep as keyframes."""

    job: int
    reduction: Reduction


@dataclass(frozen=True, eq=False)
class Learned:
    """Drafts with what keyframes give, by frame."""

    job: int
    poses: Mapping[int, Pose]


Fitted: TypeAlias = PoseFitted | SizesFitted | Drafted | FollowedAhead | Reduced
"""What ends a fit that a person asked for, unless it was cancelled or failed."""

Report: TypeAlias = (
    Warming
    | Ready
    | Started
    | PassFinished
    | SegmentFinished
    | SpaceSolved
    | Drafting
    | FollowingAhead
    | Reducing
    | JobFinished
    | JobFailed
    | Fitted
    | Learned
)
