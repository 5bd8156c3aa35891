"""Bonds of a session that commands track anew: bodies meet, and its files say that they do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.bonds import Bond, BondEnd
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.tracks import load_tracks
from tests.app.bodies_cases import of_two
from tests.scenes import sample


@pytest.fixture
def bonded(tmp_path: Path) -> Path:
    """Two boxes whose middles, posed a centimetre apart, are said to meet, not tracked yet."""
    path = sample(tmp_path, "box")
    session = of_two(load_session(path))
    part = session.subject.body.names[0]
    ends = [BondEnd(body=body.id, part=part, point_m=(0.0, 0.0, 0.0)) for body in session.bodies]
    last = session.subject.keyframes[-1].frame
    bond = Bond(holder=ends[0], held=ends[1], first_frame=0, last_frame=last)
    save_session(session.model_copy(update={"bonds": (bond,)}), path)
    return path


def apart_m(path: Path) -> Array:
    """Between the middles of both boxes at each frame between their keyframes."""
    session, middles = load_session(path), []
    for body in session.bodies:
        about = session.about(body.id)
        tracks, skeleton = load_tracks(about, path), Skeleton.of(body.body)
        frames = range(body.keyframes[0].frame + 1, body.keyframes[-1].frame)
        poses = [tracks.pose(frame) for frame in frames]
        assert all(poses)
        middles.append(np.array([pose_transforms(skeleton, pose)[0, :3, 3] for pose in poses]))
    return np.asarray(np.linalg.norm(middles[0] - middles[1], axis=-1))


@pytest.mark.parametrize("command", ["track", "batch"])
def test_bodies_that_are_tracked_by_a_command_meet_where_they_are_bonded(
    bonded: Path, command: str
) -> None:
    assert main([command, str(bonded), "--quality", "full"]) == 0
    assert apart_m(bonded).max() < 0.002


def test_the_body_tracked_first_meets_the_one_that_is_tracked_anew(bonded: Path) -> None:
    for body in ("second", "body", "second"):
        assert main(["track", str(bonded), "--quality", "full", "--body", body]) == 0
    assert apart_m(bonded).max() < 0.002


def test_bonded_bodies_that_were_tracked_are_not_said_to_be_out_of_date(
    bonded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["track", str(bonded), "--quality", "full"]) == 0
    capsys.readouterr()
    assert main(["export", str(bonded), "--format", "npz", "--out", str(tmp_path / "out")]) == 0
    assert "out of date" not in capsys.readouterr().err
