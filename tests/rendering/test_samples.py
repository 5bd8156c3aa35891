"""The clips that come with the product belong to their sessions and their truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from keypose.sample_videos import make_balance
from keypose.sample_videos.make_samples import FOLDER, samples
from keypose.tracker.body.pose import joint_names, joint_positions, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.storage.archive import archive_arrays
from keypose.tracker.storage.files import load_session, open_video_of

LARGEST_BYTES = {"box": 300_000, "person": 1_000_000}


@pytest.mark.parametrize("name", LARGEST_BYTES)
def test_a_sample_is_small_and_its_keyframes_are_the_truth(name: str) -> None:
    folder = Path(FOLDER) / name
    assert (folder / f"{name}.mp4").stat().st_size < LARGEST_BYTES[name]
    session = load_session(folder / "session.json")
    truth = archive_arrays((folder / "truth.npz").read_bytes())
    skeleton = Skeleton.of(session.subject.body)
    assert len(truth["ps_camera_root"]) == session.view.video.frame_count
    assert session.subject.keyframes[-1].frame == session.view.video.frame_count - 1
    for keyframe in session.subject.keyframes:
        pose = keyframe.pose(skeleton)
        true_Rs = truth["Rs_parent_part"][keyframe.frame]
        np.testing.assert_allclose(pose.Rs_parent_part, true_Rs, atol=1e-12)
        np.testing.assert_allclose(pose.p_camera_root, truth["ps_camera_root"][keyframe.frame])


def test_the_clips_show_what_the_renderer_makes_today() -> None:
    for sample in samples():
        path = FOLDER / sample.name / "session.json"
        with open_video_of(load_session(path), path) as video:
            coded = video.frame(10).astype(int)
        fresh = sample.scene.cut(10, 10).frames()[0]
        assert np.abs(coded - fresh).mean() < 2.5


def test_the_filmed_clip_has_its_licence_and_its_poses_lie_on_its_marks() -> None:
    folder = make_balance.FOLDER
    assert (folder / "balance.mp4").stat().st_size < 1_500_000
    assert "BSD 3-Clause" in (folder / "LICENSE").read_text("utf-8")
    session = load_session(folder / "session.json")
    open_video_of(session, folder / "session.json").close()
    skeleton = Skeleton.of(session.subject.body)
    names = joint_names(skeleton)
    marks = make_balance.marks()
    assert [mark.frame for mark in marks] == [
        keyframe.frame for keyframe in session.subject.keyframes
    ]
    misses_px = []
    for mark, keyframe in zip(marks, session.subject.keyframes, strict=True):
        Ts = pose_transforms(skeleton, keyframe.pose(skeleton))
        uv = session.view.camera.project(joint_positions(skeleton, Ts))
        known = [name for name in mark.uv if name in names]
        at_marks = uv[[names.index(name) for name in known]]
        misses_px.append(at_marks - [mark.uv[name] for name in known])
    assert np.linalg.norm(np.concatenate(misses_px), axis=1).mean() < 3
