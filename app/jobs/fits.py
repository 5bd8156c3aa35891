"""Run one order to fit: a pose, the sizes, or drafts of a whole clip by the bundled network."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from keypose.app.jobs.messages import (
    AheadOrder,
    Drafted,
    Drafting,
    DraftOrder,
    FitOrder,
    Fitted,
    FollowedAhead,
    FollowingAhead,
    JobFailed,
    JobFinished,
    Learned,
    LearnOrder,
    PoseFitted,
    PoseOrder,
    Reduced,
    ReduceOrder,
    Reducing,
    Report,
    SizesFitted,
    SizesOrder,
)
from keypose.app.jobs.wire import failure_message
from keypose.app.jobs.work import WorkerCache
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SurfaceError, one_sentence
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session import Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.storage import sidecars
from keypose.tracker.video import Video
from keypose.tracker.video.info import MissingFrame

if TYPE_CHECKING:
    from keypose.tracker.fitting.draft import ClipDraft, DraftProgress


class DraftLeft(Exception):
    """Raised within a draft that somebody cancelled."""


@dataclass
class DraftReporter:
    """Passes progress on, once for every whole number of per cent, and leaves when cancelled."""

    report: Callable[[DraftProgress], None]
    cancelled: Callable[[], bool]
    reported: tuple[str, int] = ("", -1)

    def __call__(self, progress: DraftProgress) -> None:
        if self.cancelled():
            raise DraftLeft
        now = (progress.stage, 100 * progress.done // max(progress.expected, 1))
        if now != self.reported:
            self.reported = now
            self.report(progress)


def drafted(
    session: Session,
    video: Video,
    at: int,
    box: Box,
    frames: tuple[int, int],
    *,
    proportions: bool,
    report: Callable[[DraftProgress], None],
) -> tuple[ClipDraft, str]:
    """Drafts of these frames, first and last, and the network's fingerprint; see `draft_clip`."""
    from keypose.tracker.fitting.draft import draft_clip  # loads what only this needs
    from keypose.tracker.keypoints.augmented import AugmentedNetwork
    from keypose.tracker.keypoints.model_files import FULL, find_model
    from keypose.tracker.storage.cache import Detections

    def picture(number: int) -> NDArray[np.uint8] | None:
        try:
            return video.frame(number)
        except MissingFrame:
            return None

    network = AugmentedNetwork.open(find_model(session.settings.network or FULL.name))
    found = draft_clip(
        picture, frames, at, box, session.camera, session.body, network,
        again=network.plain, proportions=proportions, report=report,
        film=session.video.pictures, kept=Detections(),
    )  # fmt: skip
    return found, network.fingerprint


def learned(session: Session, folder: Path, around: Collection[int]) -> Mapping[int, Pose]:
    """The drafts near some keyframes with what all keyframes there give of the keypoints; none
    where the keypoints are not beside the session any more. folder: of the session's file."""
    from keypose.tracker.fitting.draft import refit_drafts  # loads what only this needs
    from keypose.tracker.storage.sidecars import keypoints_of_session

    skeleton, keypoints = Skeleton.of(session.body), keypoints_of_session(session, folder)
    if keypoints is None:
        return {}
    keypoints = keypoints.corrected(session.keypoint_corrections)
    drafts = {d.frame: d.pose(skeleton) for d in session.drafts if d.drafted}
    posed = {k.frame: k.pose(skeleton) for k in session.keyframes}
    places = session.drafted.places if session.drafted else ()
    changes = [place.frame for place in places if place.reason == "person"]
    return refit_drafts(keypoints, session.camera, session.body, drafts, posed, around, changes)


Send = Callable[[Report], None]
Found: TypeAlias = Fitted | Learned

_FAULT = "Fitting failed with an internal error ({}). Nothing was changed."


class FitJob:
    """An order at work. Soon after `cancelled` is set it is left, and reports nothing it found."""

    def __init__(self, order: FitOrder, cancelled: Event, send: Send) -> None:
        self.order = order
        self._cancelled = cancelled
        self._send = send

    def run(self, worker_cache: WorkerCache) -> None:
        """Do the work and report how it ended."""
        job = self.order.job
        try:
            fitted = self._fit(worker_cache)
        except DraftLeft:
            self._send(JobFinished(job, cancelled=True))
        except ValidationError as error:
            self._send(JobFailed(job, one_sentence(error)))
        except Exception as error:  # noqa: BLE001 — a fault, reported as such
            self._send(JobFailed(job, failure_message(error, _FAULT)))
        else:
            keeps = isinstance(fitted, FollowedAhead)  # what was found until then
            cancelled = self._cancelled.is_set() and not keeps
            self._send(JobFinished(job, cancelled=True) if cancelled else fitted)

    def _fit(self, worker_cache: WorkerCache) -> Found:
        session = Session.model_validate_json(self.order.session)
        return _FITS.of(session)(self, self.order, session, worker_cache)

    def on_film(self, order: FitOrder, session: Session, worker_cache: WorkerCache) -> Found:
        """A pose or the sizes fitted to pictures, or a clip drafted."""
        if isinstance(order, LearnOrder):
            found = learned(session, Path(order.folder), order.around)
            return Learned(order.job, found)
        if isinstance(order, AheadOrder):
            return self._ahead(order, session, worker_cache)
        if isinstance(order, ReduceOrder):
            return self._reduce(order, session)
        video = worker_cache.video(session, order.video_path)
        if isinstance(order, PoseOrder):
            return self._pose(order, session, video)
        if isinstance(order, DraftOrder):
            return self._draft(order, session, video)
        return self._sizes(order, session, video)

    def on_surfaces(self, order: FitOrder, session: Session, worker_cache: WorkerCache) -> Found:
        """A pose fitted to the surface of its frame; SurfaceError where sizes are asked for."""
        if isinstance(order, DraftOrder | LearnOrder):
            raise SurfaceError("Drafts are made from a video, not from surfaces.")
        if isinstance(order, AheadOrder):
            raise SurfaceError("Surfaces are fitted from one keyframe on: press Fit.")
        if isinstance(order, ReduceOrder):
            raise SurfaceError("Only the motion of a video is reduced, not that of surfaces.")
        if isinstance(order, SizesOrder):
            raise SurfaceError(
                "Sizes are fitted to pictures, not to surfaces: set them in Body, by what you see."
            )
        # loads what only this needs
        from keypose.tracker.surface.fit.fitter import fit_pose_to_surface, fit_solids_to_surface

        path, folder, model = order.video_path, Path(order.folder), session.model_keyframe
        if model is None or model.frame == order.frame:
            mesh = worker_cache.surfaces(session, path, folder).mesh(order.frame)
            found = fit_solids_to_surface(mesh, Skeleton.of(session.body), order.pose)
        else:
            fitter = worker_cache.fitter(session, path, folder)
            found = fit_pose_to_surface(fitter, order.frame, order.pose)
        return PoseFitted(order.job, found.pose, True, found.message)

    def _pose(self, order: PoseOrder, session: Session, video: Video) -> PoseFitted:
        from keypose.tracker.fitting.pose import fit_pose_to_picture  # loads what only this needs
        from keypose.tracker.storage.tracking import keypoint_source

        skeleton = Skeleton.of(session.body)
        others = {k.frame: k.pose(skeleton) for k in session.keyframes if k.frame != order.frame}
        source = keypoint_source(
            session, video, sidecars.keypoints_of_session(session, Path(order.folder))
        )
        found = fit_pose_to_picture(
            video, session.camera, skeleton, order.frame, order.pose, others, order.tracked,
            masks=session.ignore_masks, cancelled=self._cancelled.is_set, source=source,
        )  # fmt: skip
        return PoseFitted(order.job, found.pose, found.way != "nothing", found.message)

    def _sizes(self, order: SizesOrder, session: Session, video: Video) -> SizesFitted:
        from keypose.tracker.fitting.sizes import fit_sizes  # loads what only this needs

        skeleton = Skeleton.of(session.body)
        keyposes = {k.frame: k.pose(skeleton) for k in session.keyframes}
        found = fit_sizes(
            video, session.camera, session.body, keyposes, focal=order.focal,
            masks=session.ignore_masks, cancelled=self._cancelled.is_set,
            up=session.up_camera,
        )  # fmt: skip
        given = (found.error_px, found.alone, found.with_poses, found.unseen)
        return SizesFitted(order.job, found.message, *given)

    def _ahead(
        self, order: AheadOrder, session: Session, worker_cache: WorkerCache
    ) -> FollowedAhead:
        from keypose.tracker.tracking.ahead.follow import (  # what only this needs
            LONGEST,
            follow_ahead,
        )
        from keypose.tracker.tracking.pool import Cancelled

        folder = Path(order.folder)
        tracker = worker_cache.follower(session, order.video_path, folder)

        def emit(motion: Trajectory) -> None:
            if self._cancelled.is_set():
                raise Cancelled
            self._send(FollowingAhead(order.job, order.frame, motion, LONGEST))

        found = follow_ahead(tracker, order.frame, order.direction, session.settings, emit)
        return FollowedAhead(order.job, found)

    def _reduce(self, order: ReduceOrder, session: Session) -> Reduced:
        from keypose.tracker.reduction.reduce import reduce_motion  # loads what only this needs

        reported = -1

        def report(done: int, expected: int) -> None:
            nonlocal reported
            if self._cancelled.is_set():
                raise DraftLeft
            if 100 * done // expected != reported:
                reported = 100 * done // expected
                self._send(Reducing(order.job, done, expected))

        found, skeleton = order.found, Skeleton.of(session.body)
        given = (found.motion, order.goal, found.required, found.parts)
        return Reduced(order.job, reduce_motion(skeleton, session.camera, *given, report))

    def _draft(self, order: DraftOrder, session: Session, video: Video) -> Drafted:
        def report(progress: DraftProgress) -> None:
            self._send(Drafting(order.job, progress.stage, progress.done, progress.expected))

        draft, network = drafted(
            session, video, order.frame, order.box, order.frames,
            proportions=order.proportions, report=DraftReporter(report, self._cancelled.is_set),
        )  # fmt: skip
        return Drafted(
            order.job, draft.body, draft.poses, draft.keypoints, network, draft.proposals
        )


_FITS = ByEvidence({FilmEvidence: FitJob.on_film, SurfaceEvidence: FitJob.on_surfaces})
