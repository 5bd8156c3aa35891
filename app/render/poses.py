"""The poses that pictures of a session show: the keyframe's where one is set, else the tracked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.tracks import Tracks, load_tracks


@dataclass(frozen=True, eq=False)
class KnownPoses:
    """What is known of the motion. `tracks` is None where the session has not been tracked."""

    skeleton: Skeleton
    keys: Mapping[int, Pose]
    tracks: Tracks | None

    @classmethod
    def of(cls, session: Session, session_path: Path) -> KnownPoses:
        """SessionError in one sentence when there is a tracks file that cannot be read."""
        skeleton = Skeleton.of(session.subject.body)
        keys = {keyframe.frame: keyframe.pose(skeleton) for keyframe in session.subject.keyframes}
        tracks = load_tracks(session, session_path) if session.subject.results else None
        return cls(skeleton, keys, tracks)

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
