"""`keypose track --ahead`: drafts beside the one keyframe, how far they reach, and why."""

from __future__ import annotations

import json
import shutil
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.tracker import (
    FoundAhead,
    Skeleton,
    Trajectory,
    load_session,
    open_video_of,
    track_ahead,
)
from keypose.tracker.operations import track as tracking
from keypose.tracker.session import Session
from keypose.tracker.storage.files import save_session
from tests.app.cli_cases import everything_in, refused
from tests.app.serving import ROOT

BOX = ROOT / "sample_videos" / "box"


@pytest.fixture
def one_key(tmp_path: Path) -> Path:
    """The bundled box, with its first keyframe alone."""
    folder = tmp_path / "box"
    shutil.copytree(BOX, folder)
    path = folder / "session.json"
    session = load_session(path)
    update = {"keyframes": session.subject.keyframes[:1], "results": None}
    save_session(session.changed(update), path)
    return path


def off_px(session: Session) -> float:
    """How far the drafts are off at most."""
    skeleton = Skeleton.of(session.subject.body)
    with np.load(BOX / "truth.npz") as truth:
        Rs, ps = truth["Rs_parent_part"], truth["ps_camera_root"]
        rows = [draft.frame - int(truth["first_frame"]) for draft in session.subject.drafts]
    poses = [draft.pose(skeleton) for draft in session.subject.drafts]
    found = Trajectory(
        0, np.stack([p.Rs_parent_part for p in poses]), np.stack([p.p_camera_root for p in poses])
    )
    uv, true = (
        session.view.camera.project(m.joints(skeleton))
        for m in (found, Trajectory(0, Rs[rows], ps[rows]))
    )
    return float(np.linalg.norm(uv - true, axis=-1).max())


def test_the_bundled_box_is_followed_without_any_keypoints(
    one_key: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["track", str(one_key), "--ahead", "forward"]) == 0
    session = load_session(one_key)
    (record,) = session.subject.ahead
    assert record.from_frame == session.subject.keyframes[0].frame
    assert [draft.frame for draft in session.subject.drafts] == list(
        range(record.from_frame + 1, record.to_frame + 1)
    )
    assert record.to_frame >= 20
    assert off_px(session) < 4.0
    message = capsys.readouterr().out.splitlines()
    assert message[0].startswith(f"Tracked ahead to {record.to_frame}. ")
    assert message[-1] == f"Written: {one_key}"


def test_from_python_it_is_the_same(one_key: Path) -> None:
    session, seen = load_session(one_key), list[int]()
    with open_video_of(session, one_key) as video:
        found = track_ahead(session, video, longest=6, emit=lambda m: seen.append(len(m)))
    assert isinstance(found, FoundAhead)
    assert (found.to_frame, found.stop.cause, seen) == (
        session.subject.keyframes[0].frame + 6,
        "limit",
        [7],
    )


# --- without pictures


@pytest.fixture
def followed(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Stands in for following: one frame with every call; what it was called with."""
    calls: list[Any] = []

    def follow(tracker: Any, frame: int, way: Any, settings: Any, emit: Any, longest: int) -> Any:
        from keypose.tracker.session.annotations import Stop
        from keypose.tracker.tracking.pool import Cancelled

        calls.append((frame, way, settings))
        pose = tracker.keyposes[frame]
        first = frame if way == "forward" else frame - 1
        Rs, ps = (np.repeat(a[None], 2, axis=0) for a in (pose.Rs_parent_part, pose.p_camera_root))
        motion, cause = Trajectory(first, Rs, ps), "limit"
        try:
            emit(motion)
        except Cancelled:
            cause = "cancelled"
        return FoundAhead(frame, way, motion, Stop(cause=cause))  # type: ignore[arg-type]

    monkeypatch.setattr(tracking, "follow_ahead", follow)
    return calls


def test_both_ways_and_as_json(
    session_path: Path, followed: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(session_path)
    keys = [k.frame for k in session.subject.keyframes]
    middle = session.changed({"keyframes": session.subject.keyframes[1:2]})
    save_session(middle, session_path)
    assert (
        main(["track", str(session_path), "--ahead", "both", "--quality", "preview", "--json"]) == 0
    )
    assert [(frame, way) for frame, way, _ in followed] == [
        (keys[1], "forward"), (keys[1], "backward"),
    ]  # fmt: skip
    assert followed[0][2].quality == "preview"
    assert load_session(session_path).settings == session.settings
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [e["event"] for e in events] == ["progress", "progress", "finished"]
    assert [found["to"] for found in events[-1]["ahead"]] == [keys[1] + 1, keys[1] - 1]
    assert len(load_session(session_path).subject.drafts) == 2


def test_into_a_folder_the_session_stays_as_it_is(
    session_path: Path, tmp_path: Path, followed: list[Any]
) -> None:
    save_session(_first_alone(session_path), session_path)
    before = everything_in(session_path.parent)
    out = tmp_path / "out"
    assert main(["track", str(session_path), "--ahead", "forward", "--out", str(out)]) == 0
    assert everything_in(session_path.parent) == before
    assert len(load_session(out / "session.json").subject.ahead) == 1


def test_interrupted_it_keeps_what_was_found(
    session_path: Path, followed: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    save_session(_first_alone(session_path), session_path)
    follow = tracking.follow_ahead

    def interrupted(*given: Any) -> Any:
        signal.raise_signal(signal.SIGINT)
        return follow(*given)

    monkeypatch.setattr(tracking, "follow_ahead", interrupted)
    assert main(["track", str(session_path), "--ahead", "forward"]) == 130
    assert load_session(session_path).subject.ahead[0].stop.cause == "cancelled"


def test_without_a_keyframe_or_beyond_the_end_it_is_refused(
    session_path: Path, followed: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(session_path)
    save_session(session.changed({"keyframes": ()}), session_path)
    folder, arguments = session_path.parent, ["track", session_path, "--ahead"]
    assert "add it as a keyframe first" in refused(capsys, folder, [*arguments, "both"])
    save_session(session, session_path)
    assert "video's first frame" in refused(capsys, folder, [*arguments, "backward"])
    assert not followed


def _first_alone(path: Path) -> Session:
    session = load_session(path)
    return session.changed({"keyframes": session.subject.keyframes[:1]})
