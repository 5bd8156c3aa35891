"""A second film of a motion is added, synchronised with the first, and tracked with."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from threading import Event

import av
import cv2
import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.document.new import new_session
from keypose.app.document.open import copy_session
from keypose.app.jobs import seen_in_films
from keypose.app.jobs.adding_film import AddFilm, PlaceFilm
from keypose.app.jobs.batch import make_session
from keypose.app.jobs.batch.task import Task
from keypose.app.jobs.job import Failed, Finished, Progress
from keypose.app.orders.film import FilmToDraft
from keypose.tracker import TrackFinished, keypoints_of_session, open_video_of, track_session
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.errors import SessionError
from keypose.tracker.films.cameras import joints_of_pose
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.film_clock import FilmClock, sampled
from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    log_rotation,
    rotation_from_euler,
    transform,
)
from keypose.tracker.keypoints.find_people import FoundPerson, PeopleInFilm
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.keypoints.region import Box
from keypose.tracker.operations.films import close_all, films_beside, open_other_films
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.views import Clock
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.fingerprints import segment_keys
from keypose.tracker.storage.results import load_results
from keypose.tracker.storage.sidecars import save_keypoints
from keypose.tracker.video import Video
from tests.app.jobs.job_cases import reported
from tests.rendering.motions import crossing, throw

SIZE = 320, 180
SKELETON = Skeleton.of(preset("adult_male"))
CLOCK = FilmClock(3.4)
KEYS = (20, 70)
R_SIDE = rotation_from_euler(0.05, np.radians(65.0), 0.08)
BOX = (100.0, 20.0, 220.0, 170.0)
FROM_THE_SIDE = ("--box", "100,20,220,170")


def joints_of(motion: Callable[[Skeleton], Trajectory]) -> Array:
    path = motion(SKELETON)
    frames = range(path.first_frame, path.last_frame + 1)
    return np.stack([joints_of_pose(SKELETON, path.pose(frame)) for frame in frames])


JOINTS_M = joints_of(throw)
MIDDLE = np.median(JOINTS_M.reshape(-1, 3), axis=0)
T_SIDE = transform(R_SIDE, MIDDLE - R_SIDE @ MIDDLE + np.array([0.3, 0.1, 0.4]))


def write_video(path: Path, frames: int, seed: int, *, moves: bool = False) -> Path:
    """A wall before a camera that stands still, or shakes: nobody is to be seen."""
    rng = np.random.default_rng(seed)
    wall = rng.integers(0, 255, (SIZE[1], SIZE[0], 3), dtype=np.uint8)
    wall = cv2.resize(wall[::4, ::4], SIZE)
    with av.open(path, "w") as file:
        stream = file.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        for _ in range(frames):
            shift = tuple(rng.integers(-12, 13, 2).tolist()) if moves else (0, 0)
            picture = np.roll(wall, shift, axis=(0, 1))
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, "rgb24")))
        file.mux(stream.encode())
    return path


def keypoints_of(joints: Array, camera: Camera, seed: int) -> Keypoints:
    """What a detector says of joints (N, J, 3) before a camera."""
    rng = np.random.default_rng(seed)
    uv = camera.project(joints)
    height = camera.fy * 1.7 / float(np.nanmedian(joints[..., 2]))
    uv = uv + rng.normal(0.0, 0.005 * height, uv.shape)
    hips = joints - joints[:, 6:8].mean(axis=1, keepdims=True)
    hips = hips + rng.normal(0.0, 0.05, hips.shape)
    seen = np.isfinite(uv).all(axis=-1)
    return Keypoints(0, JOINTS, uv, seen.astype(float), hips)


def deeper(pose: Pose) -> Pose:
    """A pose that looks right from the front: limbs nearer or farther than they are."""
    R = pose.Rs_parent_part.copy()
    for name, rad in (("left_upper_arm", 0.7), ("right_thigh", -0.4), ("waist", 0.2)):
        part = SKELETON.body.index(name)
        R[part] = R[part] @ exp_rotation(np.array([rad, 0.0, 0.0]))
    return Pose(R, pose.p_camera_root * 1.02)


def begun(folder: Path, *, wrong: bool = False) -> Path:
    """A session of the first film, with two keyframes and a detector's keypoints."""
    path = folder / "session.json"
    with Video.open(write_video(folder / "front.mp4", len(JOINTS_M), 1)) as video:
        session = new_session(video, path)
    camera = Camera.from_focal_length(*SIZE, 30.0)
    motion = throw(SKELETON)
    poses = {frame: motion.pose(frame) for frame in KEYS}
    keyframes = tuple(
        Keyframe.of(SKELETON, deeper(pose) if wrong else pose, frame, frame / 30)
        for frame, pose in poses.items()
    )
    settings = session.settings.model_copy(update={"cues": ("keypoints",), "smooth": False})
    session = session.changed(
        {
            "camera": camera,
            "lens_source": "person",
            "body": SKELETON.body,
            "keyframes": keyframes,
            "settings": settings,
        }
    )
    session = save_keypoints(session, path, keypoints_of(JOINTS_M, camera, 1), "a detector")
    save_session(session, path)
    return path


@pytest.fixture
def side(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The second film, taken from the side and 3.4 frames later, in which a detector sees him."""
    count = len(JOINTS_M) - 8
    seen_in(monkeypatch, JOINTS_M, count)
    return write_video(tmp_path / "side.mp4", count, 2)


class Network:
    """Of nobody's: what it sees is given."""

    fingerprint = "seen by nobody"


def detected(monkeypatch: pytest.MonkeyPatch, keypoints: Keypoints) -> None:
    """What the detector sees in the second film."""
    monkeypatch.setattr(seen_in_films, "detect", lambda *_, **__: keypoints)
    monkeypatch.setattr(seen_in_films, "open_detector", lambda model: Network())
    monkeypatch.setattr(seen_in_films, "find_model", find_model)


def seen_in(
    monkeypatch: pytest.MonkeyPatch,
    joints: Array,
    count: int,
    T: Array = T_SIDE,
    clock: FilmClock = CLOCK,
) -> None:
    """What the detector sees in the second film: joints by their camera and clock."""
    there = sampled(joints, clock.moments_of(np.arange(count)))
    there = there @ T[:3, :3].T + T[:3, 3]
    detected(monkeypatch, keypoints_of(there, Camera.guess(*SIZE), 2))


def added(path: Path, film: Path, *more: str) -> Session:
    assert main(["add-film", str(path), str(film), *FROM_THE_SIDE, *more]) == 0
    return load_session(path)


def about_hips(joints: Array) -> Array:
    return joints - joints[:, 6:8].mean(axis=1, keepdims=True)


def off_mm(path: Path) -> float:
    """How far joints are from the truth between the keyframes."""
    session = load_session(path)
    fitting = load_results(session, path).fitting(session)
    motion = joined([fitting[span].trajectory for span in sorted(fitting)])
    frames = range(KEYS[0] + 1, KEYS[1])
    joints = np.stack([joints_of_pose(SKELETON, motion.pose(frame)) for frame in frames])
    return 1000 * float(
        np.linalg.norm(joints - JOINTS_M[frames.start : frames.stop], axis=-1).mean()
    )


def test_its_clock_and_its_camera_are_found_and_kept(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    session = added(path, side)
    first, other = session.views
    assert other.id == "film-2"
    assert other.clock is not None
    assert abs(other.clock.begins - CLOCK.begins) < 0.3
    R = other.T_camera_world[:3, :3] @ R_SIDE.T
    assert np.degrees(np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))) < 4.0
    assert other.keypoints is not None
    assert (tmp_path / other.keypoints.file).is_file()
    assert first.camera == Camera.from_focal_length(*SIZE, 30.0)
    said = capsys.readouterr().out
    assert "side.mp4 begins 3." in said
    assert "Its camera stands" in said


def test_two_films_track_nearer_to_the_truth_than_one(tmp_path: Path, side: Path) -> None:
    path = begun(tmp_path)
    main(["track", str(path)])
    alone = off_mm(path)
    added(path, side)
    main(["track", str(path)])
    assert off_mm(path) < 0.6 * alone


def test_keyframes_that_were_posed_in_one_film_are_mended_and_that_is_said(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path, wrong=True)
    before = load_session(path).subject.keyframes
    after = added(path, side).subject.keyframes

    def off(keyframes: tuple[Keyframe, ...]) -> float:
        joints = np.stack([joints_of_pose(SKELETON, each.pose(SKELETON)) for each in keyframes])
        away = about_hips(joints) - about_hips(JOINTS_M[list(KEYS)])
        return float(np.linalg.norm(away, axis=-1).mean())

    assert off(after) < 0.5 * off(before)
    assert "2 keyframes were mended by what all films show" in capsys.readouterr().out


def test_who_is_not_looked_for_in_it_is_said_and_the_floor_of_one_film_is_left(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    session = load_session(path).changed({"floor_m": -1.4})
    partner = session.subject.model_copy(update={"id": "partner", "called": "Ben"})
    save_session(session.model_copy(update={"bodies": (session.subject, partner)}), path)
    assert added(path, side).world.floor_m is None
    words = capsys.readouterr().out
    assert "The floor was that of the first film alone: stand on the floor again" in words
    assert "Ben is not looked for in it: there its pictures count alone." in words


def test_a_dry_run_says_the_same_and_writes_nothing(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    added(path, side, "--dry-run", "--json")
    finished = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert abs(finished["begins"] - CLOCK.begins) < 0.3
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


def test_where_it_begins_may_be_said(tmp_path: Path, side: Path) -> None:
    other = added(begun(tmp_path), side, "--begins", "4.25").views[1]
    assert other.clock is not None
    assert other.clock.begins == 4.25
    assert other.clock.sigma is None


def test_of_a_calibration_the_right_cameras_are_taken_and_refined(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    K = Camera.from_focal_length(*SIZE, 30.0)
    turned = T_SIDE.copy()
    turned[:3, :3] = rotation_from_euler(0.02, 0.05, -0.03) @ turned[:3, :3]
    behind = transform(rotation_from_euler(0.0, 2.5, 0.0), np.array([0.5, 0.0, 6.0]))
    rig = tmp_path / "rig.toml"
    rig.write_text(
        "\n".join(
            f"[{name}]\nsize = {list(SIZE)}\n"
            f"matrix = {K.K.tolist()}\ndistortions = [0, 0, 0, 0]\n"
            f"rotation = {log_rotation(T[:3, :3]).tolist()}\n"
            f"translation = {(1000 * T[:3, 3]).tolist()}\n"
            for name, T in (("b", turned), ("c", behind), ("a", np.eye(4)))
        ),
        encoding="utf-8",
    )
    other = added(path, side, "--calibration", str(rig)).views[1]
    said = capsys.readouterr().out
    assert "rig.toml: the films are its cameras a and b." in said
    assert "turned by" in said
    assert other.lens_source == "calibration"
    assert other.placed is not None
    assert other.placed.source == "file"
    apart_m = float(np.linalg.norm(turned[:3, 3]))
    assert other.placed.measured_m == pytest.approx(apart_m, abs=1e-3), "the file is in millimetres"
    R = other.T_camera_world[:3, :3] @ R_SIDE.T
    assert np.degrees(np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))) < 2.5


def test_a_calibration_of_another_setup_is_refused(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    rig = tmp_path / "rig.toml"
    K = Camera.from_focal_length(*SIZE, 30.0).K.tolist()
    rig.write_text(
        "\n".join(
            f"[{name}]\nsize = {list(SIZE)}\nmatrix = {K}\ndistortions = [0, 0, 0, 0]\n"
            f"rotation = [0, {turn}, 0]\ntranslation = [{turn}, 0, 0]\n"
            for name, turn in (("a", 0.0), ("b", 2.5))
        ),
        encoding="utf-8",
    )
    before = path.read_bytes()
    words = ["add-film", str(path), str(side), *FROM_THE_SIDE, "--calibration", str(rig)]
    assert main(words) == 2
    assert "rig.toml does not fit these films" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_another_clock_of_the_film_makes_what_was_tracked_outdated(
    tmp_path: Path, side: Path
) -> None:
    path = begun(tmp_path)
    keys = [segment_keys(load_session(path))]
    session = added(path, side)
    keys.append(segment_keys(session))
    view = session.views[1]
    assert view.clock is not None
    later = view.clock.model_copy(update={"begins": view.clock.begins + 1})
    moved = view.model_copy(update={"clock": later})
    keys.append(segment_keys(session.model_copy(update={"views": (session.view, moved)})))
    assert len({tuple(each.values()) for each in keys}) == 3


def test_a_copy_in_another_folder_has_both_films(tmp_path: Path, side: Path) -> None:
    path = begun(tmp_path)
    added(path, side)
    copy = copy_session(path, tmp_path / "elsewhere")
    session = load_session(copy)
    videos = open_other_films(session, copy)
    beside = films_beside(session, videos, copy.parent)
    close_all(videos)
    assert [view.video.frame_count for view in session.views[1:]] == [len(JOINTS_M) - 8]
    assert beside[0].keypoints is not None


def test_from_python_too_a_session_is_tracked_by_all_its_films(tmp_path: Path, side: Path) -> None:
    path = begun(tmp_path)
    session = added(path, side)
    keypoints = keypoints_of_session(session, tmp_path)
    videos = open_other_films(session, path)
    with open_video_of(session, path) as video:
        with pytest.raises(SessionError, match="The session has 2 films, and 1 are given"):
            list(track_session(session, video, keypoints=keypoints))
        films = films_beside(session, videos, tmp_path)
        *_, last = track_session(session, video, keypoints=keypoints, films=films)
    close_all(videos)
    assert isinstance(last, TrackFinished)
    main(["track", str(path)])
    fitting = load_results(load_session(path), path).fitting(session)
    tracked = fitting[KEYS].as_tracked.trajectory
    np.testing.assert_array_equal(
        last.result.segments[0].trajectory.ps_camera_root, tracked.ps_camera_root
    )


def test_a_film_that_is_gone_is_named_in_one_sentence(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    added(path, side)
    side.unlink()
    capsys.readouterr()
    assert main(["track", str(path)]) == 2
    said = capsys.readouterr().err
    assert "side.mp4" in said
    assert "is missing" in said


def made(path: Path, film: Path, side: Path) -> tuple[str, ...]:
    """A session that was begun without a hand, gone on with; what was decided."""
    first = FilmToDraft(film, beside=(side,))
    task = Task(path, film=first)
    asked = make_session._asked(task, first)
    record = make_session._Record(asked=asked, frame=0, box=BOX)
    make_session._write_record(record, path)
    make_session.make_session(task, first, lambda step: None, Event())
    return make_session.notes_of(path)


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """One person is found in the other film."""
    people = PeopleInFilm(0, (FoundPerson(BOX, 1.0),), {})
    monkeypatch.setattr(seen_in_films, "people_seen", lambda *_: people)


@pytest.mark.usefixtures("alone")
def test_without_a_hand_the_other_film_is_added_once_and_said(tmp_path: Path, side: Path) -> None:
    path = begun(tmp_path)
    notes = made(path, tmp_path / "front.mp4", side)
    assert any(words.startswith("side.mp4 begins 3.") for words in notes)
    assert len(load_session(path).views) == 2
    made(path, tmp_path / "front.mp4", side)
    assert len(load_session(path).views) == 2


@pytest.mark.usefixtures("alone")
def test_without_a_hand_a_film_of_another_motion_is_left_out_and_that_is_said(
    tmp_path: Path, side: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen_in(monkeypatch, joints_of(crossing), len(JOINTS_M) - 8)
    path = begun(tmp_path)
    notes = " ".join(made(path, tmp_path / "front.mp4", side))
    assert "side.mp4 was left out. side.mp4 and front.mp4 show no motion in common" in notes
    assert len(load_session(path).views) == 1


def test_a_film_of_another_motion_is_refused_in_one_sentence(
    tmp_path: Path, side: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    seen_in(monkeypatch, joints_of(crossing), len(JOINTS_M) - 8)
    before = path.read_bytes()
    assert main(["add-film", str(path), str(side), *FROM_THE_SIDE]) == 2
    said = capsys.readouterr().err
    assert "side.mp4 and front.mp4 show no motion in common" in said
    assert said.count("\n") == 1
    assert path.read_bytes() == before


@pytest.mark.parametrize(("turned_deg", "words"), [(3.0, "looks at the person as"), (170.0, "")])
def test_films_from_the_same_side_are_refused_and_from_the_other_said(
    tmp_path: Path,
    side: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    turned_deg: float,
    words: str,
) -> None:
    path = begun(tmp_path)
    R = rotation_from_euler(0.0, np.radians(turned_deg), 0.0)
    T = transform(R, MIDDLE - R @ MIDDLE)
    seen_in(monkeypatch, JOINTS_M, len(JOINTS_M) - 8, T)
    code = main(["add-film", str(path), str(side), *FROM_THE_SIDE])
    said = capsys.readouterr()
    assert code == (2 if words else 0)
    assert words in said.err
    assert words or "from the other side" in said.out


def test_the_same_film_twice_is_refused(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    added(path, side)
    capsys.readouterr()
    for film in (side, tmp_path / "front.mp4"):
        assert main(["add-film", str(path), str(film), *FROM_THE_SIDE]) == 2
        assert capsys.readouterr().err == "This film is in the session already.\n"


def pan(count: int) -> Array:
    """(N, 3, 3) of a hand that follows the throw: the base in the camera's frame."""
    along = np.linspace(0.0, 1.0, count)
    turns = np.stack([0.02 * np.sin(7 * along), 0.14 * np.sin(3 * along), 0.0 * along], axis=1)
    return exp_rotation(turns)


def write_panned(path: Path, Rs_camera_base: Array) -> Path:
    """A wall far away before a camera that turns."""
    rng = np.random.default_rng(7)
    wall = rng.integers(0, 255, (SIZE[1] // 3, SIZE[0] // 3, 3), dtype=np.uint8)
    wall = cv2.resize(wall, (3 * SIZE[0], 3 * SIZE[1]), interpolation=cv2.INTER_CUBIC)
    camera = Camera.guess(*SIZE)
    K = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1.0]])
    in_wall = np.array([[1.0, 0, SIZE[0]], [0, 1, SIZE[1]], [0, 0, 1]]) @ K
    with av.open(path, "w") as file:
        stream = file.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        for R in Rs_camera_base:
            H = in_wall @ R.T @ np.linalg.inv(K)
            picture = cv2.warpPerspective(
                wall, H, SIZE, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            )
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, "rgb24")))
        file.mux(stream.encode())
    return path


def test_a_film_that_a_hand_holds_is_followed_by_its_background_and_tracked_with_the_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path, count = begun(tmp_path), len(JOINTS_M) - 8
    main(["track", str(path)])
    alone_mm = off_mm(path)
    Rs = pan(count)
    there = sampled(JOINTS_M, CLOCK.moments_of(np.arange(count))) @ T_SIDE[:3, :3].T + T_SIDE[:3, 3]
    seen = np.einsum("nab,njb->nja", Rs, there)
    detected(monkeypatch, keypoints_of(seen, Camera.guess(*SIZE), 2))
    session = added(path, write_panned(tmp_path / "hand.mp4", Rs))
    other = session.views[1]
    assert other.camera_motion is not None
    assert other.clock is not None
    assert abs(other.clock.begins - CLOCK.begins) < 0.4
    assert "Its camera moves; as the film begins it is" in capsys.readouterr().out
    main(["track", str(path)])
    assert off_mm(path) < 0.7 * alone_mm


def in_turn(monkeypatch: pytest.MonkeyPatch, *people: Keypoints) -> None:
    """What the detector sees of one person after the other."""
    left = list(people)
    monkeypatch.setattr(seen_in_films, "detect", lambda *_, **__: left.pop(0))


def test_of_several_people_the_one_is_taken_who_moves_as_in_the_first_film(
    tmp_path: Path,
    side: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path, camera = begun(tmp_path), Camera.guess(*SIZE)
    there = sampled(JOINTS_M, CLOCK.moments_of(np.arange(COUNT))) @ T_SIDE[:3, :3].T + T_SIDE[:3, 3]
    another = joints_of(crossing)
    another = sampled(another, np.linspace(0, len(another) - 1, COUNT))
    person_in(monkeypatch, (10, 20, 90, 170), BOX)
    in_turn(monkeypatch, keypoints_of(another, camera, 5), keypoints_of(there, camera, 2))
    assert main(["add-film", str(path), str(side)]) == 0
    assert "Of 2 people in side.mp4 the one was taken who moves as" in capsys.readouterr().out
    clock = load_session(path).views[1].clock
    assert clock is not None
    assert abs(clock.begins - CLOCK.begins) < 0.3


def test_of_two_people_who_move_alike_it_is_asked_who_is_meant(
    tmp_path: Path, side: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, camera = begun(tmp_path), Camera.guess(*SIZE)
    there = sampled(JOINTS_M, CLOCK.moments_of(np.arange(COUNT))) @ T_SIDE[:3, :3].T + T_SIDE[:3, 3]
    before = path.read_bytes()
    person_in(monkeypatch, (10, 20, 90, 170), BOX)
    in_turn(monkeypatch, *(keypoints_of(there, camera, seed) for seed in (2, 3)))
    assert main(["add-film", str(path), str(side)]) == 2
    assert path.read_bytes() == before


def test_a_film_whose_camera_cannot_be_followed_is_not_placed_wrongly(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    before = path.read_bytes()
    write_video(side, len(JOINTS_M) - 8, 2, moves=True)
    assert main(["add-film", str(path), str(side), *FROM_THE_SIDE]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert path.read_bytes() == before


def refused(path: Path, film: Path, *more: str) -> None:
    """Adding a film ends with 2, and the session is as it was."""
    before = path.read_bytes()
    assert main(["add-film", str(path), str(film), *FROM_THE_SIDE, *more]) == 2
    assert path.read_bytes() == before


COUNT = len(JOINTS_M) - 8
T_OTHER = transform(rotation_from_euler(0.0, np.radians(-60.0), 0.0), np.array([0.2, 0.1, 6.0]))
THERE = sampled(JOINTS_M, CLOCK.moments_of(np.arange(COUNT)))
FROM_SIDE = THERE @ T_SIDE[:3, :3].T + T_SIDE[:3, 3]
ELSEWHERE = np.concatenate([FROM_SIDE[:60], joints_of(crossing)[: COUNT - 60]])
UNSEEN = np.full_like(FROM_SIDE, np.nan)
BAD_FILMS = {
    "another scene follows": (
        ELSEWHERE,
        "Only frames 0 to 60 of side.mp4 show what front.mp4 shows: it may be cut there",
    ),
    "nobody is seen in it": (UNSEEN, "The person is seen well in 0 frames of side.mp4"),
    "he is seen for a moment": (
        np.concatenate([FROM_SIDE[:7], UNSEEN[7:]]),
        "The person is seen well in 7 frames of side.mp4",
    ),
    "a copy of the first film": (JOINTS_M, "side.mp4 looks at the person as the first film does"),
    "a copy from its tenth frame on": (
        JOINTS_M[10:],
        "side.mp4 looks at the person as the first film does",
    ),
}


@pytest.mark.parametrize(("joints", "words"), BAD_FILMS.values(), ids=BAD_FILMS)
def test_a_film_that_shows_no_second_view_is_refused_in_one_sentence_also_on_the_page(
    tmp_path: Path,
    side: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    joints: Array,
    words: str,
) -> None:
    path = begun(tmp_path)
    seen = np.nan_to_num(joints[:COUNT], nan=1.0)
    keypoints = keypoints_of(seen, Camera.from_focal_length(*SIZE, 30.0), 2)
    visibility = np.isfinite(joints[:COUNT, :, 0]).astype(float)
    detected(monkeypatch, replace(keypoints, visibility=visibility))
    person_in(monkeypatch, BOX)
    refused(path, side)
    said = capsys.readouterr().err
    assert said.startswith(words)
    assert said.count("\n") == 1
    *_, end = reported(asked_on_the_page(path, side), None)
    assert isinstance(end, Failed)
    assert end.words == said.strip()


def test_a_film_that_would_show_nothing_of_the_first_one_s_time_is_refused(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    for begins in ("500", "-300"):
        refused(path, side, f"--begins={begins}")
        assert "side.mp4 would show nothing of the first film's time" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("clock", "words"),
    [
        (FilmClock(2.0, 2.0), "side.mp4 shows the motion 2 times slower than front.mp4"),
        (FilmClock(2.0, 0.5), "front.mp4 shows the motion 2 times slower than side.mp4"),
    ],
)
def test_slow_motion_that_nobody_has_spoken_of_is_named(
    tmp_path: Path,
    side: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    clock: FilmClock,
    words: str,
) -> None:
    count = int((len(JOINTS_M) - 4) * clock.rate)
    seen_in(monkeypatch, JOINTS_M, count, clock=clock)
    write_video(side, count, 2)
    refused(begun(tmp_path), side)
    assert words in capsys.readouterr().err


def test_a_clock_that_runs_otherwise_than_its_file_says_is_found_and_said(
    tmp_path: Path, side: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = FilmClock(1.5, 1.025)
    count = int((len(JOINTS_M) - 3) * clock.rate)
    seen_in(monkeypatch, JOINTS_M, count, clock=clock)
    write_video(side, count, 2)
    other = added(begun(tmp_path), side).views[1]
    assert other.film_clock.rate == pytest.approx(1.025, abs=0.003)
    assert "side.mp4 is played 2." in capsys.readouterr().out


@pytest.mark.parametrize(("size", "code"), [((640, 360), 0), ((300, 400), 2)])
@pytest.mark.parametrize("order", ["abc", "cab", "bca"])
def test_a_calibration_has_its_cameras_in_any_order_and_in_pictures_of_the_same_shape(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str],
    size: tuple[int, int], code: int, order: str
) -> None:  # fmt: skip
    path = begun(tmp_path)
    before = path.read_bytes()
    K = Camera.from_focal_length(*size, 30.0).K.tolist()
    Ts = {"a": np.eye(4), "b": T_SIDE, "c": T_OTHER}
    rig = tmp_path / "rig.toml"
    rig.write_text(
        "\n".join(
            f"[{name}]\nsize = {list(size)}\nmatrix = {K}\ndistortions = [0, 0, 0, 0]\n"
            f"rotation = {log_rotation(Ts[name][:3, :3]).tolist()}\n"
            f"translation = {Ts[name][:3, 3].tolist()}\n"
            for name in order
        ),
        encoding="utf-8",
    )
    words = ["add-film", str(path), str(side), *FROM_THE_SIDE, "--calibration", str(rig)]
    assert main(words) == code
    said = capsys.readouterr()
    if code:
        assert path.read_bytes() == before
        assert said.err.startswith("rig.toml")
        assert said.err.count("\n") == 1
    else:
        assert "rig.toml: the films are its cameras a and b." in said.out


def test_of_slow_motion_the_rate_is_said(
    tmp_path: Path, side: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = 2 * (len(JOINTS_M) - 8)
    seen_in(monkeypatch, JOINTS_M, count, clock=FilmClock(3.4, 2.0))
    write_video(side, count, 2)
    other = added(begun(tmp_path), side, "--recorded-fps", "60").views[1]
    assert other.clock is not None
    assert other.clock.rate == 2.0
    assert abs(other.clock.begins - 3.4) < 0.3


def test_a_frame_at_which_nothing_of_both_fits_is_refused(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    assert main(["add-film", str(path), str(side), *FROM_THE_SIDE, "--begins", "60"]) == 2
    assert "no motion in common where it begins at 60" in capsys.readouterr().err


def test_left_and_right_that_a_detector_exchanges_in_the_other_film_are_set_right(
    tmp_path: Path, side: Path
) -> None:
    path = begun(tmp_path)
    added(path, side)
    main(["track", str(path)])
    right = off_mm(path)
    session = load_session(path)
    keypoints = keypoints_of_session(session.alone("film-2"), tmp_path)
    assert keypoints is not None
    rows = slice(30, 61)
    uv = keypoints.uv.copy()
    uv[rows] = keypoints.exchanged().uv[rows]
    alone = save_keypoints(session.alone("film-2"), path, replace(keypoints, uv=uv), "a detector")
    view = session.views[1].model_copy(update={"keypoints": alone.view.keypoints})
    save_session(session.model_copy(update={"views": (session.view, view)}), path)
    main(["track", str(path)])
    assert off_mm(path) < 2 * right + 5


def test_a_third_film_leaves_the_cameras_of_the_others_where_they_are(
    tmp_path: Path, side: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = begun(tmp_path)
    second = added(path, side).views[1]
    R = rotation_from_euler(0.0, np.radians(-70.0), 0.0)
    seen_in(monkeypatch, JOINTS_M, len(JOINTS_M) - 8, transform(R, MIDDLE - R @ MIDDLE))
    third = write_video(tmp_path / "third.mp4", len(JOINTS_M) - 8, 5)
    session = added(path, third)
    assert [view.id for view in session.views[1:]] == ["film-2", "film-3"]
    assert session.views[1] == second
    assert session.view.camera == Camera.from_focal_length(*SIZE, 30.0)


def test_of_a_thing_no_camera_is_found(
    tmp_path: Path, side: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = begun(tmp_path)
    session = load_session(path)
    thing = session.changed({"body": preset("box"), "keyframes": ()})
    save_session(thing, path)
    assert main(["add-film", str(path), str(side), *FROM_THE_SIDE]) == 2
    assert "found from a person: this body is none" in capsys.readouterr().err


def asked_on_the_page(path: Path, film: Path) -> AddFilm:
    """The job of the page."""
    session = path.read_bytes()
    return AddFilm(session, str(path.parent / "front.mp4"), str(path.parent), str(film))


def person_in(monkeypatch: pytest.MonkeyPatch, *boxes: Box) -> None:
    """Who is found in the second film."""
    people = PeopleInFilm(4, tuple(FoundPerson(box, 1.0) for box in boxes), {})
    monkeypatch.setattr(seen_in_films, "people_seen", lambda *_: people if boxes else None)


def test_the_page_s_job_finds_the_same_and_says_how_far_it_is(
    tmp_path: Path, side: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = begun(tmp_path, wrong=True)
    person_in(monkeypatch, (100, 20, 220, 170))
    *progress, end = reported(asked_on_the_page(path, side), None)
    assert isinstance(end, Finished), end
    film = end.result
    pickle.loads(pickle.dumps(film))  # it comes from another process
    assert abs(film.session.views[1].clock.begins - CLOCK.begins) < 0.3
    assert "side.mp4 begins 3." in film.words
    assert "2 keyframes were mended" in film.words
    assert next(report.words for report in progress if isinstance(report, Progress)) == (
        "Looking at the first film"
    )
    assert film.saved(path).views[1].keypoints is not None


@pytest.mark.parametrize(
    ("boxes", "words"),
    [
        ([], "No person was found in side.mp4."),
        ([(10, 20, 90, 170), (100, 20, 220, 170)], "2 people are to be seen in side.mp4"),
    ],
)
def test_whom_to_look_at_is_said_without_what_only_a_command_has(
    tmp_path: Path, side: Path, monkeypatch: pytest.MonkeyPatch, boxes: list[Box], words: str
) -> None:
    path = begun(tmp_path)
    person_in(monkeypatch, *boxes)
    *_, end = reported(asked_on_the_page(path, side), None)
    assert isinstance(end, Failed)
    assert end.words.startswith(words)
    assert "--frame" not in end.words


def test_for_another_moment_the_camera_is_found_anew_from_what_was_seen(
    tmp_path: Path, side: Path
) -> None:
    path = begun(tmp_path)
    first, film = added(path, side).views
    true = film.film_clock.begins
    elsewhere = {
        "clock": Clock(begins=9.0, also=(true, 40.0)),
        "p_camera_world": (3.0, 0.0, 9.0),
        "R_camera_world_wxyz": (1.0, 0.0, 0.0, 0.0),
    }
    session = load_session(path)
    session = session.model_copy(update={"views": (first, film.model_copy(update=elsewhere))})
    save_session(session, path)
    job = PlaceFilm(path.read_bytes(), "", str(tmp_path), film.id, true)
    *_, end = reported(job, None)
    assert isinstance(end, Finished), end
    again = end.result.session.views[1]
    assert (again.clock.begins, again.clock.also, again.clock.sigma) == (true, (9.0, 40.0), None)
    assert again.keypoints == film.keypoints
    R = again.T_camera_world[:3, :3] @ film.T_camera_world[:3, :3].T
    assert np.degrees(np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))) < 4.0
    assert again.p_camera_world == pytest.approx(film.p_camera_world, abs=0.3)
    assert "side.mp4 begins 3." in end.result.words


def test_of_a_film_of_which_nothing_is_known_no_camera_is_found(tmp_path: Path, side: Path) -> None:
    path = begun(tmp_path)
    first, film = added(path, side).views
    film = film.model_copy(update={"keypoints": None})
    save_session(load_session(path).model_copy(update={"views": (first, film)}), path)
    *_, end = reported(PlaceFilm(path.read_bytes(), "", str(tmp_path), film.id, 4.0), None)
    assert isinstance(end, Failed)
    assert end.words == (
        "Nothing is known of the person in side.mp4: remove the film and add it again."
    )
