"""Prepare a session about surfaces to be fitted: its segments, or one pose."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.errors import SessionError, listed, readable
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.session.references import Surface
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Quality, TrackSettings
from keypose.tracker.surface.fit.judging import lies_off, off_its_surface
from keypose.tracker.surface.fit.measuring import measure
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import TargetSurface
from keypose.tracker.surface.fit.segment import SurfaceTracker
from keypose.tracker.surface.fit.solving import fit_pose
from keypose.tracker.surface.mesh import Steps, SurfaceMesh
from keypose.tracker.tracking.result import SegmentResult

Span: TypeAlias = tuple[int, int]


class SurfaceFitter:
    """The segments of a session about surfaces; threads may share it.

    model_frame: the keyframe in whose mesh the body was posed; that mesh moves with it.
    SessionError without a keyframe: the surface that moves with the body is that of one.
    """

    def __init__(self, session: Session, steps: Steps) -> None:
        model = session.model_keyframe
        if model is None or session.view.surface is None:
            raise SessionError(
                "keyframes: one at least is needed to fit surfaces, and the session has none."
            )
        self.skeleton = Skeleton.of(session.subject.body)
        self.spans: tuple[Span, ...] = session.spans
        self._surface, self._steps, self.model_frame = session.view.surface, steps, model.frame
        self._keyposes = {k.frame: k.pose(self.skeleton) for k in session.subject.keyframes}
        self._trackers: dict[Quality, SurfaceTracker] = {}
        self._lock = threading.Lock()

    def expected_steps(self, span: Span, settings: TrackSettings) -> int:
        """Steps of time that `run_segment` works through."""
        return self._tracker(settings.quality).expected_steps(span)

    def run_segment(
        self, span: Span, settings: TrackSettings, emit: Callable[[Pass, int], None]
    ) -> SegmentResult:
        """Fit one segment; `emit` is called now and then with the step, from 0, that was last done,
        and may raise Cancelled to stop. SessionError where the session has no such segment.
        """
        if span not in self.spans:
            raise SessionError(f"Frames {span[0]} to {span[1]} are no segment of the session.")

        def report(step: Pass, done: int) -> None:
            emit(step, done - 1)

        tracker = self._tracker(settings.quality)
        segment_result = tracker.run_segment(span, report)
        off = lies_off(tracker.model, self._keyposes[self.model_frame])
        if self._reports_model(span):
            notes = (*self._describe_off(off), *self._describe_holes(), *self._describe_cuts())
            segment_result = replace(segment_result, notes=(*notes, *segment_result.notes))
        return (
            replace(segment_result, verdict=off_its_surface(self.model_frame))
            if off
            else segment_result
        )

    def fit_frame(self, frame: int, pose: Pose, quality: Quality = "full") -> Pose:
        """A pose fitted to the surface of one step; SurfaceError where that cannot be used."""
        return self._tracker(quality).fit_frame(frame, pose)

    def _reports_model(self, span: Span) -> bool:
        """Tell whether this segment, of those that touch the model's keyframe, carries the notes on
        it.
        """
        return self.model_frame == (span[1] if self.model_frame else span[0])

    def _describe_off(self, off: bool) -> tuple[str, ...]:
        """A sentence where the body does not lie in that mesh."""
        if not off:
            return ()
        return (
            f"At frame {self.model_frame} the body does not lie in the mesh that moves with it: "
            "look at its pose there (F fits it to the mesh), at its height and sizes in Body, "
            "and at the units of the meshes.",
        )

    def _describe_holes(self) -> tuple[str, ...]:
        """A sentence where the mesh that moves with the body is not whole."""
        rims = len(self._steps.mesh(self.model_frame).rim)
        if not rims:
            return ()
        return (
            f"The mesh of frame {self.model_frame}, whose surface moves with the body, has holes: "
            f"{rims} of its edges have a face on one side only. What is missing there is not "
            "fitted anywhere; pose the body in a mesh that is whole, if there is one.",
        )

    def _describe_cuts(self) -> tuple[str, ...]:
        """A sentence where cameras did not see all of that mesh."""
        names = self._steps.cut_by(self.model_frame)
        if not names:
            return ()
        do = "does" if len(names) == 1 else "do"
        return (
            f"{'Camera' if len(names) == 1 else 'Cameras'} {listed(names)} {do} not see all of the "
            f"mesh of frame {self.model_frame}, whose surface moves with the body: it may be cut "
            "off there, or too full; pose the body where all of it is in every picture.",
        )

    def _tracker(self, quality: Quality) -> SurfaceTracker:
        with self._lock:
            if quality not in self._trackers:
                options = options_of(self._surface).at(quality)
                self._trackers[quality] = SurfaceTracker(
                    self._steps, self.skeleton.body, self._keyposes, self.model_frame, options
                )
            return self._trackers[quality]


def options_of(surface: Surface) -> Options:
    """How a session has its surfaces fitted."""
    return Options(
        contact=surface.weights in ("both", "contact"),
        photo=surface.weights in ("both", "photo"),
        plane=1.0 if surface.distance == "plane" else 0.0,
        smooth=surface.binding == "smooth",
    )


LEAST_REPORTED_M = 0.005
MOST = 3

MUCH = 0.25
"""Of the observed surface: from so much far from the body on, a hint is given."""
_NOT_YET = (
    " Much of the surface is still far from the body: set height and sizes in Body, pull the limbs "
    "nearer, and fit again."
)
OPTIONS = Options(contact=False, offset=False, solves=60)
"""Solids overlap where a surface is in one piece, so contact does not count; and with nothing left
out, a difference in thickness pushes evenly."""


@dataclass(frozen=True, eq=False)
class FittedPose:
    """The pose, and which parts moved in a sentence."""

    pose: Pose
    message: str


def fit_pose_to_surface(fitter: SurfaceFitter, frame: int, pose: Pose) -> FittedPose:
    """Fit a pose to the surface of a frame; SurfaceError where that cannot be used."""
    fitted = fitter.fit_frame(frame, pose)
    return FittedPose(fitted, _describe_moves(fitter.skeleton, pose, fitted))


def fit_solids_to_surface(mesh: SurfaceMesh, skeleton: Skeleton, pose: Pose) -> FittedPose:
    """Fit the body's own solids to a surface, where none moves with the body yet.

    As exact as the body's sizes: joints come to a centimetre or two. mesh: camera frame, metres.
    """
    size = float(np.linalg.norm(mesh.extent))
    model = SurfaceModel.of_solids(skeleton.body, pose, OPTIONS.points, size)
    observed = TargetSurface.of(mesh, OPTIONS)
    fit = fit_pose(model, observed, pose, OPTIONS)
    left = measure(model, observed, fit).unexplained
    return FittedPose(
        fit.pose, _describe_moves(skeleton, pose, fit.pose) + (_NOT_YET if left > MUCH else "")
    )


def _describe_moves(skeleton: Skeleton, before: Pose, after: Pose) -> str:
    """Such as "Right forearm moved 6 cm, head 2 cm."."""
    moved = np.linalg.norm(_middles(skeleton, after) - _middles(skeleton, before), axis=1)
    most = [i for i in np.argsort(-moved, kind="stable")[:MOST] if moved[i] >= LEAST_REPORTED_M]
    if not most:
        return "No part moved by more than half a centimetre."
    names = [readable(skeleton.body.names[i]) for i in most]
    first, *rest = (f"{100 * moved[i]:.0f} cm" for i in most)
    words = [f"{names[0]} moved {first}", *map(" ".join, zip(names[1:], rest, strict=True))]
    text = ", ".join(words)
    return f"{text[:1].upper()}{text[1:]}."


def _middles(skeleton: Skeleton, pose: Pose) -> Array:
    """(P, 3) the middle of every part, camera frame, metres."""
    Ts, parts = pose_transforms(skeleton, pose), skeleton.body.parts
    middles = [
        apply_transform(T, part.shape.mesh().vertices).mean(axis=0)
        for T, part in zip(Ts, parts, strict=True)
    ]
    return np.array(middles)
