"""One order to fit: a pose, or the sizes, to what the pictures show."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from threading import Event

from pydantic import ValidationError

from app.jobs.messages import (
    FitOrder,
    Fitted,
    JobFailed,
    JobFinished,
    PoseFitted,
    PoseOrder,
    Report,
    SizesFitted,
    SizesOrder,
)
from app.jobs.worker_cache import WorkerCache
from tracker.body.skeleton import Skeleton
from tracker.errors import KeyposeError, SurfaceError, one_sentence
from tracker.session import Session
from tracker.video import Video

Tell = Callable[[Report], None]


class Fit:
    """An order at work. Soon after `cancelled` is set it is left, and tells nothing it found."""

    def __init__(self, order: FitOrder, cancelled: Event, tell: Tell) -> None:
        self.order = order
        self._cancelled = cancelled
        self._tell = tell

    def run(self, worker_cache: WorkerCache) -> None:
        """Do the work and tell how it ended."""
        job = self.order.job
        try:
            fitted = self._fit(worker_cache)
        except ValidationError as error:
            self._tell(JobFailed(job, one_sentence(error)))
        except KeyposeError as error:
            self._tell(JobFailed(job, str(error)))
        except Exception as error:  # noqa: BLE001 — a fault, told as such
            self._tell(JobFailed(job, _fault(error)))
        else:
            cancelled = self._cancelled.is_set()
            self._tell(JobFinished(job, cancelled=True) if cancelled else fitted)

    def _fit(self, worker_cache: WorkerCache) -> Fitted:
        session = Session.model_validate_json(self.order.session)
        if session.surface is not None:
            return self._on_surface(self.order, session, worker_cache)
        video = worker_cache.video(session, self.order.video_path)
        if isinstance(self.order, PoseOrder):
            return self._pose(self.order, session, video)
        return self._sizes(self.order, session, video)

    def _on_surface(
        self, order: FitOrder, session: Session, worker_cache: WorkerCache
    ) -> PoseFitted:
        if isinstance(order, SizesOrder):
            raise SurfaceError(
                "Sizes are fitted to pictures, not to surfaces: set them in Body, by what you see."
            )
        from tracker.surface.fit.fit_here import fit_here, lay_body  # loads what only this needs

        path, folder, model = order.video_path, Path(order.folder), session.model_keyframe
        if model is None or model.frame == order.frame:
            mesh = worker_cache.surfaces(session, path, folder).mesh(order.frame)
            found = lay_body(mesh, Skeleton.of(session.body), order.pose)
        else:
            found = fit_here(worker_cache.fitter(session, path, folder), order.frame, order.pose)
        return PoseFitted(order.job, found.pose, True, found.words)

    def _pose(self, order: PoseOrder, session: Session, video: Video) -> PoseFitted:
        from tracker.fitting.pose import fit_here  # loads what only this needs

        skeleton = Skeleton.of(session.body)
        others = {k.frame: k.pose(skeleton) for k in session.keyframes if k.frame != order.frame}
        found = fit_here(
            video, session.camera, skeleton, order.frame, order.pose, others, order.tracked,
            masks=session.ignore_masks, cancelled=self._cancelled.is_set,
        )  # fmt: skip
        return PoseFitted(order.job, found.pose, found.way != "nothing", found.words)

    def _sizes(self, order: SizesOrder, session: Session, video: Video) -> SizesFitted:
        from tracker.fitting.sizes import fit_sizes  # loads what only this needs

        skeleton = Skeleton.of(session.body)
        keyposes = {k.frame: k.pose(skeleton) for k in session.keyframes}
        found = fit_sizes(
            video, session.camera, session.body, keyposes, focal=order.focal,
            masks=session.ignore_masks, cancelled=self._cancelled.is_set,
        )  # fmt: skip
        return SizesFitted(
            order.job, found.body, found.camera, found.keyposes, found.words, found.changes
        )


def _fault(error: Exception) -> str:
    """One sentence for the person, all of it for whoever reads the log."""
    traceback.print_exception(error, file=sys.stderr)
    return f"Fitting met a fault of Keypose itself ({type(error).__name__}); nothing was changed."
