"""What the stage tells viser: everything once, then only what changed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import viser._messages as messages

from keypose.app.render.palette import SIDE_COLOURS, WHITE
from keypose.app.scene.figure import Outline, trail_lines
from keypose.app.scene.nodes import ROOT, SELECTED
from keypose.app.scene.scene import Scenery, Stage, Trail
from keypose.app.scene.viser_compat import ROLES
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import with_height
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    frozen,
    rotation_from_quaternion,
    transform,
)
from keypose.tracker.geometry.view import ViewCamera

BODY = preset("adult_male")
OUTLINED = tuple(role for role in ROLES if role != "free")


class Listener:
    """All that a stage tells viser, in order."""

    def __init__(self, stage: Stage) -> None:
        self.stage = stage
        self.received: list[messages.Message] = []
        wire: Any = stage._viser.server._websock_server
        report = wire.queue_message

        def queue_message(message: messages.Message) -> None:
            self.received.append(message)
            report(message)

        wire.queue_message = queue_message

    def show(self, scenery: Scenery) -> list[messages.Message]:
        self.received.clear()
        self.stage.show(scenery)
        return list(self.received)


@pytest.fixture
def listener() -> Iterator[Listener]:
    stage = Stage()
    yield Listener(stage)
    stage.stop()


def posed(shift_m: float = 0.0, body: Body = BODY) -> Array:
    skeleton = Skeleton.of(body)
    pose = Pose.rest(skeleton, (shift_m, 0.0, 4.0))
    turns = np.tile(exp_rotation([0.1, 0.2, 0.3]), (skeleton.part_count, 1, 1))
    return pose_transforms(skeleton, replace(pose, Rs_parent_part=turns))


def kinds(reported: list[messages.Message]) -> set[str]:
    return {type(message).__name__ for message in reported}


def names(reported: list[messages.Message]) -> set[str]:
    return {message.name for message in reported}  # type: ignore[attr-defined]


def test_the_same_scenery_again_shows_nothing(listener: Listener) -> None:
    scenery = Scenery(BODY, posed())
    assert listener.show(scenery)
    assert listener.show(scenery) == []
    assert listener.show(replace(scenery)) == []


def test_a_new_pose_is_the_transforms_of_the_parts_and_the_outlines(listener: Listener) -> None:
    listener.show(Scenery(BODY, posed()))
    reported = listener.show(Scenery(BODY, posed(0.5)))
    assert kinds(reported) == {"SetPositionMessage", "SceneNodeUpdateMessage"}
    moved = [m.name for m in reported if isinstance(m, messages.SetPositionMessage)]
    assert moved == [f"{ROOT}/body/{i}" for i in range(len(BODY.parts))]
    drawn = {m.name for m in reported if isinstance(m, messages.SceneNodeUpdateMessage)}
    assert drawn == {f"{ROOT}/outline/{role}" for role in OUTLINED}


def test_a_pose_is_reported_as_one(listener: Listener, monkeypatch: pytest.MonkeyPatch) -> None:
    listener.show(Scenery(BODY, posed()))
    buffer: Any = listener.stage._viser.server._websock_server.get_message_buffer()
    depths: list[int] = []
    push = buffer.push
    monkeypatch.setattr(buffer, "push", lambda m: (depths.append(buffer.atomic_counter), push(m)))
    listener.stage.show(Scenery(BODY, posed(0.5)))
    assert set(depths) == {1}


def test_parts_are_placed_as_the_camera_sees_them(listener: Listener) -> None:
    Ts = posed()
    listener.show(Scenery(BODY, Ts))
    for i, T in enumerate(Ts):
        node = listener.stage._scene.get_handle_by_name(f"{ROOT}/body/{i}")
        assert node is not None
        assert rotation_from_quaternion(node.wxyz) == pytest.approx(T[:3, :3], abs=1e-6)
        assert node.position == pytest.approx(T[:3, 3], abs=1e-9)


def test_three_js_has_x_to_the_right_y_up_and_z_toward_the_viewer() -> None:
    stage = Stage()
    try:
        buffer = stage._viser.server._websock_server.get_message_buffer()
        reported = list(buffer.message_from_id.values())
        turns = [m for m in reported if isinstance(m, messages.SetOrientationMessage)]
        world = next(m.wxyz for m in turns if m.name == "")
        camera = stage._scene.get_handle_by_name(ROOT)
        assert camera is not None
        turn = rotation_from_quaternion(world) @ rotation_from_quaternion(camera.wxyz)
        assert turn == pytest.approx(np.diag([1.0, -1.0, -1.0]), abs=1e-9)
    finally:
        stage.stop()


def test_selecting_a_part_changes_its_looks_and_no_pose(listener: Listener) -> None:
    scenery = Scenery(BODY, posed())
    listener.show(scenery)
    reported = listener.show(replace(scenery, selected=frozenset({"right_forearm"})))
    assert "SetPositionMessage" not in kinds(reported)
    arm = f"{ROOT}/body/{BODY.index('right_forearm')}"
    assert {name for name in names(reported) if "/body/" in name} == {
        f"{arm}/{child}" for child in ("overlay", "solid", "rims", "wires", "edges", "hull")
    }
    colours = [
        m.updates["color"]
        for m in reported
        if isinstance(m, messages.SceneNodeUpdateMessage) and "color" in m.updates
    ]
    assert colours == [SELECTED, SELECTED, WHITE]  # of the two solids, and of the hull
    assert f"{ROOT}/held/main" in names(reported)


def test_a_part_has_the_colour_of_its_side(listener: Listener) -> None:
    listener.show(Scenery(BODY, posed()))
    for name, side in (("left_thigh", "left"), ("right_thigh", "right"), ("head", "middle")):
        solid: Any = listener.stage._parts[BODY.index(name)].solid
        assert tuple(solid.color) == SIDE_COLOURS[side]  # type: ignore[index]


def test_the_wire_picture_has_no_fill_and_the_solid_one_no_inner_lines(listener: Listener) -> None:
    scenery = Scenery(BODY, posed(), selected=frozenset({"head"}), opacity=0.4)
    head, waist = BODY.index("head"), BODY.index("waist")

    def fills_and_wires() -> list[bool]:
        parts = listener.stage._parts
        return [parts[waist].overlay.visible, parts[head].overlay.visible, parts[0].wires.visible]

    listener.show(replace(scenery, mode="wire"))
    assert fills_and_wires() == [False, True, True]
    listener.show(replace(scenery, mode="solid"))
    assert fills_and_wires() == [True, True, False]
    listener.show(replace(scenery, mode="both"))
    assert fills_and_wires() == [True, True, True]
    assert listener.stage._parts[waist].overlay.opacity == 0.4
    assert listener.stage._parts[head].overlay.opacity == pytest.approx(0.52)


def test_another_size_changes_the_shapes_of_the_nodes_there_are(listener: Listener) -> None:
    listener.show(Scenery(BODY, posed()))
    taller = with_height(BODY, 2.0)
    reported = listener.show(Scenery(taller, posed(body=taller)))
    assert not kinds(reported) & {"FrameMessage", "MeshMessage", "RemoveSceneNodeMessage"}
    assert any(
        "vertices" in m.updates for m in reported if isinstance(m, messages.SceneNodeUpdateMessage)
    )


def test_another_body_has_nodes_of_its_own(listener: Listener) -> None:
    listener.show(Scenery(BODY, posed()))
    stick = Body(name="stick", parts=BODY.parts[:1])
    Ts = posed(body=stick)
    listener.show(Scenery(stick, Ts))
    assert len(listener.stage._parts) == 1
    assert listener.stage._scene.get_handle_by_name(f"{ROOT}/body/1") is None
    listener.show(Scenery(BODY, posed(0.3)))
    last = listener.stage._scene.get_handle_by_name(f"{ROOT}/body/{len(BODY.parts) - 1}")
    assert last is not None
    assert last.position == pytest.approx(posed(0.3)[-1, :3, 3])


def test_ghosts_come_and_go(listener: Listener) -> None:
    scenery = Scenery(BODY, posed())
    listener.show(scenery)
    reported = listener.show(replace(scenery, ghosts=((3, posed(0.2)), (9, posed(0.4)))))
    assert {f"{ROOT}/ghost/{k}/{role}" for k in range(2) for role in OUTLINED} <= names(reported)
    reported = listener.show(replace(scenery, ghosts=((3, posed(0.2)),)))
    assert f"{ROOT}/ghost/1/main" in names([m for m in reported if "Remove" in type(m).__name__])
    listener.show(scenery)
    assert listener.stage._scene.get_handle_by_name(f"{ROOT}/ghost/0/main") is None


def test_a_trail_comes_moves_on_and_goes(listener: Listener) -> None:
    scenery = Scenery(BODY, posed())
    way = np.linspace([0.0, 0.0, 4.0], [1.0, 0.0, 4.0], 20)
    listener.show(scenery)
    for trail in (Trail(way, 5), Trail(way, 19), Trail(way[:1], 0), None):
        reported = listener.show(replace(scenery, trail=trail))
        assert names(reported) <= {f"{ROOT}/trail"}
    assert listener.stage._scene.get_handle_by_name(f"{ROOT}/trail") is None


def test_each_view_is_sent_which_nodes_are_not_for_it(listener: Listener) -> None:
    listener.show(Scenery(BODY, posed(), selected=frozenset({"head"})))
    only = listener.stage._only_for
    assert only[f"{ROOT}/body/0/overlay"] == ("main",)
    assert only[f"{ROOT}/body/0/edges"] == ("top", "side", "front", "free")
    assert only[f"{ROOT}/body/0/hull"] == ("free",)
    assert only[f"{ROOT}/trail"] == OUTLINED
    assert only[f"{ROOT}/light/free/sun"] == ("free",)
    for role in OUTLINED:
        assert only[f"{ROOT}/outline/{role}"] == (role,)
        assert only[f"{ROOT}/held/{role}"] == (role,)
        assert only[f"{ROOT}/light/{role}/sun"] == (role,)
    assert f"{ROOT}/body/0" not in only


def test_the_light_comes_from_the_upper_left_of_every_view(listener: Listener) -> None:
    tilted = exp_rotation([0.4, 0.0, 0.0])
    scenery = Scenery(BODY, posed(), Rs_view_camera={"front": tilted})
    listener.show(scenery)
    for role in OUTLINED:
        sun = listener.stage._scene.get_handle_by_name(f"{ROOT}/light/{role}/sun")
        assert sun is not None
        x, y, z = scenery.R_view_camera(role) @ sun.position
        assert x < 0
        assert y < 0
        assert z < 0


# --- outlines and trails


@pytest.mark.parametrize("direction", [None, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)])
def test_outlines_enclose_the_part_as_the_eye_sees_it(
    direction: tuple[float, float, float] | None,
) -> None:
    """The round side lies between the planes through the eye and its two outlines.

    Up to 2 mm: the strips of a side whose ends differ in form are a little twisted.
    """
    part = BODY.parts[1].model_copy(update={"parent": None, "tracked": ()})
    body = Body(name="stick", parts=(part,))
    outline = Outline.of(body)
    T = transform(exp_rotation([0.3, 0.5, -0.4]), np.array([0.3, -0.2, 3.0]))
    ray = None if direction is None else np.array(direction)
    lines = outline.lines(T[None], ray).astype(np.float64)
    side = np.concatenate([outline.low[0], outline.high[0]]) @ T[:3, :3].T + T[:3, 3]
    for start, end in lines:
        assert np.linalg.norm(end - start) > 0.1
        toward = start if ray is None else ray
        normal = np.cross(end - start, toward)
        distances = (side - start) @ (normal / np.linalg.norm(normal))
        assert distances.min() > -0.002 or distances.max() < 0.002


def test_a_side_seen_end_on_has_no_outline() -> None:
    part = BODY.parts[2].model_copy(update={"parent": None, "tracked": ()})
    outline = Outline.of(Body(name="stick", parts=(part,)))
    lines = outline.lines(
        transform(np.eye(3), np.array([0.0, 0.0, 3.0]))[None], np.array([0.0, 1.0, 0.0])
    )
    assert np.linalg.norm(lines[..., 1, :] - lines[..., 0, :], axis=-1).max() < 1e-4


def test_outlines_lie_on_the_border_of_the_picture() -> None:
    """The outlines of a turned forearm run along the edge of what the rasteriser fills."""
    part = BODY.parts[5].model_copy(update={"parent": None, "tracked": ()})
    body = Body(name="stick", parts=(part,))
    T = transform(exp_rotation([0.2, 0.1, 1.0]), np.array([0.0, 0.0, 2.0]))[None]
    view = ViewCamera(frozen(np.eye(4)), (800.0, 800.0), (159.5, 119.5), 320, 240)
    filled = raster(BodyMesh.of(Skeleton.of(body)), T, view).part >= 0
    for line in Outline.of(body).lines(T).astype(np.float64):
        for share in (0.3, 0.5, 0.7):
            u, v = np.rint(view.project(line[0] + share * (line[1] - line[0]))).astype(int)
            around = filled[v - 2 : v + 3, u - 2 : u + 3]
            assert around.any()
            assert not around.all()


def test_a_trail_is_whole_up_to_the_present_and_dashed_after() -> None:
    way = np.linspace([0.0, 0.0, 4.0], [1.0, 0.0, 4.0], 11)
    lines = trail_lines(way, 5)
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    past, future = lines[:5], lines[5:]
    assert past[0, 0] == pytest.approx(way[0])
    assert past[-1, 1] == pytest.approx(way[5])
    assert future[..., 0].min() >= 0.5 - 1e-6
    assert lengths[5:].sum() == pytest.approx(0.25, rel=0.1)
    assert math.isclose(lengths[:5].sum(), 0.5, rel_tol=1e-5)


def test_a_trail_of_one_point_or_of_a_resting_one_has_no_dashes_to_draw() -> None:
    assert len(trail_lines(np.zeros((1, 3)), 0)) == 0
    assert np.isfinite(trail_lines(np.zeros((5, 3)), 2)).all()
