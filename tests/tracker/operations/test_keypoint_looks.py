"""In how many frames a session's network looks for the person, and in which it has."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SessionError
from keypose.tracker.keypoints.detectors import detector_fingerprint
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.operations.track import keypoint_source
from keypose.tracker.session import Session
from keypose.tracker.session.references import KEYPOINT_RUN
from keypose.tracker.solver.posed import Posed
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.fingerprints import segment_keys
from keypose.tracker.storage.sidecars import keypoints_of_session, save_keypoints
from keypose.tracker.tracking.cues import sources
from tests.tracker.keypoints.keypoint_cases import BALANCE

BOTH = ("brightness", "keypoints")
ALL = ("brightness", "keypoints", "silhouette")


@pytest.mark.parametrize(
    ("fps", "network", "cues", "still", "every_second"),
    [
        (60.0, "thunder", BOTH, True, True),
        (60.0, "thunder", ALL, True, True),
        (60.0, "thunder", ALL, False, False),  # each frame's mask judges
        (30.0, "thunder", BOTH, True, False),
        (60.0, "full", BOTH, True, False),  # as in sessions of before
    ],
)
def test_quick_films_are_looked_at_in_every_second_frame_where_no_mask_is_needed(
    fps: float, network: str, cues: tuple[str, ...], still: bool, every_second: bool
) -> None:
    session = load_session(BALANCE / "session.json")
    changed = {"network": network, "cues": cues, "static_camera": still}
    settings = session.settings.model_copy(update=changed)
    video: Any = SimpleNamespace(info=SimpleNamespace(fps=fps))
    source: Any = keypoint_source(session.changed({"settings": settings}), video, None)
    assert source.every_second is every_second


def drafted_at_keyframes(session: Session) -> Keypoints:
    """A draft of the film on which all keyframes lie."""
    skeleton = Skeleton.of(session.subject.body)
    _, parts, points = points_on_body(session.subject.body, JOINTS)
    frames = [keyframe.frame for keyframe in session.subject.keyframes]
    uv = [
        session.view.camera.project(Posed.of(skeleton, k.pose(skeleton)).points(parts, points))
        for k in session.subject.keyframes
    ]
    rows = np.arange(frames[0], frames[-1] + 1)
    nearest = np.abs(rows[:, None] - frames).argmin(axis=1)
    return Keypoints(frames[0], JOINTS, np.array(uv)[nearest], np.ones((len(rows), len(JOINTS))))


def test_a_drafted_film_is_tracked_without_another_look(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Every segment has the digests of its draft then, and sessions of before look as before."""

    class Looked(Exception):
        pass

    def look(*_args: Any, **_options: Any) -> Keypoints:
        raise Looked

    monkeypatch.setattr(sources, "detect", look)
    monkeypatch.setattr(sources, "open_detector", look)
    monkeypatch.setattr(sources, "_network", lambda model: None)
    plain, place = load_session(BALANCE / "session.json"), tmp_path / "session.json"
    settings = {"network": "thunder", "cues": BOTH, "static_camera": True}
    plain = plain.changed({"settings": plain.settings.model_copy(update=settings)})
    drafted = drafted_at_keyframes(plain)
    by_it = detector_fingerprint(find_model("thunder"))
    session = save_keypoints(plain, place, drafted, "BlazePose", network=by_it)
    of_before = session.changed(
        {"keypoints": session.view.keypoints.model_copy(update={"model": "", "runs": ()})}
    )
    skeleton = Skeleton.of(session.subject.body)
    video: Any = SimpleNamespace(info=SimpleNamespace(fps=30.0))
    for one, other in pairwise(session.subject.keyframes):
        segment: Any = SimpleNamespace(
            first_frame=one.frame, last_frame=other.frame,
            start=one.pose(skeleton), end=other.pose(skeleton),
        )  # fmt: skip
        given = skeleton, lambda: None
        source = keypoint_source(session, video, keypoints_of_session(session, tmp_path))
        found = source.over(segment, *given)
        np.testing.assert_allclose(found.uv, drafted.over(one.frame, other.frame).uv, rtol=1e-6)
        with pytest.raises(Looked):
            keypoint_source(of_before, video, drafted).over(segment, *given)
    with pytest.raises(SessionError, match=r"were not read.*keypoints_of_session"):
        keypoint_source(session, video, None)
    span, key = next(iter(segment_keys(session).items()))
    assert key != segment_keys(plain)[span] == segment_keys(of_before)[span]


def test_a_draft_of_more_frames_leaves_the_digests_of_others(tmp_path: Path) -> None:
    session = load_session(BALANCE / "session.json")
    place, network = tmp_path / "session.json", detector_fingerprint(find_model("full"))
    session = session.changed({"settings": session.settings.model_copy(update={"network": "full"})})
    frames = 3 * KEYPOINT_RUN
    rows = np.random.default_rng(0).uniform(0, 400, (frames, len(JOINTS), 2))

    def runs(count: int, by: str = network) -> tuple[str, ...]:
        found = Keypoints(0, JOINTS, rows[:count], np.ones((count, len(JOINTS))))
        reference = save_keypoints(session, place, found, "BlazePose", network=by).view.keypoints
        assert reference is not None
        return reference.runs

    whole, most = runs(frames), runs(frames - 1)
    assert len(set(whole)) == 3
    assert whole[:2] == most[:2]
    assert whole[2] != most[2]
    assert runs(frames, by="another network's") == runs(frames, by="") == ()
