"""Mend the keyframes of a session by all its films at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.films.mend import mended
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.operations.films import seen_in_films
from keypose.tracker.session import Keyframe, Session

LEAST_M = 0.005
"""A keyframe that would be moved by less is left as it was set."""


@dataclass(frozen=True, eq=False)
class MendedKeyframes:
    """A session with its keyframes as all films show them.

    moved_m: by frame, how far joints were moved in the median; those that fewer than two films see
        are not there, and as they were.
    """

    session: Session
    moved_m: Mapping[int, float]


def mend_keyframes(session: Session, keypoints: Mapping[str, Keypoints]) -> MendedKeyframes:
    """The keyframes mended, each by itself; drafts stay as they are.

    keypoints: of every film, by the view's id.
    """
    subject = session.subject
    skeleton = Skeleton.of(subject.body)
    keyframes: list[Keyframe] = []
    moved_m: dict[int, float] = {}
    for keyframe in subject.keyframes:
        sights = seen_in_films(session, keypoints, keyframe.frame)
        better = mended(subject.body, keyframe.pose(skeleton), sights)
        if better is None or better.moved_m < LEAST_M:
            keyframes.append(keyframe)
            continue
        posed = Keyframe.of(skeleton, better.pose, keyframe.frame, keyframe.time_s)
        place = {"root_m": posed.root_m, "rotations_wxyz": posed.rotations_wxyz}
        keyframes.append(keyframe.model_copy(update=place))
        moved_m[keyframe.frame] = better.moved_m
    after = session.changed({"keyframes": tuple(keyframes)})
    return MendedKeyframes(after, moved_m)
