"""One order to fit: a pose, or the sizes, to what the pictures show, drafts of a whole clip,
the body followed ahead, or a motion reduced to keyframes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, TypeAlias

from pydantic import ValidationError

from keypose.app.jobs.drafts import DraftLeft, DraftReporter, drafted, learned
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
    PoseFitting,
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
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SurfaceError, one_sentence
from keypose.tracker.session import Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.storage import sidecars
from keypose.tracker.video import Video

if TYPE_CHECKING:
    from keypose.tracker.fitting.draft import DraftProgress

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
            report=lambda pose: self._send(PoseFitting(order.job, order.frame, pose)),
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
