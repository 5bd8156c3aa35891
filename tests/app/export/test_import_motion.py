"""Recorded motion and keypoints brought into a session: what a person posed stays as it was."""

from __future__ import annotations

import csv
import io
import json
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.app.cli.main import main
from keypose.app.document.folder_lock import SessionLock
from keypose.app.document.open import copy_session
from keypose.app.export.import_keypoints import Draft, drafts_of, match_keypoints
from keypose.app.export.import_motion import fit_to_session
from keypose.tracker.body.pose import joint_names, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError, SessionError
from keypose.tracker.evaluate import evaluate
from keypose.tracker.formats.csv import joints_csv
from keypose.tracker.formats.joint_motion import JointMotion, World
from keypose.tracker.formats.joint_names import matched
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.operations.track import track_session
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.camera_motion import CameraMotion
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.results import segment_keys
from keypose.tracker.storage.sidecars import load_first_motion
from keypose.tracker.storage.tracks import load_trajectory
from keypose.tracker.tracking.pool import TrackFinished
from keypose.tracker.tracking.result import TrackResult
from tests.app.cli_cases import everything_in, refused
from tests.tracker.formats import recordings
from tests.tracker.formats.recordings import bvh_of

Floats = NDArray[np.float64]

TRUTH = recordings.trajectory("person")
SESSION = recordings.session("person")
SKELETON = Skeleton.of(SESSION.subject.body)
NAMES = joint_names(SKELETON)
TIMES_S = np.arange(len(TRUTH)) / 30
R = exp_rotation([0.4, -1.1, 2.0])
P = np.array([4.0, -7.0, 2.5])
"""Another world."""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """The sample's session beside its video."""
    folder = tmp_path / "person"
    folder.mkdir()
    for name in ("session.json", "person.mp4"):
        shutil.copy(recordings.SAMPLES / "person" / name, folder)
    return folder / "session.json"


def _wide(ps: Floats, names: Sequence[str] = NAMES, scale: float = 1.0) -> str:
    """A table of positions (N, J, 3), y up by its own word, in another world."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(["time", *(f"{name}_{axis}" for name in names for axis in "xyz")])
    for time_s, row in zip(TIMES_S, scale * (ps @ R.T + P), strict=False):
        writer.writerow([time_s, *row.ravel()])
    return text.getvalue()


def _imported(path: Path) -> Trajectory:
    session = load_session(path)
    motion = load_first_motion(session, path.parent)
    assert motion is not None
    return motion


def _away(motion: Trajectory) -> Floats:
    ours, truth = motion.joints(SKELETON), TRUTH.joints(SKELETON)
    here = slice(motion.first_frame, motion.last_frame + 1)
    return np.asarray(np.linalg.norm(ours - truth[here], axis=-1))


def _run(*arguments: object) -> int:
    return main([str(a) for a in arguments])


@pytest.mark.parametrize("kind", ["bvh", "csv", "wide", "wide in feet"])
def test_our_own_motion_comes_back_to_a_millimetre(path: Path, kind: str) -> None:
    texts = {
        "bvh": bvh_of(SKELETON, TRUTH, 1 / 30),
        "csv": joints_csv(SKELETON, TRUTH, TIMES_S),
        "wide": _wide(TRUTH.joints(SKELETON)),
        "wide in feet": _wide(TRUTH.joints(SKELETON), scale=3.281),
    }
    file = path.parent / f"motion.{'bvh' if kind == 'bvh' else 'csv'}"
    file.write_text(texts[kind], newline="")
    before = load_session(path)
    assert _run("import", path, file) == 0
    after = load_session(path)
    assert after.subject.keyframes == before.subject.keyframes
    assert after.changed({"first_motion": None}) == before
    away = _away(_imported(path))
    parts = SKELETON.part_count  # BVH says nothing of heels
    assert len(away) == len(TRUTH)
    assert (away[:, :parts] if kind == "bvh" else away).max() < 1e-3


def _before_a_moving_camera() -> tuple[Session, Trajectory]:
    """The sample as a camera sees it that turns, walks along and zooms; the motion in its frame."""
    t = np.linspace(0, 1, len(TRUTH))[:, None]
    path = CameraPath.of(
        exp_rotation(t * [0.05, -0.3, 0.02]), t * [0.4, 0.0, 0.2], 1 + 0.2 * t[:, 0]
    )
    seen, steady = TRUTH.carried(path.Ts_camera_world), SESSION.view.video
    motion = CameraMotion.of("moves", path, np.zeros(len(TRUTH)))
    keyframes = tuple(
        Keyframe.of(SKELETON, seen.pose(k.frame), k.frame, k.time_s)
        for k in SESSION.subject.keyframes
    )
    fields = {"camera_motion": motion, "keyframes": keyframes}
    fields["video"] = steady.model_copy(update={"stands_still": False})
    return SESSION.changed(fields), seen


@pytest.mark.parametrize("world", ["y up", "camera"])
def test_recorded_motion_meets_the_keyframes_of_a_camera_that_moves(world: World) -> None:
    session, seen = _before_a_moving_camera()
    ps = seen.joints(SKELETON) if world == "camera" else TRUTH.joints(SKELETON) @ R.T + P
    motion = JointMotion(NAMES, ps, TIMES_S, world, "m")
    found = fit_to_session(session, motion, "a.bvh", TIMES_S)
    away = found.fit.trajectory.joints(SKELETON) - seen.joints(SKELETON)
    assert np.linalg.norm(away, axis=-1).max() < 1e-3
    assert found.miss_px.max() < 0.5
    assert found.notes == ()


def test_the_offset_says_where_the_files_time_begins(path: Path) -> None:
    file = path.parent / "late.bvh"
    late = Trajectory(0, TRUTH.Rs_parent_part[20:], TRUTH.ps_camera_root[20:])
    file.write_text(bvh_of(SKELETON, late, 1 / 30))
    for option in (["--offset-frames", "20"], ["--offset-s", str(20 / 30)]):
        assert _run("import", path, file, *option) == 0
        motion = _imported(path)
        assert (motion.first_frame, motion.last_frame) == (20, 72)
        assert _away(motion)[:, : SKELETON.part_count].max() < 1e-3


def test_what_was_matched_left_out_and_met_is_reported(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    noise = np.random.default_rng(1).normal(0, 0.01, (len(TRUTH), 13, 3))
    file = path.parent / "wide.csv"
    file.write_text(_wide(TRUTH.joints(SKELETON)[:, :13] + noise, [*NAMES[:12], "Banana"]))
    assert _run("import", path, file, "--json") == 0
    reported = json.loads(capsys.readouterr().out)
    assert reported["left_out"] == ["Banana"]
    assert reported["matched"]["left_forearm"] == "left_forearm"
    assert reported["keyframes"] == [0, 24, 48, 72]
    assert 0.3 < reported["rms_cm"] < 2.0
    assert 0.3 < reported["from_keyframes_cm"] < 3.0
    assert Path(reported["written"]).is_file()
    assert _run("import", path, file) == 0
    words = capsys.readouterr().out
    assert "Banana" in words
    assert "keyframes 0, 24, 48, 72" in words


def test_without_keyframes_the_body_stands_upright_in_the_picture(path: Path) -> None:
    session = load_session(path).changed({"keyframes": ()})
    to_y_up = np.array([1.0, -1.0, -1.0])
    motion = JointMotion(NAMES, TRUTH.joints(SKELETON) * to_y_up + [9, 5, 3], TIMES_S, "y up", "m")
    found = fit_to_session(session, motion, "a.bvh", TIMES_S).fit.trajectory
    p = found.transforms(SKELETON)[..., :3, 3]
    assert (p[:, SKELETON.body.index("head"), 1] < p[:, SKELETON.body.index("left_foot"), 1]).all()
    uv = session.view.camera.project(found.joints(SKELETON))
    assert uv.min() > 0
    assert (uv.max(axis=(0, 1)) < (session.view.camera.width, session.view.camera.height)).all()
    z_up = motion.ps_world_joint @ np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    same = JointMotion(NAMES, z_up, TIMES_S, "z up", "m")
    again = fit_to_session(session, same, "a.c3d", TIMES_S).fit.trajectory
    assert np.allclose(again.joints(SKELETON), found.joints(SKELETON), atol=2e-3)


def test_a_session_that_is_open_elsewhere_is_left_alone(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = path.parent / "motion.bvh"
    file.write_text(bvh_of(SKELETON, TRUTH, 1 / 30))
    lock = SessionLock.take(path.parent)
    try:
        assert "open in another Keypose" in refused(capsys, path.parent, ["import", path, file])
    finally:
        lock.release()


def test_what_does_not_suit_the_session_is_refused_in_one_sentence(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    SessionLock.take(path.parent).release()  # its file stays, and is no change later
    folder = path.parent
    (folder / "good.bvh").write_text(bvh_of(SKELETON, TRUTH, 1 / 30, unit="cm"))
    (folder / "two.csv").write_text("time,waist_x,waist_y,waist_z\n0,0,0,0\n1,0,0,0\n")
    (folder / "bad.bvh").write_text("HIERARCHY")
    (folder / "names.json").write_text('{"waist": "wing"}')
    (folder / "points.json").write_text("[]")
    cases: list[tuple[list[str | Path], str]] = [
        ([folder / "two.csv"], "name their counterparts"),
        ([folder / "bad.bvh"], "MOTION"),
        ([folder / "none.bvh"], "no motion file"),
        ([folder / "good.bvh", "--offset-frames", "500"], "choose the frame at which it starts"),
        ([folder / "good.bvh", "--names", folder / "names.json"], "wing"),
        ([folder / "good.bvh", "--fps", "0"], "is not a rate"),
        ([folder / "good.bvh", "--unit", "inch"], "inch"),
        ([folder / "good.bvh", "--unit", "m"], "100 times the size"),
        ([folder / "good.bvh", "--frames", "0,1"], "--frames is for keypoints, not for motion"),
        ([folder / "good.bvh", "--offset-s", "1", "--offset-frames", "3"], "one of them"),
        ([folder / "points.json", "--keypoints"], "anybody"),
        ([folder / "points.json", "--keypoints", "--fps", "30"], "not for --keypoints"),
    ]
    for arguments, words in cases:
        assert words in refused(capsys, folder, ["import", path, *arguments])


# --- as a start for tracking


def test_the_keys_of_segments_know_what_they_start_from(path: Path) -> None:
    session = load_session(path)
    templates = session.settings.model_copy(update={"initial": "templates"})
    (path.parent / "motion.bvh").write_text(bvh_of(SKELETON, TRUTH, 1 / 30))
    _run("import", path, path.parent / "motion.bvh")
    imported = load_session(path)
    keys = [
        segment_keys(s)[0, 24]
        for s in (
            session,
            session.changed({"settings": templates}),
            imported,
            imported.changed({"settings": templates}),
        )
    ]
    assert keys[1] == keys[3]  # what is not used does not count
    assert len(set(keys)) == 3


def _tracked(session: Session, path: Path, motion: Trajectory | None = None) -> TrackResult:
    with open_video_of(session, path) as video:
        for event in track_session(session, video, segments=[0], first_motion=motion):
            if isinstance(event, TrackFinished):
                return event.result
    raise AssertionError


@pytest.mark.parametrize(("method", "quality"), [("keypose", "preview"), ("paper", "full")])
def test_a_noisy_import_is_a_better_start_than_the_methods_own(
    path: Path, method: str, quality: str
) -> None:
    noise = np.random.default_rng(7).normal(0, 0.01, (len(TRUTH), SKELETON.part_count, 3))
    file = path.parent / "noisy.csv"
    names = NAMES[: SKELETON.part_count]
    file.write_text(_wide(TRUTH.joints(SKELETON)[:, : SKELETON.part_count] + noise, names))
    before = load_session(path)
    _run("import", path, file)
    motion = _imported(path)

    def error(session: Session, initial: str, motion: Trajectory | None) -> float:
        settings = {"method": method, "quality": quality, "initial": initial}
        chosen = session.settings.model_copy(update=settings)
        result = _tracked(session.changed({"settings": chosen}), path, motion)
        assert result.segments[0].closing_error < 1e-9
        found = evaluate(SKELETON, session.view.camera, result.trajectory, TRUTH, (0, 24))
        assert found.estimate.pixels is not None
        return found.estimate.pixels.overall.mean

    without, session = error(before, "auto", None), load_session(path)
    imported, auto = (error(session, initial, motion) for initial in ("import", "auto"))
    assert imported < without
    if method == "paper":
        assert auto == imported
    else:  # its own start may score as well
        assert auto <= without


def test_the_choice_that_is_left_to_the_tracker_is_the_start_that_scores_better(path: Path) -> None:
    """A motion far from the pictures changes nothing."""
    session = load_session(path)
    shaken = exp_rotation(np.random.default_rng(1).normal(0, 0.5, (73, 16, 3)))
    wrong = Trajectory(0, TRUTH.Rs_parent_part @ shaken, TRUTH.ps_camera_root + 0.3)
    usual, with_wrong = _tracked(session, path), _tracked(session, path, wrong)
    assert np.array_equal(
        usual.segments[0].trajectory.Rs_parent_part,
        with_wrong.segments[0].trajectory.Rs_parent_part,
    )
    with_truth = _tracked(session, path, TRUTH)
    assert min(with_truth.segments[0].scores) <= min(usual.segments[0].scores)


def test_the_command_tracks_from_the_motion_beside_the_session(path: Path) -> None:
    file = path.parent / "motion.bvh"
    file.write_text(bvh_of(SKELETON, TRUTH, 1 / 30))
    _run("import", path, file)
    session = load_session(path)
    settings = session.settings.model_copy(update={"initial": "import", "quality": "preview"})
    changes = {"settings": settings, "keyframes": session.subject.keyframes[:2]}
    session = session.changed(changes)
    save_session(session, path)
    _run("track", path)
    tracked = load_trajectory(load_session(path), path)
    expected = _tracked(session, path, _imported(path)).segments[0].trajectory
    assert np.array_equal(tracked.Rs_parent_part, expected.Rs_parent_part)
    out = path.parent / "out"
    assert _run("track", path, "--out", out) in (0, 1)
    assert np.array_equal(
        _imported(out / "session.json").Rs_parent_part, _imported(path).Rs_parent_part
    )


def test_import_is_asked_for_but_there_is_none(path: Path) -> None:
    session = load_session(path)
    settings = session.settings.model_copy(update={"initial": "import"})
    with pytest.raises(SessionError, match="no imported motion"):
        _tracked(session.changed({"settings": settings}), path)


def test_a_damaged_or_missing_motion_is_reported(path: Path) -> None:
    file = path.parent / "motion.bvh"
    file.write_text(bvh_of(SKELETON, TRUTH, 1 / 30))
    _run("import", path, file)
    session = load_session(path)
    assert session.subject.first_motion is not None
    place = path.parent / session.subject.first_motion.file
    content = place.read_bytes()
    place.write_bytes(content[:-40])
    with pytest.raises(SessionError, match="damaged"):
        load_first_motion(session, path.parent)
    place.unlink()
    with pytest.raises(SessionError, match="cannot be read"):
        load_first_motion(session, path.parent)


def test_a_copied_session_takes_its_imported_motion_along(path: Path, tmp_path: Path) -> None:
    file = path.parent / "motion.bvh"
    file.write_text(bvh_of(SKELETON, TRUTH, 1 / 30))
    _run("import", path, file)
    copied = copy_session(path, tmp_path / "copy")
    assert np.array_equal(_imported(copied).Rs_parent_part, _imported(path).Rs_parent_part)


def test_a_joint_of_another_name_is_known_once_it_is_said(path: Path) -> None:
    names = [{"left_hand": "grip"}.get(name, name) for name in NAMES]
    file = path.parent / "motion.csv"
    file.write_text(_wide(TRUTH.joints(SKELETON), names), newline="")
    for message, known in (([], False), (["--map", "grip=left_hand"], True)):
        assert _run("import", path, file, *message) == 0
        reference = load_session(path).subject.first_motion
        assert reference is not None
        assert (reference.matched.get("grip") == "left_hand") == known


# --- keypoints


def _keypoints(layout: str, noise: float = 0.0) -> Keypoints:
    """What a perfect detector sees of the true motion."""
    names = LAYOUTS[layout]
    known = matched(SKELETON, names, "a.json")
    laid, rng = BodyPoints(SKELETON, tuple(known.places)), np.random.default_rng(3)
    uv, visibility = (
        np.full((len(TRUTH), len(names), 2), np.nan),
        np.zeros((len(TRUTH), len(names))),
    )
    for frame in range(len(TRUTH)):
        ps = laid.at(pose_transforms(SKELETON, TRUTH.pose(frame)))
        seen = SESSION.view.camera.project(ps) + rng.normal(0, noise, (len(ps), 2))
        uv[frame, known.indices] = seen
    visibility[:, known.indices] = 1.0
    return Keypoints(0, names, uv, visibility)


def _coco(keypoints: Keypoints) -> list[dict[str, Any]]:
    """The same as a list of annotations."""
    tables = np.concatenate([np.nan_to_num(keypoints.uv), keypoints.visibility[..., None]], axis=-1)
    return [
        {"image_id": keypoints.first_frame + n, "keypoints": table.ravel().tolist()}
        for n, table in enumerate(tables)
    ]


def _judged(draft: Any) -> tuple[float, float]:
    """Mean distance of all joints in pixels, and how the root is turned, degrees."""
    pose, truth = draft.keyframe.pose(SKELETON), TRUTH.pose(draft.keyframe.frame)
    uv, uv_true = (
        SESSION.view.camera.project(pose_transforms(SKELETON, p)[:, :3, 3]) for p in (pose, truth)
    )
    turn = log_rotation(pose.Rs_parent_part[0].T @ truth.Rs_parent_part[0])
    away = np.linalg.norm(uv - uv_true, axis=-1).mean()
    return float(away), float(np.degrees(np.linalg.norm(turn)))


def _drafts(session: Session, keypoints: Keypoints, frames: list[int]) -> tuple[Draft, ...]:
    known = match_keypoints(session, keypoints, "a.json")
    return drafts_of(session, keypoints, known, frames, TIMES_S)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("keyed", [False, True])
def test_exact_keypoints_give_the_right_pose_facing_the_right_way(layout: str, keyed: bool) -> None:
    session = SESSION if keyed else SESSION.changed({"keyframes": ()})
    drafts = _drafts(session, _keypoints(layout), [6, 66])
    assert [draft.keyframe.frame for draft in drafts] == [6, 66]
    for draft in drafts:
        away, turn = _judged(draft)
        assert away < 1.0
        assert turn < 15.0
        assert draft.converged
        assert not draft.doubtful


def test_keypoints_as_a_detector_sees_them_still_give_the_right_side() -> None:
    session = SESSION.changed({"keyframes": SESSION.subject.keyframes[:1]})
    for draft in _drafts(session, _keypoints("COCO_17", noise=2.0), [12, 36]):
        away, turn = _judged(draft)
        assert away < 6.0
        assert turn < 30.0


def test_drafts_never_stand_over_a_keyframe_or_another_draft(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = load_session(path)
    file = path.parent / "points.json"
    file.write_text(json.dumps(_coco(_keypoints("COCO_17"))))
    assert _run("import", path, file, "--keypoints", "--frames", "24,30,48") == 0
    once = load_session(path)
    assert once.subject.keyframes == before.subject.keyframes
    assert [draft.frame for draft in once.subject.drafts] == [30]
    assert once.subject.drafts[0].time_s == pytest.approx(1.0)
    assert _run("import", path, file, "--keypoints", "--frames", "30,36", "--exchange") == 0
    twice = load_session(path)
    assert twice.subject.drafts[0] == once.subject.drafts[0]
    assert [draft.frame for draft in twice.subject.drafts] == [30, 36]
    content = everything_in(path.parent)
    assert "Nothing was changed." not in capsys.readouterr().out
    assert _run("import", path, file, "--keypoints", "--frames", "30,36,48") == 0
    assert everything_in(path.parent) == content
    assert capsys.readouterr().out.endswith("Left as posed: 30, 36, 48\nNothing was changed.\n")


@pytest.mark.parametrize("layout", ["BODY_25", "BODY_25B", "HALPE_26"])
def test_a_file_that_does_not_name_its_keypoints_gives_drafts_of_the_right_ones(
    path: Path, layout: str
) -> None:
    file = path.parent / "points.json"
    file.write_text(json.dumps(_coco(_keypoints(layout))))
    assert _run("import", path, file, "--keypoints", "--frames", "30") == 0
    (draft,) = load_session(path).subject.drafts
    truth = pose_transforms(SKELETON, TRUTH.pose(30))[:, :3, 3]
    ours = pose_transforms(SKELETON, draft.pose(SKELETON))[:, :3, 3]
    away = SESSION.view.camera.project(ours) - SESSION.view.camera.project(truth)
    assert np.linalg.norm(away, axis=-1).mean() < 1.0


def test_what_the_limbs_do_not_show_is_asked_for_and_reported_by_the_option(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    seen = _keypoints("BODY_25B")
    arms = ("nose", "left_shoulder", "right_shoulder", "left_elbow", "left_wrist", "left_hip")
    visibility = np.zeros_like(seen.visibility)
    visibility[30, [seen.names.index(name) for name in arms]] = 1.0
    file = path.parent / "points.json"
    file.write_text(json.dumps(_coco(Keypoints(0, seen.names, seen.uv, visibility))))
    message = refused(capsys, path.parent, ["import", path, file, "--keypoints"])
    assert "BODY_25 or BODY_25B. Choose with --layout." in message
    assert _run("import", path, file, "--keypoints", "--layout", "body_25b") == 0
    assert [draft.frame for draft in load_session(path).subject.drafts] == [30]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"images": [{"id": 30, "width": 99, "height": 99}]}, "99 × 99"),
        ({"info": {"fps": 12.5}}, "12.5 frames a second"),
        ({"annotations": [{"image_id": 4000, "keypoints": [9.0] * 51}]}, "frames 4000 to 4000"),
        ({"annotations": [{"image_id": 4, "keypoints": [[1, 2, 3]]}]}, "in turn"),
    ],
)
def test_keypoints_of_another_video_leave_the_session_as_it_was(
    path: Path, capsys: pytest.CaptureFixture[str], changes: dict[str, Any], words: str
) -> None:
    file = path.parent / "points.json"
    file.write_text(json.dumps({"annotations": _coco(_keypoints("COCO_17")), **changes}))
    assert words in refused(capsys, path.parent, ["import", path, file, "--keypoints"])


def test_every_labelled_picture_is_drafted_where_they_lie_far_apart(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(path).changed({"keyframes": ()})
    save_session(session, path)
    seen, file = _coco(_keypoints("COCO_17")), path.parent / "points.json"
    labelled = [{**seen[n], "image_id": n + 1} for n in (3, 5, 30, 70)] + [
        {**seen[0], "image_id": 74}
    ]
    file.write_text(json.dumps(labelled))
    assert _run("import", path, file, "--keypoints", "--offset-frames", "-1") == 0
    assert [draft.frame for draft in load_session(path).subject.drafts] == [3, 30, 70]
    assert "Note: Left out 1 frame outside the video" in capsys.readouterr().err


def test_exchanged_keypoints_give_the_body_its_sides_back() -> None:
    session = SESSION.changed({"keyframes": ()})
    wrong = _keypoints("BODY_25").exchanged()
    for draft in _drafts(session, wrong.exchanged(), [36]):
        assert _judged(draft)[0] < 1.0
    for draft in _drafts(session, wrong, [36]):
        assert _judged(draft)[0] > 3.0


def test_a_body_without_such_joints_is_reported(tmp_path: Path) -> None:
    box = recordings.session("box")
    with pytest.raises(FormatError, match=r"names 0 places of .* say where others lie"):
        _drafts(box, _keypoints("COCO_17"), [3])
    motion = JointMotion(("a", "b", "c"), np.zeros((5, 3, 3)), np.arange(5.0), "y up", "m")
    with pytest.raises(FormatError, match="name their counterparts"):
        fit_to_session(box, motion, "a.bvh", TIMES_S)


def test_a_session_saved_before_imports_existed_is_read(path: Path) -> None:
    data = json.loads(path.read_text("utf-8"))
    data.pop("first_motion", None)
    path.write_text(json.dumps(data))
    session = load_session(path)
    assert session.subject.first_motion is None
    assert session.settings.initial == "auto"
    save_session(session, path)
    assert load_session(path) == session


@pytest.mark.parametrize("keyed", [False, True])
def test_keypoints_before_a_camera_that_moves_and_zooms_are_met_where_they_are_seen(
    keyed: bool,
) -> None:
    session, seen = _before_a_moving_camera()
    session = session if keyed else session.changed({"keyframes": ()})
    keypoints = _keypoints("COCO_17")
    known = matched(SKELETON, keypoints.names, "a.json")
    laid, uv = BodyPoints(SKELETON, tuple(known.places)), keypoints.uv.copy()
    for frame in range(len(TRUTH)):
        ps = laid.at(pose_transforms(SKELETON, seen.pose(frame)))
        uv[frame, known.indices] = session.film_camera.at(frame).project(ps)
    for draft in _drafts(session, replace(keypoints, uv=uv), [6, 36, 66]):
        found, truth = draft.keyframe.pose(SKELETON), seen.pose(draft.keyframe.frame)
        assert draft.miss_px < 1.0
        assert found.p_camera_root[2] == pytest.approx(truth.p_camera_root[2], rel=0.05)
        turn = log_rotation(found.Rs_parent_part[0].T @ truth.Rs_parent_part[0])
        assert np.degrees(np.linalg.norm(turn)) < 15.0
