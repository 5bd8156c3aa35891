"""The product without its page: every action goes through the editor and the jobs of the real one.

What is done is noted as a person does it, with the mouse and the keyboard, and kept as a script.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bench.human.clips import Watched
from bench.human.counting import Kind, Ledger, Share
from keypose.app.document.open import OpenSession, edit_state
from keypose.app.editor.actions import Draft, Track
from keypose.app.editor.drafted import near_frames, newly_posed, with_learned
from keypose.app.editor.posing import Drag
from keypose.app.editor.shown import ShownPose, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.editor.update import Go, Switch, update
from keypose.app.jobs.draft import DraftClip
from keypose.app.jobs.job import Context, Report
from keypose.app.jobs.learn import learned
from keypose.app.jobs.track import Track as TrackJob
from keypose.app.jobs.track import found_in
from keypose.app.jobs.worker_cache import WorkerCache
from keypose.app.posing.gesture import GestureContext, Handle, Ring
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.turning import EDGE_ON, EDGE_RADIUS_M
from keypose.app.posing.vectors import across, any_across, cross, unit
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.errors import KeyposeError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.operations.lifting import lifter_for_drafts
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.pool import SegmentFinished, never
from keypose.tracker.video import Video


class Desk:
    """One person's session of a clip. `clip` is as they see it."""

    def __init__(self, clip: Watched, path: Path, *, fresh: bool) -> None:
        self.clip, self.ledger, self.script = clip, Ledger(), list[str]()
        self.video = Video.open(clip.video)
        self.opened = OpenSession(path, clip.session, self.video, fresh=fresh)
        self.state: EditorState = edit_state(self.opened)[0]
        self.tracks = True
        self._alone = False
        self._cache, self._threads = WorkerCache(), ThreadPoolExecutor(1)

    def close(self) -> None:
        self._threads.shutdown()
        with suppress(KeyposeError, OSError):
            self._cache.close()
        self.video.close()

    # --- what a person does

    def act(self, kind: Kind, why: str, *messages: Any) -> None:
        """Click, press or drag, and what comes of it."""
        self.ledger.note(kind, why, self._share(kind, messages))
        self.script.append(why)
        for message in messages:
            self._send(message)

    def _share(self, kind: Kind, messages: tuple[Any, ...]) -> Share:
        """Of the work that something is part of."""
        if any(isinstance(message, Switch) for message in messages):
            return "begin"
        goes = all(isinstance(message, Go) for message in messages)
        if goes and (messages or kind == "key"):
            return "looks"
        return "limbs" if self._alone else "keyframes"

    def judge(self) -> None:
        """Look whether the present frame is right."""
        self.ledger.note("judged", "judge a frame")

    @contextmanager
    def limbs_alone(self) -> Iterator[None]:
        """Drags key the limbs that they move; tracked is when the last of them is let go."""
        self._alone, tracks, self.tracks = True, self.tracks, False
        try:
            yield
        finally:
            self._alone, self.tracks = False, tracks
            self._live()

    def look(self, frame: int) -> None:
        """The page goes to a frame by itself."""
        self._send(Go(frame=frame))

    def turn(self, why: str, ring: Ring, deg: float) -> None:
        """Drag a ring of a part so that the part turns by so many degrees."""
        self.act("drag", why, self.as_turn(ring, deg))

    def as_turn(self, ring: Ring, deg: float) -> Drag:
        """A ring dragged by so many degrees, as the page sends it."""
        context = GestureContext.of(self.state.skeleton, self.shown().pose, True)
        part = self.state.doc.subject.body.index(ring.part)
        axis = context.R_camera_part(part)[:, "xyz".index(ring.axis)]
        view = PointerView.of(self.state.doc.view.camera)
        start, end = ring_way(view, context.joint(part), axis, np.radians(deg))
        return self.as_drag(ring, end - start, "main", start)

    def tried(self, *messages: Any) -> EditorState:
        """The state as it would be; nothing is done."""
        state = self.state
        for message in messages:
            state = update(state, message)
        return state

    def as_drag(
        self, handle: Handle, by: Array, view: str, start: ArrayLike = (0.0, 0.0), **how: Any
    ) -> Drag:
        """A handle dragged by a way in its view, as the page sends it."""
        given = {"view": view, "handle": handle, "from": _spot(start)}
        how |= {"partial": True} if self._alone else {}
        return Drag(**given, at=_spot(np.add(start, by)), **how)  # type: ignore[arg-type]

    # --- what a person sees

    @property
    def frame(self) -> int:
        return self.state.frame

    @property
    def keys(self) -> tuple[int, ...]:
        return self.state.keys

    def shown(self, frame: int | None = None) -> ShownPose:
        return shown_pose(self.state, frame)

    def off(self, frame: int | None = None, pose: Pose | None = None) -> dict[str, Array]:
        """How far (2,) pixels each joint that is seen lies from where the body has it."""
        frame = self.frame if frame is None else frame
        seen = self.clip.seen.get(frame, {})
        at = self.project(pose or self.shown(frame).pose)
        return {name: np.array(uv) - at[name] for name, uv in seen.items()}

    def project(self, pose: Pose) -> dict[str, Array]:
        """Where the joints that are looked at are drawn, pixels of the main view."""
        p = self.points(pose)
        uv = self.state.doc.view.camera.without_distortion().project(np.stack(list(p.values())))
        return dict(zip(p, uv, strict=True))

    def points(self, pose: Pose) -> dict[str, Array]:
        """The same, metres, camera frame."""
        places, skeleton = self.clip.places, self.state.skeleton
        points = BodyPoints(skeleton, tuple(places.values()))
        return dict(zip(places, points.at(pose_transforms(skeleton, pose)), strict=True))

    # --- what the computer does

    def _send(self, message: Any) -> None:
        match message:
            case Draft():
                self._draft(message)
            case Track():
                self._track()
            case _:
                before, self.state = self.state, update(self.state, message)
                self._live()
                self._learn(before)

    def _live(self) -> None:
        """With Live on, what is posed is tracked at once."""
        if self.state.display.live and self.tracks:
            self._track()

    def _learn(self, before: EditorState) -> None:
        """Drafts learn from a keyframe that is new."""
        around = newly_posed(before, self.state)
        if around:
            used = self.state.doc
            folder = self.opened.session_path.parent
            lifter = lifter_for_drafts(used, lambda: self.video.info.times_s)
            found = learned(near_frames(used, around), folder, around, lifter)
            self.state = with_learned(self.state, used, found)

    def _draft(self, action: Draft) -> None:
        job = DraftClip.of(self.opened, self.state, action)
        self.state = job.taken(
            job.run(self._context(ignored)), self.state, self.opened.session_path
        )

    def _track(self) -> None:
        """Whatever is not tracked as it is posed now, and the motion in space."""
        doc = self.state.doc
        wanted = self.state.results.wanted(doc)
        if not doc.spans:
            return
        if wanted:
            folder, stages = self.opened.session_path.parent, (doc.settings.quality,)
            job = TrackJob.of(doc, self.video.info.path, wanted, stages, folder)
            job.run(self._context(self._take))
        results = self.state.results
        for stretch in results.unsolved(doc):
            results = results.with_space(solved(doc, stretch))
        self.state = self.state.with_results(results)

    def _context(self, take: Callable[[Report], None]) -> Context:
        return Context(1, self._cache, self._threads, never, take)

    def _take(self, report: Report) -> None:
        found = found_in(report)
        if isinstance(found, SegmentFinished):
            results = self.state.results.with_result(found.result, self.state.results.by_key)
            self.state = self.state.with_results(results)


def ignored(report: Report) -> None:
    """Nobody looks how far a draft is."""


@contextmanager
def desk(clip: Watched, settings: TrackSettings) -> Iterator[Desk]:
    """A desk while it is needed, where a clip is begun."""
    session = clip.session.changed({"settings": settings})
    with TemporaryDirectory() as folder:
        path = Path(folder) / "session.json"
        with closing(Desk(replace(clip, session=session), path, fresh=True)) as made:
            yield made


@contextmanager
def desk_of(clip: Watched, path: Path) -> Iterator[Desk]:
    """A desk where the session of a clip goes on, which is saved at a path."""
    with closing(Desk(clip, path, fresh=False)) as made:
        yield made


def _spot(at: ArrayLike) -> tuple[float, float]:
    x, y = np.asarray(at, dtype=np.float64).tolist()
    return x, y


def ring_way(view: PointerView, centre: Array, axis: Array, angle: float) -> tuple[Array, Array]:
    """Where a pointer goes down on a ring and where it is let go, (2,) each, to turn it by an angle
    of less than half a turn; the way round that `turning.pointer_angle` reads."""
    middle, slope = view.project(centre), view.slope(centre)
    away = view.ray_through(centre)
    if abs(float(axis @ away)) < EDGE_ON:
        tangent = slope @ cross(axis, unit(across(-away, axis)))
        return middle, middle + tangent * (angle * EDGE_RADIUS_M)
    e1 = any_across(axis)
    to_view = slope @ np.column_stack([e1, cross(axis, e1)]) * EDGE_RADIUS_M
    ends = [middle + to_view @ (np.cos(a), np.sin(a)) for a in (0.0, angle)]
    return ends[0], ends[1]
