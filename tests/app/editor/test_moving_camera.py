"""Before a camera that moves: the world stands still, and a person corrects the camera."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.frames import pointer_views, up_of, views_of
from keypose.app.editor.motion import angle_curve, end_trail, feet_paths, motion_between
from keypose.app.editor.moving_camera import forgotten
from keypose.app.editor.shown import ghost_transforms, ghosts, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.export.import_camera import with_camera_file
from keypose.app.jobs.find_camera import with_found
from keypose.app.jobs.find_up import FindUp
from keypose.app.posing import opening_pose
from keypose.app.state.app_state import AppState
from keypose.app.state.outcomes import FoundUp
from keypose.app.store.sections import Sections
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.formats.reading_camera import CameraFile, CameraWay
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.horizon import horizon_of
from keypose.tracker.geometry.rotations import exp_rotation, transpose
from keypose.tracker.operations.find_camera import FoundCamera
from keypose.tracker.operations.find_up import estimated_up, evidence_of_lines
from keypose.tracker.session import Session
from keypose.tracker.session.camera_motion import CameraMotion, CameraPiece
from keypose.tracker.storage.fingerprints import segment_keys, steady_camera
from tests.app.editor.desk import after
from tests.tracker import panned_cases as panned
from tests.tracker import session_cases as cases
from tests.tracker.operations.standing_cases import lines as upright

UP = (0.0, -1.0, 0.0)


def desk(doc: Session | None = None, frame: int = 0) -> EditorState:
    """A body that stands still in the world, before a camera that pans."""
    doc = panned.panned().with_up(UP) if doc is None else doc
    return EditorState(
        doc=doc,
        skeleton=cases.SKELETON,
        file_times_s=np.arange(panned.FRAMES) / 25,
        opening=opening_pose(doc.subject.body, doc.view.camera, UP),
        frame=frame,
    )


def test_a_body_that_stands_still_in_the_world_is_seen_where_it_stands_between_keyframes() -> None:
    for frame in range(panned.FRAMES):
        state = desk(frame=frame)
        Ts = pose_transforms(state.skeleton, shown_pose(state).pose)
        in_world = np.linalg.inv(state.doc.film_camera.T_camera_world(frame)) @ Ts
        first = pose_transforms(state.skeleton, cases.pose(0.4))
        np.testing.assert_allclose(in_world, first, atol=1e-9)


def test_ghosts_lie_on_the_body_that_stands_still() -> None:
    state = desk(frame=7)
    here = pose_transforms(state.skeleton, shown_pose(state).pose)
    shown = ghosts(state)
    assert [frame for frame, _ in shown] == [2, 12]
    for frame, pose in shown:
        np.testing.assert_allclose(ghost_transforms(state, frame, pose), here, atol=1e-9)


def test_a_trail_of_what_stands_still_is_a_point() -> None:
    trail = end_trail(desk(frame=7))
    assert trail is not None
    assert np.ptp(trail.p_camera, axis=0).max() < 0.03  # it is interpolated as the camera sees it


def test_small_views_stand_still_in_the_world() -> None:
    p_world = np.array([0.4, 0.3, 3.0])
    seen = []
    for frame in (0, 9, 23):
        state = desk(frame=frame)
        p_camera = state.doc.film_camera.T_camera_world(frame)[:3, :3] @ p_world
        views = pointer_views(state.doc, frame)
        seen.append([views[name].project(p_camera) for name in ("top", "side", "front")])
    np.testing.assert_allclose(seen[1:], [seen[0]] * 2, atol=1e-9)


def test_up_and_the_floor_are_the_worlds() -> None:
    for frame in (0, 11, 23):
        state = desk(frame=frame)
        R = state.doc.film_camera.T_camera_world(frame)[:3, :3]
        np.testing.assert_allclose(up_of(state.doc, frame), R @ UP, atol=1e-12)
    floors = {round(feet_paths(desk(frame=frame)).floor_m, 6) for frame in (0, 11, 23)}
    assert len(floors) == 1


def test_a_horizon_drawn_at_any_frame_says_the_same() -> None:
    up = exp_rotation(np.radians([9.0, 0.0, 4.0])) @ UP
    for frame in (0, 13, 23):
        state = desk(panned.panned(), frame)
        line = horizon_of(state.camera, state.doc.film_camera.T_camera_world(frame)[:3, :3] @ up)
        assert line is not None
        drawn = after(state, {"do": "horizon", "a": line[0].tolist(), "b": line[1].tolist()})
        assert drawn.doc.world.up_world is not None
        np.testing.assert_allclose(drawn.doc.world.up_world, up, atol=1e-5)


def wrong() -> Session:
    """The camera's motion as found wrong: it pans too little."""
    from keypose.tracker.geometry.camera_path import CameraPath
    from keypose.tracker.session.camera_motion import CameraMotion

    less = exp_rotation(np.stack([np.zeros(24), -0.6 * panned.PAN * np.linspace(0, 1, 24),
                                  np.zeros(24)], axis=1))  # fmt: skip
    path = CameraPath.of(less, np.zeros((24, 3)), np.ones(24))
    return panned.session(CameraMotion.of("turns", path)).with_up(UP)


def off_deg(doc: Session) -> np.ndarray:
    path = doc.camera_path
    assert path is not None
    miss = path.Ts_camera_world[:, :3, :3] @ transpose(panned.Rs_camera_world())
    cosine = (np.trace(miss, axis1=1, axis2=2) - 1) / 2
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def marked(frame: int, p_world: np.ndarray) -> list[list[float]]:
    R = panned.Rs_camera_world()[frame]
    return [panned.CAMERA.project(R @ p).tolist() for p in p_world]


P_WORLD = np.array([[0.5, -0.5, 5.0], [2.0, 0.6, 6.0], [1.2, 0.1, 4.0]])


def test_points_matched_in_two_frames_correct_the_camera_and_halve_what_is_between() -> None:
    state = desk(wrong(), frame=23)
    before = off_deg(state.doc)
    state = after(
        state,
        {
            "do": "camera_match",
            "other": 0,
            "here": marked(23, P_WORLD),
            "there": marked(0, P_WORLD),
        },
    )
    assert off_deg(state.doc)[23] < 0.02
    assert off_deg(state.doc)[1:23].max() < 0.5 * before.max()
    assert [key.frame for key in state.doc.view.camera_keyframes] == [23]
    state = after(state, {"do": "undo"})
    assert state.doc == wrong()


def test_the_horizon_corrects_the_camera_at_a_frame_and_is_taken_back() -> None:
    doc = panned.panned().with_up(UP)
    tilted = doc.view.camera_motion
    state = desk(doc, frame=20)
    up = exp_rotation(np.radians([0.0, 0.0, 3.0])) @ np.array(up_of(doc, 20))
    line = horizon_of(state.camera, up)
    assert line is not None
    state = after(state, {"do": "camera_horizon", "a": line[0].tolist(), "b": line[1].tolist()})
    np.testing.assert_allclose(up_of(state.doc, 20), up, atol=1e-6)
    assert state.doc.world.up_world == UP
    assert state.doc.view.camera_motion is tilted
    state = after(state, {"do": "delete_camera_key", "frame": 20})
    assert state.doc.view.camera_keyframes == ()


def test_a_camera_that_nobody_found_can_be_set_by_hand() -> None:
    state = desk(panned.session(), frame=23)
    given = {"other": 0, "here": marked(23, P_WORLD), "there": marked(0, P_WORLD)}
    state = after(state, {"do": "camera_match", **given})
    assert off_deg(state.doc)[23] < 0.02
    state = after(state, {"do": "forget_camera"})
    assert state.doc.camera_path is None


@pytest.mark.parametrize(
    ("message", "frame", "words"),
    [
        ({"do": "camera_match", "other": 5, "here": [[1, 1], [90, 9]], "there": [[1, 1], [9, 9]]},
         5, "another frame"),
        ({"do": "camera_match", "other": 99, "here": [[1, 1], [9, 9]], "there": [[1, 1], [9, 9]]},
         5, "The video has frames 0 to"),
        ({"do": "camera_match", "other": 0, "here": [[1, 1], [1, 1]], "there": [[5, 5], [5, 5]]},
         5, "farther apart"),
        ({"do": "camera_match", "other": 9, "here": [[1, 1], [90, 9]], "there": [[1, 1], [90, 9]]},
         0, "first frame is the world's own"),
        ({"do": "camera_horizon", "a": [0, 90], "b": [1, 90]}, 5, "longer line"),
        ({"do": "delete_camera_key", "frame": 5}, 5, "not corrected"),
    ],
)  # fmt: skip
def test_what_corrects_nothing_is_refused_in_a_sentence(
    message: dict[str, object], frame: int, words: str
) -> None:
    with pytest.raises(ActionRefused, match=words):
        after(desk(frame=frame), message)


def test_without_what_is_up_the_horizon_corrects_no_camera() -> None:
    state = desk(panned.panned(), frame=5)
    with pytest.raises(ActionRefused, match="Say what is up first"):
        after(state, {"do": "camera_horizon", "a": [0, 90], "b": [300, 90]})


def test_the_page_is_told_how_the_camera_moves_and_where_it_is() -> None:
    state = desk(frame=12)
    sections = Sections().changed(AppState(edit=state))
    told = sections["camera_motion"]
    assert (told["kind"], told["counts"], len(told["error_px"])) == ("turns", True, 24)
    assert told["words"].startswith("The camera turns: background points agree within 0.1 px")
    here = np.array(sections["camera_here"]).reshape(3, 4)
    np.testing.assert_allclose(here[:, :3], panned.Rs_camera_world()[12].T, atol=1e-5)
    R = np.array(sections["views"]["front"])
    rotations, origin = views_of(state.doc, 12)
    np.testing.assert_allclose(R, rotations["front"])
    np.testing.assert_allclose(sections["views"]["origin"], origin)
    before = {name: value for name, value in sections.items() if name in ("feet", "camera_motion")}
    later = Sections().changed(AppState(edit=replace(state, frame=20)))
    assert {name: later[name] for name in before} == before


@pytest.mark.parametrize(
    ("said", "focal"),
    [
        ({"do": "lens", "mm": 50.0}, lambda camera: camera.focal_mm == pytest.approx(50.0)),
        (
            {"do": "field_of_view", "deg": 40.0},
            lambda camera: 2 * np.degrees(np.arctan(160 / camera.fx)) == pytest.approx(40.0),
        ),
        ({"do": "camera", "fx": 700.0}, lambda camera: camera.fx == pytest.approx(700.0)),
    ],
)
def test_a_lens_that_is_said_of_a_frame_is_that_of_this_frame_also_where_the_camera_zoomed(
    said: dict[str, Any], focal: Callable[[Camera], bool]
) -> None:
    zoom = np.linspace(1, 1.5, panned.FRAMES)
    zooming = CameraMotion.of("turns", CameraPath(panned.path().Ts_camera_world, zoom))
    state = after(desk(panned.session(zooming), frame=20), said)
    assert focal(state.doc.film_camera.at(20))
    assert state.doc.film_camera.at(20).fx == pytest.approx(zoom[20] * state.doc.view.camera.fx)


def test_what_is_not_tracked_goes_evenly_through_the_world_also_where_it_is_drawn_as_a_whole() -> (
    None
):
    state = desk(frame=7)
    for known in (motion_between(state, 2, 22), motion_between(state, 2, 12)):
        first = pose_transforms(state.skeleton, cases.pose(0.4))
        np.testing.assert_allclose(
            known.Ts_world_part, np.stack([first] * len(known.frames)), atol=1e-9
        )


def zooming(share: float = 1.5) -> CameraMotion:
    zoom = np.linspace(1, share, panned.FRAMES)
    return CameraMotion.of("turns", CameraPath(panned.path().Ts_camera_world, zoom))


def seen(doc: Session) -> dict[int, np.ndarray]:
    """Where the root of the body is seen, and how large, by frame."""
    found = {}
    for posed in doc.subject.posed:
        camera, (x, y, z) = doc.film_camera.at(posed.frame), posed.root_m
        found[posed.frame] = np.array([*camera.project(np.array([x, y, z])), camera.fx / z])
    return found


def found_zooming(doc: Session) -> Session:
    found = FoundCamera("turns", zooming(), None, (), None)
    return with_found(doc, found)


def imported_zooming(doc: Session) -> Session:
    path = zooming().path
    way = CameraWay(np.arange(panned.FRAMES), path.Ts_world_camera, path.zoom)
    return with_camera_file(doc, CameraFile(panned.CAMERA, np.array(UP), None, way), "file.chan")


def edited(*messages: dict[str, Any]) -> Callable[[Session], Session]:
    def change(_: Session) -> Session:
        return after(desk(panned.session(zooming()).with_up(UP), frame=20), *messages).doc

    return change


ZOOMED_POINTS = {
    "there": marked(0, P_WORLD),
    "here": [
        (1.2 * (np.array(uv) - (159.5, 89.5)) + (159.5, 89.5)).tolist()
        for uv in marked(20, P_WORLD)
    ],
}


@pytest.mark.parametrize(
    ("changed", "before"),
    [
        (found_zooming, panned.session()),
        (imported_zooming, panned.session()),
        (forgotten, panned.session(zooming())),
        (edited({"do": "forget_camera"}), panned.session(zooming())),
        (edited({"do": "settings", "static_camera": True}), panned.session(zooming())),
        (edited({"do": "camera_match", "other": 0, **ZOOMED_POINTS}), panned.session(zooming())),
        (
            edited(
                {"do": "camera_match", "other": 0, **ZOOMED_POINTS},
                {"do": "delete_camera_key", "frame": 20},
            ),
            panned.session(zooming()),
        ),
    ],
)
def test_what_was_posed_keeps_its_place_in_the_picture_whoever_says_that_the_camera_zoomed(
    changed: Callable[[Session], Session], before: Session
) -> None:
    posed, later = seen(before), seen(changed(before))
    for frame, where in posed.items():
        np.testing.assert_allclose(later[frame], where, rtol=1e-6)


def test_a_zoom_that_is_corrected_counts_in_tracking_and_turns_that_are_do_not() -> None:
    before = panned.session(zooming()).with_up(UP)
    state = desk(before, frame=20)
    turned = after(
        state,
        {"do": "camera_horizon", "a": [0.0, 80.0], "b": [300.0, 84.0]},
    ).doc
    assert len(turned.view.camera_keyframes) == 1
    assert segment_keys(turned) == segment_keys(before)
    zoomed = after(state, {"do": "camera_match", "other": 0, **ZOOMED_POINTS}).doc
    steady, path = steady_camera(zoomed), zoomed.camera_path
    assert steady is not None
    assert path is not None
    assert path.zoom[20] == pytest.approx(1.2, abs=0.01)
    np.testing.assert_array_equal(steady.zoom, path.zoom)
    assert segment_keys(zoomed) != segment_keys(before)


def test_points_marked_by_hand_tell_no_zoom_where_a_turn_explains_them() -> None:
    given = {"other": 0, "here": marked(23, P_WORLD), "there": marked(0, P_WORLD)}
    given["here"][0][0] += 1.0
    state = after(desk(wrong(), frame=23), {"do": "camera_match", **given})
    assert state.doc.view.camera_keyframes[0].zoom == 1.0


def test_how_far_the_camera_went_is_one_step_and_refused_where_it_goes_nowhere() -> None:
    away = panned.path().Ts_camera_world.copy()
    away[:, 0, 3] = np.linspace(0, 1, panned.FRAMES)
    motion = CameraMotion.of(
        "moves", CameraPath(away, np.ones(panned.FRAMES)),
        pieces=(CameraPiece(first_frame=0, metres=None),),
    )  # fmt: skip
    before = desk(panned.session(motion))
    known = after(before, {"do": "camera_far", "metres": 3.5})
    assert known.doc.view.camera_motion is not None
    assert known.doc.view.camera_motion.ways[0].farthest_m == pytest.approx(3.5)
    assert after(known, {"do": "undo"}).doc == before.doc
    with pytest.raises(ActionRefused, match="The camera turns and goes nowhere"):
        after(desk(panned.panned()), {"do": "camera_far", "metres": 3.5})


def test_upright_lines_of_any_frame_say_the_same() -> None:
    up = exp_rotation(np.radians([14.0, 0.0, 4.0])) @ UP
    for frame in (0, 13, 23):
        state = desk(panned.panned(), frame)
        R = state.doc.film_camera.T_camera_world(frame)[:3, :3]
        doc = state.doc.with_up(None)
        estimate = estimated_up(doc, {}, evidence_of_lines(doc, {frame: upright(R @ up)}))
        found, _ = FindUp(b"", "", "", frame).apply(FoundUp(estimate), AppState(edit=state))
        np.testing.assert_allclose(found.editing.doc.world.up_world, up, atol=2e-2)


def test_lines_of_many_frames_are_as_sure_as_those_of_one_and_one_that_is_off_is_left_out() -> None:
    up = exp_rotation(np.radians([14.0, 0.0, 4.0])) @ UP
    doc = panned.panned()
    frames = {n: upright(doc.film_camera.T_camera_world(n)[:3, :3] @ up) for n in (0, 9, 13, 23)}
    all_of_them, alone = (evidence_of_lines(doc, some) for some in (frames, {9: frames[9]}))
    assert all_of_them is not None
    assert alone is not None
    assert all_of_them.sigma_rad == pytest.approx(alone.sigma_rad, rel=0.01)
    off = exp_rotation(np.radians([30.0, 0.0, 0.0])) @ frames[9].up_camera
    found = evidence_of_lines(doc, {**frames, 9: upright(off)})
    assert found is not None
    np.testing.assert_allclose(found.up, up, atol=1e-4)
    assert evidence_of_lines(doc, {}) is None


def in_world(doc: Session, frame: int, skeleton: Skeleton = cases.SKELETON) -> np.ndarray:
    """Where the parts of what is posed at a frame stand in the world."""
    posed = next(each for each in doc.subject.posed if each.frame == frame)
    Ts = pose_transforms(skeleton, posed.pose(skeleton))
    return np.asarray(np.linalg.inv(doc.film_camera.T_camera_world(frame)) @ Ts)


@pytest.mark.parametrize(
    ("messages", "frames"),
    [
        ([{"do": "move_key", "frame": 12, "to": 19}], (2, 19, 22)),
        ([{"do": "duplicate_key", "frame": 2, "to": 17}], (2, 12, 17, 22)),
        ([{"do": "retime_keys", "frames": [12, 22], "to": [9, 20]}], (2, 9, 20)),
        ([{"do": "retime_keys", "frames": [2, 12], "to": [8, 18], "copy_them": True}], (8, 18)),
        ([{"do": "go", "frame": 17}, {"do": "copy_key", "from_frame": 2}], (17,)),
        (
            [
                {"do": "go", "frame": 2},
                {"do": "copy_pose"},
                {"do": "go", "frame": 17},
                {"do": "paste_pose"},
            ],
            (17,),
        ),
        ([{"do": "copy_pose", "frames": [2, 12]}, {"do": "go", "frame": 7}, {"do": "paste_pose"}],
         (7, 17)),
        (
            [
                {"do": "copy_pose", "frames": [2, 12]},
                {"do": "go", "frame": 7},
                {"do": "paste_pose", "onto_body": True},
            ],
            (7, 17),
        ),
    ],
)  # fmt: skip
def test_a_pose_that_goes_to_another_frame_stands_where_it_stood_in_the_world(
    messages: list[dict[str, Any]], frames: tuple[int, ...]
) -> None:
    state = after(desk(), *messages)
    for frame in frames:
        stood = pose_transforms(state.skeleton, cases.pose(0.4))
        np.testing.assert_allclose(in_world(state.doc, frame), stood, atol=1e-7)


def test_a_pose_of_another_film_is_pasted_to_where_it_is_seen() -> None:
    state = after(desk(frame=12), {"do": "copy_pose"})
    assert state.clipboard is not None
    copied = {**json.loads(state.clipboard.text), "film": "another"}
    pasted = after(replace(state, frame=20), {"do": "paste_pose", "copied": copied})
    there, here = (shown_pose(one).pose for one in (state, pasted))
    np.testing.assert_allclose(here.p_camera_root, there.p_camera_root, atol=1e-8)


def test_a_point_of_the_roots_curve_that_is_dragged_nowhere_leaves_the_pose() -> None:
    state = desk(frame=22)
    root = state.doc.subject.body.parts[0].name
    shown = angle_curve(state, 0)[22]
    for axis, deg in zip("xyz", shown, strict=True):
        message = {"do": "key_angle", "frame": 22, "part": root, "axis": axis, "deg": deg}
        np.testing.assert_allclose(
            in_world(after(state, message).doc, 22), in_world(state.doc, 22), atol=1e-9
        )
    turned = after(state, {**message, "axis": "y", "deg": shown[1] + 10})
    assert angle_curve(turned, 0)[22][1] == pytest.approx(shown[1] + 10)


def test_every_body_of_a_session_keeps_its_place_in_the_picture() -> None:
    given = panned.session()
    other = given.subject.model_copy(update={"id": "other"})
    both = given.model_copy(update={"bodies": (given.subject, other)})
    found = found_zooming(both)
    assert found.bodies[1].keyframes == found.bodies[0].keyframes
    assert found.bodies[0].keyframes != given.subject.keyframes
