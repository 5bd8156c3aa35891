"""The state of the program, as far as the page shows it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

from keypose.app.document.library.poses import KeptPose
from keypose.app.editor.ahead import followed_so_far
from keypose.app.editor.state import EditorState
from keypose.app.state.job_state import JobState
from keypose.app.state.outcomes import Boxes, FitOutcome, Following, FoundUp
from keypose.app.state.previews import ReductionPreview, SizesPreview
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session.references import Repeats
from keypose.tracker.session.schema import Session
from keypose.tracker.video import VideoInfo


@dataclass(frozen=True, eq=False)
class KnownKeypoints:
    """What tracking found in the present segment, and those of the session's file: of a draft, or
    imported. None where nothing is known. of_films: those of the other films, by the view's id."""

    of_segment: Keypoints | None = None
    of_file: Keypoints | None = None
    of_films: Mapping[str, Keypoints] = field(default_factory=dict)

    def by_view(self, doc: Session) -> dict[str, Keypoints]:
        """Those of all films whose keypoints are in files, by the view's id."""
        first = {} if self.of_file is None else {doc.view.id: self.of_file}
        return {**first, **self.of_films}

    def at(self, frame: int) -> Keypoints | None:
        """The keypoints of one frame: what tracking uses goes first."""
        for keypoints in (self.of_segment, self.of_file):
            if keypoints is not None and keypoints.first_frame <= frame <= keypoints.last_frame:
                return keypoints.over(frame, frame)
        return None


@dataclass(frozen=True)
class Saved:
    """Whether the session is on disk; at_s is the time of the last save, seconds since 1970."""

    state: Literal["saved", "saving", "failed", "readonly"] = "saved"
    at_s: float = 0.0
    words: str = ""


@dataclass(frozen=True)
class Guide:
    """How far a person is with the first pose.

    first: whether the session had no keyframe when it was opened.  done: names of the steps that
    were done, in whatever way.  pulled: ends of limbs that were dragged.
    """

    first: bool = False
    done: frozenset[str] = frozenset()
    pulled: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Running:
    """A segment at work: passes finished and expected, their scores."""

    state: Literal["waiting", "tracking"] = "waiting"
    number: int = 0
    of: int = 1
    percent: int = 0
    scores: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class OpenedFile:
    """The session's file and its video; `film` distinguishes videos, whatever they are called.

    id: of the session among the recent ones.  name: where a person has not called it otherwise.
    repeats: repeated frames of the video, found since it was opened; None where none were.
    """

    name: str
    session_path: str
    id: str
    info: VideoInfo
    film: str = ""
    repeats: Repeats | None = None


@dataclass(frozen=True)
class SurfaceSeen:
    """What was seen of the observed surfaces so far.

    problem: why there is none at `frame`, a sentence; empty where there is.
    middle:  (x, y, z) of the one there, camera frame, metres.
    rims:    edges of the model's surface with a face on one side only; None while not known.
    photo:   whether it is known how well cameras agree.
    """

    frame: int | None = None
    problem: str = ""
    faces: int = 0
    middle: tuple[float, float, float] | None = None
    rims: int | None = None
    photo: bool = False


@dataclass(frozen=True, eq=False)
class AppState:
    """All that the page shows.

    server: differs for every start of the program.  revision: differs after every edit.
    opened, edit: the open session's file, and what is edited of it; None where none is open.
    job: what the worker does.  running: the segments at work, by (first, last).
    tabs: how many show this.  guide: of the first pose.
    fit, up: what the last fit, and the last look for up, did, until something else is edited.
    draft: the document as the last draft of the clip left it.
    unusable: which observed surfaces cannot be used, a sentence as far as is known, or empty.
    following: how far the body is tracked ahead.
    preview: new sizes that wait to be applied.  reduction: reduced keyframes that do.
    poses: those that were kept.
    people: boxes around who was found, by frame, the tallest first; None where that was not done to
    the end.
    """

    server: str = ""
    revision: str = ""
    opened: OpenedFile | None = None
    edit: EditorState | None = None
    job: JobState = field(default_factory=JobState)
    saved: Saved = Saved()
    guide: Guide = Guide()
    tabs: int = 0
    running: Mapping[tuple[int, int], Running] = field(default_factory=dict)
    fit: FitOutcome | None = None
    up: FoundUp | None = None
    draft: Session | None = None
    keypoints: KnownKeypoints = KnownKeypoints()
    following: Following | None = None
    preview: SizesPreview | None = None
    reduction: ReductionPreview | None = None
    surface: SurfaceSeen = SurfaceSeen()
    unusable: str = ""
    poses: tuple[KeptPose, ...] = ()
    people: Mapping[int, Boxes | None] = field(default_factory=dict)

    @property
    def editing(self) -> EditorState:
        """What is edited while something is open."""
        assert self.edit is not None
        return self.edit

    @cached_property
    def displayed(self) -> AppState:
        """The state with what is only shown: the motion as far as it is tracked ahead, sizes
        that are not applied yet, or what stood before the last fit while somebody looks back at it.
        """
        edit, preview = self.edit, self.preview
        if edit is None:
            return self
        if preview is not None:
            return self if preview.looking_back else replace(self, edit=preview.shown_in(edit))
        if self.following is not None and edit.stroke is None:
            doc = followed_so_far(edit, self.following.frame, self.following.motion)
            return replace(self, edit=edit.with_doc(doc))
        if self.fit is None or not self.fit.looking_back:
            return self
        return replace(self, edit=edit.with_doc(self.fit.before))
