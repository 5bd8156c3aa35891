"""Fit the pose of one frame to its picture, or to its surface."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from keypose.app.editor.posing import pose_to_fit, with_pose_fitted
from keypose.app.editor.shown import find, shown_pose
from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.job import Context
from keypose.app.state.outcomes import FitOutcome
from keypose.app.words.films import by_films_words
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.storage import sidecars
from keypose.tracker.storage.results import pose_at

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import FitHere
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState

SAME = 1e-9
"""Poses that differ by less are the same."""
NEAR_FRAMES = 8
"""So many frames to both sides the tracked poses are handed over."""


@dataclass(frozen=True, eq=False)
class FoundPose:
    """The pose of a frame as its picture shows it, and what that changed, in words.

    found: whether the picture showed anything; without it the pose is as it was.
    """

    pose: Pose
    found: bool
    words: str


@dataclass(frozen=True)
class FitPose(Fit):
    """tracked: the tracked poses of frames near, by frame. Two of one frame ask for the same."""

    session: bytes = field(compare=False)
    frame: int
    pose: Pose = field(compare=False)
    tracked: Mapping[int, Pose] = field(default_factory=dict, compare=False)

    asked = ("fit_here",)
    why_cancelled = "Fit cancelled because the pose changed."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, _: FitHere) -> Self:
        return cls(*sent(opened, edit.doc), edit.frame, pose_to_fit(edit), _near(edit))

    @property
    def title(self) -> str:
        return f"Fitting frame {self.frame}"

    def work(self, session: Session, context: Context) -> FoundPose:
        return _WAYS.of(session)(self, session, context)

    def on_film(self, session: Session, context: Context) -> FoundPose:
        from keypose.tracker.fitting.pose import fit_pose_to_picture  # loads what only this needs
        from keypose.tracker.operations.track import keypoint_source, steadied

        by_all = self._by_all_films(session)
        if by_all is not None:
            return by_all
        video = context.cache.video(session, self.video_path)
        skeleton = Skeleton.of(session.subject.body)
        others = {
            k.frame: k.pose(skeleton) for k in session.subject.keyframes if k.frame != self.frame
        }
        keypoints = context.cache.keypoints(session, Path(self.folder))
        camera, steady = session.view.camera, sidecars.one_focal(session)
        source = steadied(keypoint_source(session, video, keypoints), steady)
        picture_fit = fit_pose_to_picture(
            video,
            camera,
            skeleton,
            self.frame,
            self.pose,
            others,
            self.tracked,
            masks=session.view.ignore_masks,
            cancelled=context.cancelled,
            source=source,
            steady=steady,
        )
        return FoundPose(picture_fit.pose, picture_fit.way != "nothing", picture_fit.message)

    def _by_all_films(self, session: Session) -> FoundPose | None:
        """The pose as all films show it, which one film alone would pull away from it again; None
        where fewer than two see the body here."""
        if len(session.views) == 1:
            return None
        from keypose.tracker.films.mend import mended  # loads what only this needs
        from keypose.tracker.operations.films import keypoints_of_films, seen_in_films

        keypoints = keypoints_of_films(session, Path(self.folder))
        sights = seen_in_films(session, keypoints, self.frame)
        better = mended(session.subject.body, self.pose, sights)
        if better is None:
            return None
        return FoundPose(better.pose, True, by_films_words(len(sights), better.moved_m))

    def on_surfaces(self, session: Session, context: Context) -> FoundPose:
        # loads what only this needs
        from keypose.tracker.surface.fit.fitter import fit_pose_to_surface, fit_solids_to_surface

        surface_inputs, model = (
            (session, self.video_path, Path(self.folder)),
            session.model_keyframe,
        )
        if model is None or model.frame == self.frame:
            mesh = context.cache.surfaces(*surface_inputs).mesh(self.frame)
            fitted_pose = fit_solids_to_surface(mesh, Skeleton.of(session.subject.body), self.pose)
        else:
            fitted_pose = fit_pose_to_surface(
                context.cache.fitter(*surface_inputs), self.frame, self.pose
            )
        return FoundPose(fitted_pose.pose, True, fitted_pose.message)

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        return (
            doc.subject.body,
            *filmed_by(doc),
            doc.view.ignore_masks,
            doc.view.surface,
            *doc.views[1:],
        )

    def stands(self, began: EditorState, edit: EditorState) -> bool:
        """A pose that is kept as a keyframe meanwhile is the same pose."""
        if not super().stands(began, edit):
            return False
        if _posed(edit.doc, self.frame) is _posed(began.doc, self.frame):
            return True
        pose = shown_pose(replace(edit, frame=self.frame)).pose
        return bool(
            np.allclose(pose.Rs_parent_part, self.pose.Rs_parent_part, atol=SAME)
            and np.allclose(pose.p_camera_root, self.pose.p_camera_root, atol=SAME)
        )

    def apply(self, found_pose: FoundPose, state: AppState) -> tuple[AppState, str]:
        edit = state.editing
        after = with_pose_fitted(edit, self.frame, found_pose.pose) if found_pose.found else edit
        if after is edit:
            return state, found_pose.words
        outcome = FitOutcome(self.frame, found_pose.words, edit.doc, after.doc)
        return replace(state, edit=after, fit=outcome), ""


_WAYS = ByEvidence({FilmEvidence: FitPose.on_film, SurfaceEvidence: FitPose.on_surfaces})


def _posed(doc: Session, frame: int) -> Keyframe | None:
    return find(doc.subject.keyframes, frame) or find(doc.subject.drafts, frame)


def _near(edit: EditorState) -> dict[int, Pose]:
    """The tracked poses of frames near, this one too: it shows whether they were led through the
    pose to be fitted, and so hold its error. What tracking is on its way to does not count."""
    finished = edit.finished
    around = range(edit.frame - NEAR_FRAMES, edit.frame + NEAR_FRAMES + 1)
    poses = {frame: pose_at(finished, frame) for frame in around}
    return {frame: pose for frame, pose in poses.items() if pose is not None}
