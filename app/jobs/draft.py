"""Draft a pose of every frame of a clip from a box around the person on one of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from keypose.app.editor.drafted import (
    LABEL,
    drafted_session,
    drafting_model,
    frame_runs,
    frames_of,
    keeps_proportions,
    keypoint_source,
    require_draftable,
    require_rest,
)
from keypose.app.editor.shown import shown_pose
from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.job import Context
from keypose.app.jobs.progress import seconds_left
from keypose.tracker.body.pose import joint_positions, pose_transforms
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.detect import ANIMAL, PERSON, STRETCH, DetectionWindow, Seed
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.on_animal import is_animals
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.keypoints.region import Box, require_apart
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import DraftRest as DraftLeft
from keypose.tracker.session.annotations import FrameRun
from keypose.tracker.session.settings import Position
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.fingerprints import needs_masks
from keypose.tracker.storage.pace import NETWORK_SHARE, keep_seconds_a_frame
from keypose.tracker.storage.sidecars import keypoints_of_session, save_keypoints
from keypose.tracker.tracking.pool import Cancelled, never
from keypose.tracker.video import Video
from keypose.tracker.video.info import MissingFrame

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import Draft, DraftRest
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState
    from keypose.tracker.body.pose import Pose
    from keypose.tracker.fitting.draft import ClipDraft, DraftProgress

FEWEST_KEPT = STRETCH
"""A draft that is cancelled keeps what it has found from so many frames on."""


PERCENT_OF_FRAMES = 1000
"""Of more frames a per cent is so many that a tenth of it is shown, too."""
FRAMES_BETWEEN = 10
"""Frames from one report of progress to the next, at most."""


class Drafted(NamedTuple):
    """The drafts, the fingerprint of the network, and first and last of the frames whose keypoints
    were detected: None where these are all."""

    draft: ClipDraft
    network: str
    detected: tuple[int, int] | None = None


@dataclass
class DraftReporter:
    """Passes progress on, once for every further per cent of the whole or ten frames, whichever is
    less, and leaves when cancelled.

    A stage may find out that there is more to do: meanwhile nothing is reported.
    """

    report: Callable[[DraftProgress], None]
    cancelled: Callable[[], bool]
    reported: float = -1.0
    frames: int = 0

    def __call__(self, progress: DraftProgress) -> None:
        if self.cancelled():
            raise Cancelled
        share, _ = progress_of(progress)
        is_more = share > self.reported
        self.frames = min(self.frames, progress.done)  # the next stage counts anew
        is_due = share >= self.reported + 0.01 or progress.done >= self.frames + FRAMES_BETWEEN
        if is_more and (is_due or share >= 1):
            self.reported, self.frames = share, progress.done
            self.report(progress)

    def not_cancelled(self) -> DraftReporter:
        """For what is done once it is cancelled."""
        return DraftReporter(self.report, never)


@dataclass
class _Detected:
    """The frames whose keypoints were detected: backward from the one of the box, then forward."""

    video: Video
    at: int
    first: int
    last: int
    began: float
    count: int = 0

    @classmethod
    def of(cls, video: Video, at: int) -> _Detected:
        return cls(video, at, at, at, time.monotonic())

    def picture(self, number: int) -> NDArray[np.uint8] | None:
        """A frame to look at."""
        self.first, self.last = min(self.first, number), max(self.last, number)
        self.count += 1
        return _frame(self.video, number)

    def keep_pace(self, network: str) -> None:
        """Keep how long a frame took, where enough were detected to say so."""
        if self.count >= FEWEST_KEPT:
            seconds = (time.monotonic() - self.began) / NETWORK_SHARE
            keep_seconds_a_frame(network, seconds / self.count)

    def kept(self, frames: tuple[int, int], reported: DraftReporter) -> tuple[int, int] | None:
        """First and last of the frames whose keypoints are kept, when it is left here; None where
        these are too few to pose, or poses were found already."""
        if reported.reported >= NETWORK_SHARE:
            return None
        if self.last > self.at:
            kept_frames = frames[0], self.last // STRETCH * STRETCH
        else:
            kept_frames = -(-self.first // STRETCH) * STRETCH, self.at
        return kept_frames if kept_frames[1] - kept_frames[0] + 1 >= FEWEST_KEPT else None


def drafted(
    session: Session,
    video: Video,
    at: int,
    box: Box,
    frames: tuple[int, int],
    *,
    proportions: bool,
    report: Callable[[DraftProgress], None],
    cancelled: Callable[[], bool] = never,
) -> Drafted:
    """Drafts of these frames, first and last; see `draft_clip`.

    Cancelled where it was left; but where enough keypoints were detected by then these frames
    are posed, and reported on the way.
    """
    (draft,) = drafted_people(
        session,
        video,
        at,
        [box],
        frames,
        proportions=proportions,
        report=report,
        cancelled=cancelled,
    )
    return draft


def drafted_people(
    session: Session,
    video: Video,
    at: int,
    boxes: Sequence[Box],
    frames: tuple[int, int],
    *,
    proportions: bool,
    report: Callable[[DraftProgress], None],
    cancelled: Callable[[], bool] = never,
) -> list[Drafted]:
    """The same of several people in boxes on one frame, in their order, cancelled likewise; animals
    are followed each by itself, and of more than one Cancelled wherever it was left."""
    require_apart(boxes, at)
    reporter = DraftReporter(report, cancelled)
    find_drafts = _drafted_animals if is_animals(session.subject.body) else _drafted_persons
    return find_drafts(session, video, at, boxes, frames, proportions, reporter)


def _drafted_persons(
    session: Session,
    video: Video,
    at: int,
    boxes: Sequence[Box],
    frames: tuple[int, int],
    proportions: bool,
    report: DraftReporter,
) -> list[Drafted]:
    """The drafts of people, who are followed together."""
    from keypose.tracker.fitting.draft import (  # loads what only this needs
        draft_from_keypoints,
        draft_people,
    )
    from keypose.tracker.keypoints.detectors import open_detector
    from keypose.tracker.keypoints.model_files import find_model
    from keypose.tracker.keypoints.people import detect_people
    from keypose.tracker.operations.lifting import lifter_for_drafts
    from keypose.tracker.storage.cache import Detections

    name, camera, body = session.settings.network_used, session.view.camera, session.subject.body
    model = find_model(name)
    network = open_detector(model)
    detected = _Detected.of(video, at)
    film, kept = session.view.video.pictures, Detections()
    half = not needs_masks(session) and model.skips_frames_at(video.info.fps)
    lifter = lifter_for_drafts(session, lambda: video.info.times_s)
    up_world, path = session.world.up_world, session.camera_path
    try:
        drafts = draft_people(
            detected.picture,
            frames,
            at,
            boxes,
            camera,
            body,
            network,
            again=network.plain,
            proportions=proportions,
            up_world=up_world,
            path=path,
            lifter=lifter,
            report=report,
            film=film,
            kept=kept,
            every_second=half,
        )
        part = None
    except Cancelled:
        part = detected.kept(frames, report)
        if part is None:
            raise
        seeds = [[Seed.of_box(at, box, camera.width, camera.height)] for box in boxes]
        people = detect_people(
            detected.picture, part, seeds, network, film=film, kept=kept, every_second=half
        )
        drafts = [
            draft_from_keypoints(
                keypoints,
                camera,
                body,
                proportions=proportions,
                up_world=up_world,
                path=path,
                lifter=lifter,
                report=report.not_cancelled(),
            )
            for keypoints in people
        ]
    if len(boxes) == 1:
        detected.keep_pace(name)
    return [Drafted(_outlined(each, session), network.fingerprint, part) for each in drafts]


def _drafted_animals(
    session: Session,
    video: Video,
    at: int,
    boxes: Sequence[Box],
    frames: tuple[int, int],
    proportions: bool,
    report: DraftReporter,
) -> list[Drafted]:
    """The drafts of animals, each followed by itself."""
    from keypose.tracker.fitting.draft import draft_animal  # loads what only this needs
    from keypose.tracker.keypoints.detectors import open_animal_detector

    model, camera = drafting_model(session), session.view.camera
    network, detected = open_animal_detector(model), _Detected.of(video, at)
    seeds = [Seed.of_box(at, box, camera.width, camera.height) for box in boxes]
    draft = partial(
        draft_animal,
        detected.picture,
        camera=camera,
        body=session.subject.body,
        network=network,
        proportions=proportions,
        up_world=session.world.up_world,
        path=session.camera_path,
        film=session.view.video.pictures,
        kept=_KeptHere(),
    )
    try:
        drafts = [draft(frames, seed, report=report) for seed in seeds]
        part = None
    except Cancelled:
        part = detected.kept(frames, report)
        if part is None or len(seeds) > 1:
            raise
        drafts = [draft(part, seed, report=report.not_cancelled()) for seed in seeds]
    if len(boxes) == 1:
        detected.keep_pace(model.name)
    return [Drafted(each, network.fingerprint, part) for each in drafts]


class _KeptHere:
    """What a network of animals saw, for as long as it is drafted; there are no masks to store."""

    def __init__(self) -> None:
        self._stretches: dict[str, DetectionWindow] = {}

    def get(self, key: str) -> DetectionWindow | None:
        return self._stretches.get(key)

    def put(self, key: str, stretch: DetectionWindow) -> None:
        self._stretches[key] = stretch


def _frame(video: Video, number: int) -> NDArray[np.uint8] | None:
    """A picture of the film; None where it has lost it."""
    try:
        return video.frame(number)
    except MissingFrame:
        return None


def _outlined(draft: ClipDraft, session: Session) -> ClipDraft:
    """The draft, with what the session's segments need of the person's masks: their outlines, or
    nothing."""
    keypoints, masks = draft.keypoints, None
    if keypoints.masks is not None and needs_masks(session):
        masks = tuple(mask and mask.outlined() for mask in keypoints.masks)
    return replace(draft, keypoints=replace(keypoints, masks=masks))


KNOWN: Final = ("keyframe", "draft", "tracked", "between")
"""Where a pose comes from that says where a person is."""
LEAST_BOX_PX: Final = 8.0
"""A body of which less is in the picture is nobody to mistake."""


@dataclass(frozen=True)
class DraftClip(Fit):
    """frame, box: the frame of the box, and left, top, right, bottom in pixels.

    frames: first and last to draft.
    proportions: whether the body's limbs may be scaled to the person's.
    up_camera: what is known to be up; drafts stay where that changes meanwhile.
    rest: runs of the frames to take over, where an earlier draft has left them; None: all.
    others: boxes around more people, each of whom becomes a body.  beside: around the bodies that
        are there already, so that nobody is taken for one of them.
    """

    frame: int
    box: Box
    frames: tuple[int, int]
    proportions: bool
    up_camera: Position | None = None
    rest: tuple[FrameRun, ...] | None = None
    others: tuple[Box, ...] = ()
    beside: tuple[Box, ...] = ()

    asked = ("draft", "draft_rest")
    kind = "draft"
    title = "Drafting poses"
    needs_loops = False  # before the last tenth of it
    keeps_found = True
    why_cancelled = "Draft cancelled because the body, the camera or a keyframe changed."
    not_of_surfaces = "Drafts are made from a video, not from surfaces."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: Draft | DraftRest) -> Self:
        doc, last = edit.doc, edit.frame_count - 1
        work_inputs = sent(opened, doc, keyframes=())
        if action.do == "draft_rest":
            rest = require_rest(doc)
            ends = rest.frames[0].first_frame, rest.frames[-1].last_frame
            frames = min(rest.frame, ends[0]), max(rest.frame, ends[1])
            only = cls(
                *work_inputs, rest.frame, rest.box, frames, False, doc.world.up_world, rest.frames
            )
            return replace(only, beside=boxes_beside(edit, rest.frame))
        frames = (action.first or 0, last if action.last is None else action.last)
        for box in (action.box, *action.others):
            require_draftable(doc, action.frame, box, frames)
        box, proportions = action.box, not keeps_proportions(doc)
        only = cls(*work_inputs, action.frame, box, frames, proportions, doc.world.up_world)
        beside = boxes_beside(edit, action.frame)
        return replace(only, others=action.others, beside=beside)

    def work(self, session: Session, context: Context) -> list[Drafted]:
        began = time.monotonic()
        noun = (ANIMAL if is_animals(session.subject.body) else PERSON).noun

        def report(progress: DraftProgress) -> None:
            share, words = progress_of(progress, noun)
            left = seconds_left(time.monotonic() - began, share)
            context.report(share, words, seconds_left=left)

        people = drafted_people(
            session,
            context.cache.video(session, self.video_path),
            self.frame,
            (self.box, *self.others, *self.beside),
            self.frames,
            proportions=self.proportions,
            report=report,
            cancelled=context.cancelled,
        )
        return people[: 1 + len(self.others)]

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return doc.subject.body, *filmed_by(doc), doc.view.surface, doc.subject.keyframes

    def apply(self, result: list[Drafted], state: AppState) -> tuple[AppState, str]:
        assert state.opened is not None
        after = self.taken(result, state.editing, Path(state.opened.session_path))
        return replace(state, edit=after, draft=after.doc), ""

    def taken(self, result: Sequence[Drafted], edit: EditorState, path: Path) -> EditorState:
        """The state with the drafts, each person's keypoints written beside the session;
        KeyposeError where that is not possible. path: of the session's file."""
        make_folder(path.parent, error=KeypointError)  # a new film's is there from its first edit
        posed, (first, *more) = edit.doc.subject, result
        together = len(result) + len(self.beside) > 1
        doc = self._with_drafts(edit.doc, first, self.box, edit.times_s, path, together)
        for box, each in zip(self.others, more, strict=True):
            doc, added = doc.with_new_body(posed.body, posed.body.name)
            doc = self._with_drafts(doc.about(added.id), each, box, edit.times_s, path, together)
        return edit.with_step(doc.about(posed.id), LABEL)

    def _with_drafts(
        self, doc: Session, result: Drafted, box: Box, times_s: Array, path: Path, together: bool
    ) -> Session:
        """The session with the drafts of the body that is posed."""
        draft, network, detected = result
        first, last = self.frames
        asked = range(first, last + 1) if self.rest is None else frames_of(self.rest)
        only, rest = taken_and_left(asked, detected, self.frame, box)
        seeds, keypoints = {self.frame}, draft.keypoints
        before = _keypoints_before(doc, path, network)
        if before is not None and doc.view.keypoints is not None:
            seeds |= set(doc.view.keypoints.seeds)
            keypoints = before.overlaid(keypoints)
        referring = save_keypoints(
            doc,
            path,
            keypoints,
            keypoint_source(doc),
            network=network,
            seeds=tuple(seeds),
            together=together,
        )
        return drafted_session(
            doc,
            self.frames,
            draft.body,
            draft.poses,
            referring.view.keypoints,
            draft.proposals,
            times_s,
            self.up_camera,
            only,
            rest,
            draft.flipped,
        )


def boxes_beside(edit: EditorState, frame: int) -> tuple[Box, ...]:
    """Around the people that are posed at a frame already, but the one that is posed: none where
    that is an animal, which a network of animals takes for no person."""
    if is_animals(edit.doc.subject.body):
        return ()
    boxes = []
    for body in edit.doc.bodies:
        if body.id == edit.doc.subject.id or not is_persons(body.body):
            continue
        alone = edit.about(body.id)
        shown = shown_pose(alone, frame)
        if shown.source in KNOWN:
            boxes.append(_box_around(alone, shown.pose, frame))
    return tuple(box for box in boxes if box is not None)


def _box_around(edit: EditorState, pose: Pose, frame: int) -> Box | None:
    """What is seen of a body in the film; None where it is not within the picture."""
    camera = edit.doc.film_camera.at(frame)
    joints = joint_positions(edit.skeleton, pose_transforms(edit.skeleton, pose))
    uv = camera.project(joints)
    size = np.array([camera.width, camera.height]) - 0.5
    low, high = np.clip(uv.min(axis=0), -0.5, size), np.clip(uv.max(axis=0), -0.5, size)
    if (high - low).min() < LEAST_BOX_PX:
        return None
    left, top, right, bottom = np.concatenate([low, high]).tolist()
    return left, top, right, bottom


def taken_and_left(
    asked: Iterable[int], detected: tuple[int, int] | None, at: int, box: Box
) -> tuple[list[int], DraftLeft | None]:
    """Of the frames asked for those to take over, and what is left to draft, where these, first and
    last, were detected; None where all were."""
    asked = list(asked)
    start, end = detected or (min(asked), max(asked))
    left = tuple(frame_runs(frame for frame in asked if not start <= frame <= end))
    rest = DraftLeft(frame=at, box=box, frames=left) if left else None
    return [frame for frame in asked if start <= frame <= end], rest


def progress_of(progress: DraftProgress, noun: str = PERSON.noun) -> tuple[float, str]:
    """The share and words. The network takes most of the time. noun: who is looked for."""
    share = progress.done / max(progress.expected, 1)
    if progress.stage == "keypoints":  # at frames from before and from after them, some twice
        digits = 0 if progress.expected <= PERCENT_OF_FRAMES else 1
        return NETWORK_SHARE * share, f"Looking for the {noun}: {100 * share:.{digits}f} %"
    words = f"Posing: {progress.done} of {progress.expected} frames"
    return NETWORK_SHARE + (1 - NETWORK_SHARE) * share, words


def _keypoints_before(doc: Session, path: Path, network: str) -> Keypoints | None:
    """What the same network found for an earlier draft, perhaps of other frames."""
    if doc.view.keypoints is None or doc.view.keypoints.network != network:
        return None
    with suppress(KeypointError):  # they are found again when needed
        return keypoints_of_session(doc, path.parent)
    return None
