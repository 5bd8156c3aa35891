"""A camera that turns, moves and zooms in files: where it was at every frame, and read back."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.export.import_camera import camera_motion_of, with_camera_file
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.camera_files import camera_json, chan
from keypose.tracker.formats.cameras.placing import FilmFrames, placed
from keypose.tracker.formats.npz import npz
from keypose.tracker.formats.reading_camera import CameraFile, load_camera
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.sampling import at_rate, from_zero
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import apply_transform, exp_rotation
from keypose.tracker.session.camera_motion import CameraMotion, CameraPiece
from keypose.tracker.storage.archive import archive_arrays
from tests.tracker import panned_cases as panned
from tests.tracker.formats import recordings
from tests.tracker.formats.glb_reading import Player
from tests.tracker.formats.test_camera_files import TILTED
from tests.tracker.formats.test_glb import written

FRAMES = 73


def path_of(zoom: float = 1.3) -> CameraPath:
    t = np.linspace(0, 1, FRAMES)[:, None]
    turn, p = t * (0.05, 0.4, -0.03), t * (0.6, -0.1, 0.2)
    return CameraPath.of(exp_rotation(turn), p, zoom ** t[:, 0])


def moving(zoom: float = 1.3) -> Recording:
    made = recordings.recording("person")
    return replace(made, up_camera=TILTED, floor_m=-1.4, path=path_of(zoom))


def read(folder: Path, name: str, content: str) -> CameraFile:
    (folder / name).write_text(content)
    camera = moving().camera
    return load_camera(folder / name, (camera.width, camera.height))


@pytest.mark.parametrize(("name", "write"), [("shot.json", camera_json), ("shot.chan", chan)])
def test_what_is_written_is_read_back(tmp_path: Path, name: str, write: object) -> None:
    found = read(tmp_path, name, write(moving()))  # type: ignore[operator]
    assert found.way is not None
    motion = camera_motion_of(found.way, FRAMES, name)
    assert (motion.kind, motion.source, motion.findings) == ("moves", name, ())
    np.testing.assert_allclose(motion.path.Ts_camera_world, path_of().Ts_camera_world, atol=1e-6)
    np.testing.assert_allclose(motion.path.zoom, path_of().zoom, atol=1e-6)
    np.testing.assert_allclose(found.up_camera, TILTED, atol=1e-6)


UNSCALED: dict[str, tuple[tuple[int, int], ...]] = {
    "the whole": ((0, 72),),
    "the beginning": ((0, 20),),
    "two shots in a row": ((20, 40), (41, 50)),
    "the end": ((60, 72),),
}


@pytest.mark.parametrize("case", UNSCALED)
def test_what_has_no_scale_has_none_when_it_is_read_back(tmp_path: Path, case: str) -> None:
    spans = UNSCALED[case]
    starts = sorted({0, *(a for a, _ in spans), *(b + 1 for _, b in spans if b < FRAMES - 1)})
    firsts = [a for a, _ in spans]
    pieces = tuple(
        CameraPiece(first_frame=at, metres=None if at in firsts else 1.0) for at in starts
    )
    given = CameraMotion.of("moves", path_of(), pieces=pieces)
    found = read(tmp_path, "shot.json", camera_json(
        replace(moving(), path=given.path, unscaled=spans)
    ))  # fmt: skip
    assert found.way is not None
    motion = camera_motion_of(found.way, FRAMES, "shot.json")
    assert motion.pieces == given.pieces
    assert motion.unscaled == given.unscaled
    np.testing.assert_allclose(
        motion.path.Ts_camera_world, given.path.Ts_camera_world, atol=1e-6
    )  # fmt: skip


def test_a_camera_that_went_straight_without_scale_does_not_stand_still(tmp_path: Path) -> None:
    made = replace(moving(), path=CameraPath.standing_still(FRAMES), unscaled=((0, FRAMES - 1),))
    found = read(tmp_path, "shot.json", camera_json(made))
    assert found.way is not None
    assert camera_motion_of(found.way, FRAMES, "shot.json").unscaled


def test_spans_without_scale_go_along_where_a_file_begins_later(tmp_path: Path) -> None:
    found = read(tmp_path, "shot.json", camera_json(replace(moving(), unscaled=((5, 9),))))
    assert found.way is not None
    way, _ = placed("shot.json", found.way, FilmFrames(np.arange(100) / 30), 10)
    assert [one.metres for one in camera_motion_of(way, 100, "shot.json").pieces] == [
        1.0, None, 1.0,
    ]  # fmt: skip
    assert camera_motion_of(way, 100, "shot.json").spans[1] == (15, 19)


@pytest.mark.parametrize("spans", [[[3]], [["a", 4]], [[-1, 4]], 5])
def test_spans_that_are_none_are_refused_in_a_sentence(tmp_path: Path, spans: object) -> None:
    content = {**json.loads(camera_json(moving())), "without_scale": spans}
    with pytest.raises(FormatError, match=r"shot.json: .*without_scale"):
        read(tmp_path, "shot.json", json.dumps(content))


def test_of_a_camera_that_stands_still_every_byte_is_as_before() -> None:
    made = replace(moving(), path=None)
    assert json.loads(camera_json(made))["version"] == 1
    still = replace(made, path=CameraPath.standing_still(FRAMES))
    assert chan(still) == chan(made)


def test_the_camera_of_a_glb_sees_every_frame_as_the_film_did() -> None:
    made = moving(1.0)
    player = Player.of(written(made))
    Ts = player.transforms(player.times_s)
    camera, hand = Ts["camera"], Ts["left_hand"]
    flip = np.diag([1.0, -1.0, -1.0, 1.0])
    seen = np.linalg.inv(camera @ flip) @ hand
    index = made.skeleton.body.index("left_hand")
    in_scene = made.trajectory.transforms(made.skeleton)[:, index]
    expected = made.path.Ts_camera_world @ in_scene  # type: ignore[union-attr]
    np.testing.assert_allclose(seen[:, :3, 3], expected[:, :3, 3], atol=2e-5)


def document_of(content: bytes) -> dict[str, Any]:
    length = int.from_bytes(content[12:16], "little")
    return dict(json.loads(content[20 : 20 + length]))


@pytest.mark.parametrize("rig", ["keypose", "vrm"])
def test_the_camera_of_a_glb_zooms_as_the_films_did_and_needs_no_extension(rig: str) -> None:
    made = moving()
    content = written(made, rig)
    document = document_of(content)
    assert "KHR_animation_pointer" in document["extensionsUsed"]
    assert "extensionsRequired" not in document
    (animation,) = document["animations"]
    (channel,) = [one for one in animation["channels"] if one["target"]["path"] == "pointer"]
    assert "node" not in channel["target"]
    pointer = channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"]
    assert pointer == "/cameras/0/perspective/yfov"
    sampler = animation["samplers"][channel["sampler"]]
    angles = Player.of(content).array(sampler["output"])[:, 0]
    focal = made.camera.height / 2 / np.tan(angles / 2)
    np.testing.assert_allclose(focal / made.camera.fy, path_of().zoom, rtol=1e-6)
    np.testing.assert_allclose(animation["extras"]["camera_zoom"], path_of().zoom, atol=1e-6)


def test_a_camera_that_does_not_zoom_needs_no_extension() -> None:
    assert "extensionsUsed" not in document_of(written(moving(1.0)))


def test_usd_has_the_camera_at_every_frame(tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    from pxr import UsdGeom

    from tests.tracker.formats.test_usd import opened

    made = replace(moving(), times_s=np.arange(FRAMES) / 30, rate=30.0)
    stage = opened(made, tmp_path)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/Camera"))
    first = camera.GetFocalLengthAttr().Get(made.numbers[0])
    for row in (0, 30, 72):
        T = np.array(camera.ComputeLocalToWorldTransform(made.numbers[row])).T
        np.testing.assert_allclose(T[:3, 3], made.Ts_world_camera[row, :3, 3], atol=1e-6)
        now = camera.GetFocalLengthAttr().Get(made.numbers[row])
        assert now / first == pytest.approx(path_of().zoom[row], rel=1e-5)


def test_npz_has_poses_as_the_camera_saw_them_and_where_it_was() -> None:
    made = moving()
    found = archive_arrays(npz(made))
    world = apply_transform(made.T_world_camera, made.ps_camera_joint)
    seen = np.einsum("nab,njb->nja", found["Ts_world_camera"][:, :3, :3], found["ps_camera_joint"])
    both = seen + found["Ts_world_camera"][:, None, :3, 3]
    np.testing.assert_allclose(both, world, atol=1e-9)
    np.testing.assert_array_equal(found["zoom"], path_of().zoom)


def test_at_a_rate_of_its_own_the_camera_goes_along() -> None:
    made = at_rate(moving(), 60.0)
    assert len(made.Ts_world_camera) == len(made)
    steps = np.linalg.norm(np.diff(made.Ts_world_camera[:, :3, 3], axis=0), axis=1)
    assert steps.max() < 1.2 * np.median(steps)


@pytest.mark.parametrize(
    ("first", "count", "missing"),
    [
        (0, FRAMES, []),
        (1, FRAMES, []),  # counted from 1
        (1001, FRAMES, []),  # as image files are
        (10, 20, [(0, 9), (30, 72)]),
        (60, 40, [(0, 59)]),
    ],
)
def test_a_file_of_other_frames_says_which_it_lacks(
    tmp_path: Path, first: int, count: int, missing: list[tuple[int, int]]
) -> None:
    lines = [f"{first + k} {0.01 * k} 0 0 0 {0.2 * k} 0 30" for k in range(count)]
    found = read(tmp_path, "shot.chan", "\n".join(lines))
    assert found.way is not None
    motion = camera_motion_of(found.way, FRAMES, "shot.chan")
    assert [(one.first_frame, one.last_frame) for one in motion.findings] == missing
    assert {one.kind for one in motion.findings} <= {"not_in_file"}
    np.testing.assert_array_equal(motion.path.Ts_camera_world[0], np.eye(4))


@pytest.mark.parametrize(("name", "write"), [("shot.json", camera_json), ("shot.chan", chan)])
@pytest.mark.parametrize("turns", [True, False])
def test_a_camera_of_some_frames_alone_sees_them_as_it_did(
    tmp_path: Path, name: str, write: Callable[[Recording], str], turns: bool
) -> None:
    whole = path_of()
    R, p = whole.Ts_camera_world[:, :3, :3], whole.Ts_camera_world[:, :3, 3]
    path = CameraPath.of(R, p * (not turns), whole.zoom)
    made = replace(moving(), path=path).between(20, 50)
    found = read(tmp_path, name, write(made))
    session = panned.session().changed({"keyframes": ()})
    film = session.view.video.model_copy(
        update={"frame_count": FRAMES, "width": made.camera.width, "height": made.camera.height}
    )
    session = with_camera_file(session.changed({"video": film, "camera": made.camera}), found, name)
    motion, there = session.view.camera_motion, session.camera_path
    assert motion is not None
    assert there is not None
    assert motion.kind == ("turns" if turns else "moves")
    for frame in (20, 35, 50):
        assert session.film_camera.at(frame).fy == pytest.approx(path.zoom[frame] * made.camera.fy)
        seen, was = (
            one.Ts_camera_world[frame, :3, :3] @ up
            for one, up in ((there, session.world.up_world), (path, TILTED))
        )
        np.testing.assert_allclose(seen, was, atol=1e-5)


def test_handles_before_the_film_do_not_count(tmp_path: Path) -> None:
    lines = [f"{k} 0 0 0 {-10 - 0.1 * k} {0.5 * k} 0 {30 - 0.2 * k}" for k in range(-20, 30)]
    found = read(tmp_path, "shot.chan", "\n".join(lines))
    alone = read(tmp_path, "cut.chan", "\n".join(lines[20:]))
    assert found.way is not None
    cut = found.from_row(20)
    np.testing.assert_allclose(cut.up_camera, alone.up_camera, atol=1e-12)
    assert cut.camera.fy == pytest.approx(alone.camera.fy)
    assert cut.way is not None
    assert alone.way is not None
    np.testing.assert_allclose(cut.way.zoom, alone.way.zoom)


EVEN = FilmFrames(np.arange(FRAMES) / 30)


def even() -> Recording:
    return replace(moving(), times_s=np.arange(FRAMES) / 30, rate=30.0).with_ground()


@pytest.mark.parametrize("name", ["shot.json", "shot.glb"])
@pytest.mark.parametrize(
    ("sampled", "frames"),
    [
        (lambda made: made, (0, FRAMES - 1)),
        (lambda made: made.between(20, 50), (20, 50)),
        (lambda made: from_zero(made.between(20, 50)), (20, 50)),
        (lambda made: at_rate(made, 24.0), (0, FRAMES - 2)),
        (lambda made: from_zero(at_rate(made, 60.0).between(40, 90)), (20, 45)),
    ],
)
def test_a_camera_that_keypose_wrote_comes_back_to_its_frames(
    tmp_path: Path,
    name: str,
    sampled: Callable[[Recording], Recording],
    frames: tuple[int, int],
) -> None:
    made = sampled(even())
    content = camera_json(made).encode() if name == "shot.json" else written(made)
    (tmp_path / name).write_bytes(content)
    found = load_camera(tmp_path / name, (made.camera.width, made.camera.height))
    assert found.way is not None
    way, notes = placed(name, found.way, EVEN)
    assert notes == ()
    told = [frame for frame in way.frames.tolist() if frames[0] <= frame <= frames[1]]
    assert told == list(range(frames[0], frames[1] + 1))
    truth = even().T_world_camera @ path_of().Ts_world_camera
    row = {frame: k for k, frame in enumerate(way.frames.tolist())}
    for frame in told:
        np.testing.assert_allclose(way.Ts_world_camera[row[frame]], truth[frame], atol=2e-4)
        focal = found.camera.fy * way.zoom[row[frame]]  # type: ignore[union-attr]
        assert focal == pytest.approx(path_of().zoom[frame] * made.camera.fy, rel=1e-3)


@pytest.mark.parametrize("last", ["0 0 0 0 5 0 0.01", "1e300 0 0 0 0 0 30", "0 0 0 0 5 0 179.9999"])
def test_a_zoom_and_a_way_that_no_camera_has_are_one_sentence(tmp_path: Path, last: str) -> None:
    found = read(tmp_path, "shot.chan", f"0 0 0 0 0 0 0 30\n1 {last}")
    assert found.way is not None
    with pytest.raises(FormatError, match=r"^shot.chan has numbers that no camera has"):
        camera_motion_of(found.way, FRAMES, "shot.chan")
