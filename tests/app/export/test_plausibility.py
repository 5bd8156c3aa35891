"""An imported motion is not nonsense without a word: its size, what is up, when it starts, and what
it does not say."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.app.cli.main import main
from keypose.app.export.import_motion import ImportedMotion, fit_to_session
from keypose.app.words.imports import note_words
from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import JointMotion
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.rigs import RIGS
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session
from tests.app.cli_cases import refused
from tests.tracker.formats import recordings
from tests.tracker.formats.recordings import bvh_of

SESSION = recordings.session("person")
SKELETON = Skeleton.of(SESSION.subject.body)
TRUTH = recordings.trajectory("person")
NAMES = joint_names(SKELETON)
TIMES_S = np.arange(len(TRUTH)) / 30
FIRST = Trajectory(0, TRUTH.Rs_parent_part[:8], TRUTH.ps_camera_root[:8])
WITHOUT_KEYFRAMES = SESSION.changed({"keyframes": ()})
TO_Y_UP = np.array([1.0, -1.0, -1.0])
HIPS = ["left_thigh", "right_thigh"]
REST = Trajectory(0, np.tile(np.eye(3), (1, SKELETON.part_count, 1, 1)), np.zeros((1, 3)))
JOINTS = [n for n in NAMES if n.rpartition("_")[2] not in ("top", "tip", "toe", "heel")]


def _fitted(
    motion: JointMotion, session: Session = WITHOUT_KEYFRAMES, offset_s: float | None = None
) -> ImportedMotion:
    return fit_to_session(session, motion, "a.bvh", TIMES_S, offset_s)


def _motion(names: list[str], flat: bool = False) -> JointMotion:
    """The first frames of the true motion at these joints, y up, its unit known."""
    indices = [NAMES.index(name) for name in names]
    ps = FIRST.joints(SKELETON)[:, indices] * TO_Y_UP
    return JointMotion(
        tuple(names), ps * ([1, 1, 0] if flat else 1), TIMES_S[: len(ps)], "y up", "m"
    )


def _oddities(found: ImportedMotion) -> list[str]:
    return [note.oddity for note in found.notes]


@pytest.mark.parametrize("ends", ["as written", "without length"])
@pytest.mark.parametrize("rig", RIGS)
def test_every_rig_comes_back_as_large_and_where_it_was(
    tmp_path: Path, rig: str, ends: str
) -> None:
    text = bvh_of(SKELETON, FIRST, 1 / 30, rig)
    if ends == "without length":
        text = re.sub(r"(End Site\s*\{\s*OFFSET) [^\n]*", r"\1 0 0 0", text)
    (tmp_path / "a.bvh").write_text(text)
    found = _fitted(load_motion(tmp_path / "a.bvh"), SESSION, 0.0)
    assert found.size == pytest.approx(100.0, rel=2e-3)  # written in metres, read as centimetres
    assert found.notes == ()
    limbs = [NAMES.index(n) for n in ("left_shin", "right_forearm", "left_foot", "right_hand")]
    ours, truth = found.fit.trajectory.joints(SKELETON), FIRST.joints(SKELETON)
    assert np.linalg.norm(ours - truth, axis=-1)[:, limbs].max() < 0.01


def test_the_size_is_that_of_most_bones_whatever_one_of_them_says() -> None:
    motion = _motion(JOINTS)
    odd = motion.ps_world_joint.copy()
    odd[:, JOINTS.index("left_hand")] += [0.0, 3.0, 0.0]
    found = _fitted(replace(motion, ps_world_joint=odd * 0.4, unit=None))
    assert found.size == pytest.approx(2.5, rel=1e-3)
    assert "proportions" in _oddities(found)
    assert any("left forearm" in words for words in note_words(found.notes))


@pytest.mark.parametrize("known", [[*HIPS, "left_shin"], [*HIPS, "left_shin", "right_shin"]])
def test_a_few_joints_do_not_say_how_a_body_moves(known: list[str]) -> None:
    with pytest.raises(FormatError, match=f"of its joints {len(known)} are known, too few"):
        _fitted(_motion(known))


def test_limbs_that_nothing_tells_are_named() -> None:
    without = [n for n in JOINTS if not n.startswith("left") or n in ("left_thigh",)]
    found = _fitted(_motion(without))
    assert _oddities(found) == ["undetermined parts"]
    (words,) = note_words(found.notes)
    assert "left upper arm, left forearm, left thigh and left shin" in words
    assert _oddities(_fitted(_motion(JOINTS))) == []


def test_limbs_whose_knees_and_elbows_have_no_counterpart_bend_by_a_guess() -> None:
    without = [n for n in JOINTS if not n.endswith(("shin", "forearm"))]
    found = _fitted(_motion(without))
    assert _oddities(found) == ["unplaced joints"]
    (words,) = note_words(found.notes)
    assert "left forearm, right forearm, left shin and right shin begin" in words


def test_a_flat_motion_says_that_it_has_no_depth() -> None:
    assert _oddities(_fitted(_motion(JOINTS, flat=True))) == ["flat"]


def test_what_is_up_is_read_off_the_pose_at_rest() -> None:
    motion = _motion(JOINTS)
    rest = REST.joints(SKELETON)[0, [NAMES.index(n) for n in JOINTS]] * TO_Y_UP
    upright = _fitted(replace(motion, rest_m=rest))
    z_up = replace(motion, ps_world_joint=_z_up(motion.ps_world_joint), rest_m=_z_up(rest))
    found = _fitted(z_up)
    assert _oddities(upright) == []
    assert _oddities(found) == ["z up at rest"]
    assert np.allclose(
        found.fit.trajectory.ps_camera_root, upright.fit.trajectory.ps_camera_root, atol=1e-3
    )
    assert _oddities(_fitted(replace(z_up, rest_m=None))) == ["lying"]


def _z_up(ps: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([ps[..., 0], -ps[..., 2], ps[..., 1]], axis=-1)


# --- when it starts


@pytest.fixture
def path(tmp_path: Path) -> Path:
    folder = tmp_path / "person"
    folder.mkdir()
    for name in ("session.json", "person.mp4"):
        shutil.copy(recordings.SAMPLES / "person" / name, folder)
    return folder / "session.json"


def test_a_motion_starts_where_it_meets_the_keyframes_unless_somebody_says(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = path.parent / "late.bvh"
    late = Trajectory(0, TRUTH.Rs_parent_part[20:], TRUTH.ps_camera_root[20:])
    file.write_text(bvh_of(SKELETON, late, 1 / 30))
    assert main(["import", str(path), str(file)]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("Frames 20–72.")
    assert "Note: Taken to start at frame 20" in said.err
    assert main(["import", str(path), str(file), "--offset-frames", "0"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("Frames 0–52.")
    assert "cm from the keyframes: check the frame" in said.err


def test_a_file_of_one_frame_is_a_draft_and_never_stands_over_a_keyframe(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = path.parent / "pose.bvh"
    pose = Trajectory(0, TRUTH.Rs_parent_part[9:10], TRUTH.ps_camera_root[9:10])
    file.write_text(bvh_of(SKELETON, pose, 1 / 30))
    before = load_session(path)
    assert main(["import", str(path), str(file), "--offset-frames", "9"]) == 0
    (draft,) = load_session(path).subject.drafts
    assert draft.frame == 9
    ours = draft.pose(SKELETON)
    posed = Trajectory(9, ours.Rs_parent_part[None], ours.p_camera_root[None])
    assert np.allclose(_distances(posed), _distances(pose), atol=0.01)
    capsys.readouterr()
    keyframe = before.subject.keyframes[0].frame
    order = ["import", path, file, "--offset-frames", keyframe]
    assert f"frame {keyframe} of the video is posed" in refused(capsys, path.parent, order)


def _distances(motion: Trajectory) -> NDArray[np.float64]:
    """Between all joints at the first frame, metres: how a body is posed, wherever it is."""
    ps = motion.joints(SKELETON)[0, [NAMES.index(name) for name in JOINTS]]
    return np.asarray(np.linalg.norm(ps[:, None] - ps, axis=-1))
