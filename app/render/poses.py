"""The poses that pictures of a session show: the keyframe's where one is set, else the tracked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from keypose.app.render.painting import Figure, form_in
from keypose.app.render.palette import Colour, body_colour
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.tracks import Tracks, load_tracks


@dataclass(frozen=True, eq=False)
class KnownPoses:
    """What is known of the motion. `tracks` is None where the session has not been tracked.

    beside: the same of other bodies, each with its colour.
    """

    skeleton: Skeleton
    keys: Mapping[int, Pose]
    tracks: Tracks | None
    beside: tuple[tuple[Colour, KnownPoses], ...] = ()

    @classmethod
    def of(cls, session: Session, session_path: Path, *, alone: bool = True) -> KnownPoses:
        """SessionError in one sentence when there is a tracks file that cannot be read.

        alone: without the other bodies.
        """
        beside = () if alone else cls.others(session, session_path)
        skeleton = Skeleton.of(session.subject.body)
        keys = {keyframe.frame: keyframe.pose(skeleton) for keyframe in session.subject.keyframes}
        tracks = load_tracks(session, session_path) if session.subject.results else None
        return cls(skeleton, keys, tracks, beside)

    @classmethod
    def others(cls, session: Session, session_path: Path) -> tuple[tuple[Colour, KnownPoses], ...]:
        """Of the bodies that are not posed, each with its colour."""
        return tuple(
            (body_colour(place), cls.of(session.about(body.id), session_path))
            for place, body in enumerate(session.bodies)
            if body.id != session.subject.id
        )

    def figures_beside(self, frame: int) -> tuple[Figure, ...]:
        """The other bodies that have a pose at a frame."""
        figures = []
        for colour, known_poses in self.beside:
            pose = known_poses.pose(frame)
            if pose is not None:
                Ts = pose_transforms(known_poses.skeleton, pose)
                figures.append(Figure(form_in(known_poses.skeleton, colour), Ts))
        return tuple(figures)

    def pose(self, frame: int) -> Pose | None:
        """The pose at a frame, None where there is none."""
        keyed = self.keys.get(frame)
        return keyed if keyed is not None or self.tracks is None else self.tracks.pose(frame)

    @property
    def frames(self) -> tuple[int, ...]:
        """The frames that have a pose, ascending."""
        with_pose = set(self.keys)
        if self.tracks is not None:
            with_pose.update(
                (np.flatnonzero(self.tracks.tracked) + self.tracks.first_frame).tolist()
            )
        return tuple(sorted(with_pose))
