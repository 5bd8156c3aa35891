"""From a path a person gave to a session with its video: opened, or begun."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from keypose.app.document.edit_log import Beginning
from keypose.app.document.new import (
    new_session,
    new_surface_session,
    path_from,
    require_text,
    standing_in,
)
from keypose.app.editor.documents import with_times
from keypose.app.editor.frames import first_pose
from keypose.app.editor.known import KnownMotion
from keypose.app.editor.state import EditorState
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SessionError
from keypose.tracker.files import read_regular
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.session.history import History
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.edit_history import OUTSIDE, is_same_film, of_film, without_results
from keypose.tracker.storage.evidence import surfaces_of
from keypose.tracker.storage.files import (
    LARGEST_SESSION_BYTES,
    Opened,
    journal_path,
    load_session,
    open_session,
    open_video_at,
    open_video_of,
    save_session,
    video_path,
    with_present_fingerprints,
)
from keypose.tracker.storage.results import load_all_results
from keypose.tracker.storage.sidecars import OwnMotion, carry_beside
from keypose.tracker.surface.new_session import Reading
from keypose.tracker.surface.source import holds_meshes
from keypose.tracker.video import Video


@dataclass(frozen=True, eq=False)
class OpenSession:
    """A session, the file it is saved in, and its video; `fresh` when it was begun just now.

    history: what can be undone and done again since another day.  journal: where it stands.
    news:    what a person has to know of it, in sentences.
    """

    session_path: Path
    session: Session
    video: Video
    fresh: bool
    history: History = field(default_factory=History)
    journal: Beginning = field(default_factory=Beginning)
    news: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """What it is called where a person has not said so: as its folder, or its video."""
        folder = self.session_path.parent.name
        return folder.removesuffix(".keypose") or self.video.info.path.stem

    def is_same(self, other: OpenSession) -> bool:
        """Whether both are saved in one file."""
        return _is_one_file(self.session_path, other.session_path)

    def is_stale(self) -> bool:
        """Whether its files have been written to since they were read."""
        return _content(self.session_path) != self.journal.content or (
            _length(journal_path(self.session_path)) != self.journal.length
        )

    def film(self) -> str:
        """Equal for the same video only; reads a little of the file."""
        return self.session.view.video.fingerprint or self.video.fingerprint()


def open_for_editing(path: Path, session_for: Callable[[Path], Path]) -> OpenSession:
    """Open a session file, or a video or meshes with the session that belongs to them.

    `session_for` returns the path of a video's session; where none exists yet, one is begun.
    KeyposeError in one sentence when it cannot be opened.
    """
    require_text(path.absolute())
    if path.suffix.lower() == ".json":
        return _open(path)
    if path.is_dir() and (path / "session.json").is_file():
        return _open(path / "session.json")
    if not path.exists():
        raise SessionError(f"There is no file {str(path)!r}.")
    if holds_meshes(path):
        return _with_meshes(path, session_for)
    video = Video.open(path)
    try:
        session_path = session_for(video.info.path)
        if not session_path.exists():
            return OpenSession(session_path, new_session(video, session_path), video, fresh=True)
    except BaseException:
        video.close()
        raise
    video.close()
    return _open(session_path)


def _with_meshes(path: Path, session_for: Callable[[Path], Path]) -> OpenSession:
    """The same of observed surfaces."""
    session_path = session_for(path)
    if session_path.exists():
        return _open(session_path)
    session, news = new_surface_session(path, session_path, Reading())
    video = open_video_at(session, path, session_path.parent)
    return OpenSession(session_path, session, video, fresh=True, news=news)


def edit_state(opened: OpenSession) -> tuple[EditorState, str]:
    """What the page starts from: the session at its first keyframe, with its tracked motion.

    And a sentence where that cannot be read, for the keyframes are worth more than the motion.
    """
    session = opened.session
    results, error = load_all_results(session, opened.session_path)
    problem = f"{error} The keyframes are all there: track again." if error else ""
    opening = first_pose(session)
    state = EditorState(
        doc=without_results(session),
        skeleton=Skeleton.of(session.subject.body),
        file_times_s=opened.video.info.times_s,
        opening=_STANDING.of(session)(opening, session.subject.body, opened.video),
        motion=KnownMotion(results),
        history=opened.history,
        frame=session.subject.keyframes[0].frame if session.subject.keyframes else 0,
        selected=session.subject.body.parts[0].name,
        timecode=opened.video.info.timecode,
    )
    return with_own_motion(state, opened.session_path), problem


def with_own_motion(state: EditorState, session_path: Path) -> EditorState:
    """The state with the motion from before it was reduced, as the document names it; without one
    where that cannot be read: tracking, which starts from it, says why."""
    own_motion = None
    with suppress(SessionError):
        own_motion = OwnMotion.of(state.doc, session_path.parent)
    return replace(state, own_motion=own_motion)


def _where_it_opens(opening: Pose, _body: Body, _video: Video) -> Pose:
    return opening


def _in_the_surface(opening: Pose, body: Body, video: Video) -> Pose:
    return standing_in(opening, body, surfaces_of(video).steps)


_STANDING = ByEvidence({FilmEvidence: _where_it_opens, SurfaceEvidence: _in_the_surface})
"""Where a body starts before it is posed."""


def _open(path: Path) -> OpenSession:
    path = Path(os.path.realpath(path))  # journal and lock lie beside the file, not beside a link
    content = _content(path)
    opened = open_session(path)
    session, recovered = opened.session, opened.recovered
    journal, follows = opened.journal, recovered.follows and opened.journal.whole
    video = open_video_of(session, path)
    moment, news = recovered.moment, _news(opened)
    if not _is_one_file(video_path(session, path), video.info.path):
        place = path_from(video.info.path, path.parent)
        session = session.changed({"video": session.view.video.model_copy(update={"path": place})})
        moment = of_film(moment, session)
        news = (*news, f"The {session.evidence.words.noun_was} found again at {place}.")
    refreshed = with_present_fingerprints(session, path, video)
    if refreshed is not session:
        news = (*news, *_exported_again(session, refreshed))
        session, moment = refreshed, of_film(moment, refreshed)
    timed = _timed(session, video)
    if timed is not session:  # a new keyframe's time would not stand between the others'
        session, follows = timed, False
        moment = moment.each(lambda doc: _timed(doc, video))
    return OpenSession(
        path,
        session,
        video,
        fresh=False,
        history=moment.history,
        journal=Beginning(journal.size, follows, content, journal.length, moment.received),
        news=news,
    )


def _exported_again(before: Session, now: Session) -> tuple[str, ...]:
    """What has changed beside a session, if it was known before."""
    fingerprints_before, there = before.evidence.fingerprints, now.evidence.fingerprints
    others = [
        evidence_name
        for evidence_name, was in fingerprints_before.items()
        if was not in ("", there[evidence_name])
    ]
    if not others:
        return ()
    return (
        f"The {' and '.join(others)} have changed since they were last opened: "
        f"{now.evidence.words.verb} again.",
    )


def _timed(doc: Session, video: Video) -> Session:
    return with_times(doc, doc.evidence.times_s(video.info.times_s))


def _is_one_file(first: Path, second: Path) -> bool:
    return os.path.realpath(first) == os.path.realpath(second)


def _content(path: Path) -> bytes:
    try:
        return read_regular(path, LARGEST_SESSION_BYTES)
    except OSError:
        return b""


def _length(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _news(opened: Opened) -> tuple[str, ...]:
    recovered = opened.recovered
    if opened.problem:
        return (f"{opened.problem} Earlier undo steps are lost.",)
    if not opened.journal.whole:
        return ("The journal of edits is damaged: some undo steps may be missing.",)
    if recovered.ahead:
        edits = "one edit" if recovered.ahead == 1 else f"{recovered.ahead} edits"
        return (f"Restored {edits} made before Keypose ended unexpectedly.",)
    past = recovered.moment.history.past
    if not recovered.follows and past and past[-1].label == OUTSIDE:
        return ("The session was changed outside this page; undo brings back how you left it.",)
    return ()


def copy_session(path: Path, out: Path) -> Path:
    """A session of one's own in a folder: made when it is not there yet, else as it was left."""
    target = out / "session.json"
    session = load_session(path)
    if target.exists():
        if not is_same_film(load_session(target), session):
            raise SessionError(f"{str(out)!r} holds the session of another video; choose another.")
        return target
    make_folder(out)
    carry_beside(session, path.parent, out)
    save_session(with_paths_from(session, path, out).changed({"results": None}), target)
    return target


def with_paths_from(session: Session, session_path: Path, folder: Path) -> Session:
    """The session as it reads in another folder: paths that were relative lead from there."""

    def from_there(path: str) -> str:
        place = session_path.absolute().parent / path
        return str(place) if Path(path).is_absolute() else path_from(place, folder)

    there = session.changed(session.evidence.with_paths(from_there))
    others = (
        view.model_copy(update=session.alone(view.id).evidence.with_paths(from_there))
        for view in session.views[1:]
    )
    return there.model_copy(update={"views": (there.view, *others)})
