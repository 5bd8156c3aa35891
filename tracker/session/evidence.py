"""What a body is compared with: a film, or observed surfaces.

Only facts are here, and nothing that opens a file. What needs a decoder or a fit, and texts that
only one interface shows, are in a `ByEvidence` table of the package concerned.

A new kind, such as several films, is a new class in EVIDENCE_KINDS. If it derives from an existing
kind, it is treated like that one wherever a table has no entry for it.
"""

from __future__ import annotations

import shlex
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import (
    TYPE_CHECKING,
    Any,
    ClassVar,
    Generic,
    Literal,
    Protocol,
    Self,
    TypeAlias,
    TypeVar,
)

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, frozen

if TYPE_CHECKING:
    from keypose.tracker.session.keyframe import Keyframe
    from keypose.tracker.session.references import Surface, VideoReference
    from keypose.tracker.session.views import View

T = TypeVar("T")
Frames: TypeAlias = Collection[int]
Fields: TypeAlias = dict[str, Any]
"""Fields of a session with other values."""


class EvidenceSource(Protocol):
    """What of a session says which evidence it has; `schema.Session` is one."""

    @property
    def view(self) -> View: ...

    @property
    def model_extra(self) -> dict[str, Any] | None: ...

    @property
    def evidence(self) -> Evidence: ...


@dataclass(frozen=True)
class Words:
    """What evidence is called, and the verbs for working on it.

    noun, and whether it is a plural.  verb: what is done with it, of which doing and done are
    forms.  unit: what is counted meanwhile.  file: what of it lies on the disk.  setup: what a
    motion is found for besides keyframes.  command: of `keypose`, up to the session's path.
    """

    noun: str
    is_plural: bool
    verb: str
    doing: str
    done: str
    unit: str
    file: str
    setup: str
    command: str

    @property
    def noun_with_is(self) -> str:
        """Such as "video is"."""
        return f"{self.noun} {'are' if self.is_plural else 'is'}"

    @property
    def noun_was(self) -> str:
        """Such as "video was"."""
        return f"{self.noun} {'were' if self.is_plural else 'was'}"

    def command_line(self, session_path: Path) -> str:
        """The command that tracks a saved session."""
        return f"keypose {self.command} {shlex.quote(str(session_path))}"


class Evidence(ABC):
    """What the body of one session is compared with.

    fewest_keyframes: without so many nothing can be found.
    is_posed_first:   whether a pose can be fitted only where a person has posed one.
    has_surface:      whether surfaces of it are seen from every side, and can be coloured.
    can_be_damaged:   whether what is wrong with one frame of its file may spoil others.
    is_known_by_fingerprint: whether another fingerprint means other evidence; otherwise it may have
        been exported again.
    residual_unit:    of the residual, the distance of the body from it.
    run_fields:       fields of the session that a run may set besides results.
    """

    words: ClassVar[Words]
    fewest_keyframes: ClassVar[int]
    is_posed_first: ClassVar[bool]
    has_surface: ClassVar[bool]
    can_be_damaged: ClassVar[bool]
    is_known_by_fingerprint: ClassVar[bool]
    residual_unit: ClassVar[Literal["px", "m"]]
    run_fields: ClassVar[tuple[str, ...]] = ()

    def __init__(self, video: VideoReference) -> None:
        self.video = video

    @classmethod
    @abstractmethod
    def of(cls, session: EvidenceSource) -> Self | None:
        """The session's; None where that has another kind."""

    # --- keyframes and segments

    @abstractmethod
    def open_ends(self, keyed: Frames, reached: Frames | None = None) -> tuple[int, ...]:
        """Frames at which a motion begins or ends without a keyframe, ascending.

        keyed: frames of the keyframes.  reached: where it begins or ends; the first frame and the
        last when left out.
        """

    def spans(self, keyed: Sequence[int]) -> tuple[tuple[int, int], ...]:
        """First and last frame of every segment of a motion through keyframes."""
        if len(keyed) < self.fewest_keyframes:
            return ()
        return tuple(pairwise(sorted({*keyed, *self.open_ends(keyed)})))

    def model_keyframe(self, keyframes: Sequence[Keyframe]) -> Keyframe | None:
        """The keyframe at which a part of it was bound to the body; None where nothing is."""
        return None

    def dof_count(self, skeleton: Skeleton) -> int:
        """Degrees of freedom that are estimated."""
        return skeleton.dof_count

    def with_key_moved(self, frame: int, to: int) -> Fields:
        """The session's fields once the keyframe of a frame stands at another."""
        return {}

    # --- time

    @property
    def fps(self) -> float | None:
        """Frames a second as the session has them; None where the file has the times."""
        return None

    def times_s(self, of_file: Array | None) -> Array:
        """(frames,) seconds in the world: by that rate, else the file's own; TypeError where there
        is neither."""
        if self.fps is not None:
            return frozen(np.arange(self.video.frame_count) / self.fps)
        if of_file is None:
            raise TypeError("neither the session nor the file says when frames are")
        return of_file

    # --- identity

    def is_same(self, evidence: Evidence) -> bool:
        """Whether both are the same, as far as is known."""
        a, b = self.video.fingerprint, evidence.video.fingerprint
        return self._is_as_large(evidence) and (a == b or "" in (a, b))

    def _is_as_large(self, evidence: Evidence) -> bool:
        a, b = self.video, evidence.video
        return (a.frame_count, a.width, a.height) == (b.frame_count, b.width, b.height)

    @property
    def fingerprints(self) -> Mapping[str, str]:
        """The fingerprints of its files, by name."""
        return {self.words.noun: self.video.fingerprint}

    @property
    def export_fields(self) -> Mapping[str, set[str]]:
        """Fields of the session that depend on where and when it was exported."""
        return {"video": {"path"}}

    def refreshed_fields(self, now: Evidence) -> Fields:
        """The session's fields, updated from a later look at the same files; what a person says of
        them stays."""
        own = {
            name: getattr(self.video, name) for name in ("recorded_fps", "deinterlace", "repeats")
        }
        return {"video": now.video.model_copy(update=own)}

    def with_paths(self, moved: Callable[[str], str]) -> Fields:
        """The session's fields with every path moved."""
        path = moved(self.video.path)
        return {"video": self.video.model_copy(update={"path": path})}


class FilmEvidence(Evidence):
    """The pictures of one film."""

    words = Words(
        noun="video",
        is_plural=False,
        verb="track",
        doing="tracking",
        done="tracked",
        unit="pass",
        file="video",
        setup="body, camera or ignore masks",
        command="track",
    )
    fewest_keyframes = 2
    is_posed_first = True
    has_surface = False
    can_be_damaged = True
    is_known_by_fingerprint = True
    residual_unit = "px"

    @classmethod
    def of(cls, session: EvidenceSource) -> Self | None:
        return cls(session.view.video) if session.view.surface is None else None

    def open_ends(self, keyed: Frames, reached: Frames | None = None) -> tuple[int, ...]:
        return ()

    @property
    def fps(self) -> float | None:
        return self.video.recorded_fps


class SurfaceEvidence(Evidence):
    """Observed surfaces, one for every frame.

    They can be followed one by one, so that a segment also lies before the first keyframe and
    after the last.
    """

    words = Words(
        noun="meshes",
        is_plural=True,
        verb="fit",
        doing="fitting",
        done="fitted",
        unit="step",
        file="folder or file of meshes",
        setup="body or surfaces",
        command="fit --session",
    )
    fewest_keyframes = 1
    is_posed_first = False
    has_surface = True
    can_be_damaged = False
    is_known_by_fingerprint = False
    residual_unit = "m"
    run_fields = ("surface", "video")

    def __init__(self, video: VideoReference, surface: Surface) -> None:
        super().__init__(video)
        self.surface = surface

    @classmethod
    def of(cls, session: EvidenceSource) -> Self | None:
        return (
            None if session.view.surface is None else cls(session.view.video, session.view.surface)
        )

    def open_ends(self, keyed: Frames, reached: Frames | None = None) -> tuple[int, ...]:
        ends = {0, self.video.frame_count - 1} if reached is None else set(reached)
        return tuple(sorted(ends - set(keyed)))

    def model_keyframe(self, keyframes: Sequence[Keyframe]) -> Keyframe | None:
        """The keyframe whose mesh moves with the body."""
        wanted = [keyframe for keyframe in keyframes if keyframe.frame == self.surface.model_frame]
        return next(iter((*wanted, *keyframes)), None)

    def dof_count(self, skeleton: Skeleton) -> int:
        """All of every part."""
        return 3 + 3 * len(skeleton.body.parts)

    def with_key_moved(self, frame: int, to: int) -> Fields:
        if self.surface.model_frame != frame:
            return {}
        return {"surface": self.surface.model_copy(update={"model_frame": to})}

    @property
    def fps(self) -> float:
        return self.surface.fps

    def is_same(self, evidence: Evidence) -> bool:
        """Meshes may have been exported again, as many as they were."""
        if isinstance(evidence, SurfaceEvidence):
            return self._is_as_large(evidence)
        return super().is_same(evidence)

    @property
    def fingerprints(self) -> Mapping[str, str]:
        return {**super().fingerprints, "cameras": self.surface.cameras_fingerprint}

    @property
    def export_fields(self) -> Mapping[str, set[str]]:
        return {"video": {"path", "fingerprint"}, "surface": {"cameras_fingerprint"}}

    def refreshed_fields(self, now: Evidence) -> Fields:
        """Also the fingerprint of the cameras' file, where both have the same cameras."""
        fields = super().refreshed_fields(now)
        if not isinstance(now, SurfaceEvidence) or now.surface.cameras != self.surface.cameras:
            return fields
        fingerprints = {"cameras_fingerprint": now.surface.cameras_fingerprint}
        return {**fields, "surface": self.surface.model_copy(update=fingerprints)}

    def with_paths(self, moved: Callable[[str], str]) -> Fields:
        fields, cameras = super().with_paths(moved), self.surface.cameras
        if cameras is None:
            return fields
        return {**fields, "surface": self.surface.model_copy(update={"cameras": moved(cameras)})}


EVIDENCE_KINDS: tuple[type[Evidence], ...] = (SurfaceEvidence, FilmEvidence)
"""The first kind that fits a session is its evidence."""


def evidence_of(session: EvidenceSource) -> Evidence:
    """What the session's body is compared with."""
    candidates = (kind.of(session) for kind in EVIDENCE_KINDS)
    return next(evidence for evidence in candidates if evidence is not None)


def surface_of(session: EvidenceSource) -> Surface:
    """How the surfaces of a session are read; TypeError where it is not about such."""
    if session.view.surface is None:
        raise TypeError("the session is not about surfaces")
    return session.view.surface


class ByEvidence(Generic[T]):
    """A table with an entry for each kind of evidence.

    A kind without an entry uses that of its nearest base class.
    """

    def __init__(self, entry_of_kind: Mapping[type[Evidence], T]) -> None:
        self._known = entry_of_kind

    def of(self, session: EvidenceSource) -> T:
        """The entry for a session's evidence; TypeError where there is none."""
        kind = type(session.evidence)
        for base in kind.__mro__:
            if base in self._known:
                return self._known[base]
        raise TypeError(f"nothing is known here of {kind.__name__}")
