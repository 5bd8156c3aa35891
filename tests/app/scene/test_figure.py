"""Every shape as the views draw it: meshes with creases, rims, wires, outlines."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
import pytest
import trimesh

from keypose.app.scene.figure import (
    LIFT_M,
    Outline,
    hull_mesh,
    part_mesh,
    rim_lines,
    wire_lines,
)
from keypose.app.scene.scene import Scenery, Stage
from keypose.tracker.body.body import Body, Part, preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.shapes import SIDES, Capsule, Solid
from keypose.tracker.body.shapes.geometry import WIRES
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation, transform
from keypose.tracker.geometry.view import ViewCamera
from tests.tracker.shape_cases import SHAPES, every_shape, pair_of

EYE = ViewCamera.of(Camera(width=320, height=240, fx=500.0, fy=500.0, cx=159.5, cy=119.5))
TURNS = [(0.0, 0.0, 0.0), (0.4, 0.3, 0.9), (1.2, 0.0, 0.4), (np.pi / 2, 0.0, 0.0)]


@pytest.fixture
def stage() -> Iterator[Stage]:
    made = Stage()
    yield made
    made.stop()


@every_shape
def test_the_drawn_mesh_is_the_shapes_own(shape: Solid) -> None:
    vertices, faces = part_mesh(shape)
    drawn, own = vertices[faces].astype(np.float64), shape.mesh()
    np.testing.assert_allclose(drawn, own.vertices[own.faces], atol=1e-6)
    assert (vertices.dtype, faces.dtype) == (np.float32, np.uint32)


@every_shape
def test_vertices_are_shared_within_a_side_and_not_across_a_crease(shape: Solid) -> None:
    vertices, faces = part_mesh(shape)
    sides = shape.mesh().sides
    assert len(trimesh.graph.connected_components(
        trimesh.Trimesh(vertices, faces, process=False).face_adjacency, nodes=np.arange(len(faces))
    )) == len(np.unique(sides))  # fmt: skip


def test_a_box_is_flat_a_cylinder_has_two_rims_and_a_capsule_none() -> None:
    box, cylinder, capsule = (SHAPES[name] for name in ("box", "cylinder", "capsule"))
    assert len(part_mesh(box)[0]) == 24
    assert len(part_mesh(cylinder)[0]) == 4 * SIDES + 2
    assert len(part_mesh(capsule)[0]) == len(capsule.mesh().vertices)
    assert [len(rim_lines(s)) for s in (box, cylinder, capsule)] == [12, 2 * SIDES, 0]
    assert [len(wire_lines(s)) // WIRES for s in (box, cylinder, capsule)] == [0, 1, 13]


@every_shape
def test_lines_lie_just_off_the_surface(shape: Solid) -> None:
    for lines in (rim_lines(shape), wire_lines(shape)):
        off = shape.distance(lines.reshape(-1, 3).astype(np.float64))
        assert (off > 0.3 * LIFT_M).all()
        assert (off < 2 * LIFT_M).all()


@every_shape
@pytest.mark.parametrize("turn", TURNS)
def test_outlines_and_rims_close_around_what_the_picture_fills(
    shape: Solid, turn: tuple[float, ...]
) -> None:
    body = Body(name="one", parts=(Part(name="one", shape=shape),))
    T = transform(exp_rotation(turn), np.array([0.0, 0.0, 3.0]))[None]
    filled = raster(BodyMesh.of(Skeleton.of(body)), T, EYE).part >= 0
    rims = rim_lines(shape).astype(np.float64) @ T[0, :3, :3].T + T[0, :3, 3]
    drawn = np.zeros(filled.shape, np.uint8)
    for line in [*Outline.of(body).lines(T).astype(np.float64), *rims]:
        a, b = np.rint(EYE.project(line)).astype(int)
        cv2.line(drawn, a.tolist(), b.tolist(), 1, 3)
    around, _ = cv2.findContours(drawn, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    closed = cv2.drawContours(np.zeros_like(drawn), around, -1, 1, cv2.FILLED)
    assert (closed[filled] == 1).all()
    assert not cv2.erode(closed, np.ones((7, 7), np.uint8))[~filled].any()


@pytest.mark.parametrize("turn", TURNS)
def test_the_outline_of_round_ends_runs_along_the_border_and_nowhere_else(
    turn: tuple[float, ...],
) -> None:
    body = Body(name="one", parts=(Part(name="one", shape=SHAPES["capsule"]),))
    T = transform(exp_rotation(turn), np.array([0.0, 0.0, 3.0]))[None]
    filled = raster(BodyMesh.of(Skeleton.of(body)), T, EYE).part >= 0
    deep = cv2.distanceTransform(filled.astype(np.uint8), cv2.DIST_L2, 5)
    outline = Outline.of(body)
    lines = outline.lines(T)
    assert len(lines) == len(outline.part) == 2 * 13 + 12 * SIDES
    u, v = np.rint(EYE.project(lines.reshape(-1, 3).astype(np.float64))).astype(int).T
    assert deep[v, u].max() < 4.0


def test_a_body_changes_to_round_ends_and_back_in_the_nodes_there_are(stage: Stage) -> None:
    for shape in (SHAPES["box"], SHAPES["capsule"], SHAPES["cylinder"], SHAPES["capsule"]):
        body = pair_of(shape)
        skeleton = Skeleton.of(body)
        Ts = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 4.0)))
        stage.show(Scenery(body, Ts, selected=frozenset({"left_limb"}), ghosts=((3, Ts),)))
        for nodes in stage._parts:
            np.testing.assert_array_equal(nodes.solid.vertices, part_mesh(shape)[0])
            assert len(nodes.rims.points) == max(1, len(rim_lines(shape)))
        assert isinstance(body.parts[0].shape, Capsule) == (len(rim_lines(shape)) == 0)


@pytest.mark.parametrize("part", ["chest", "left_hand", "neck"])
def test_the_hull_lies_evenly_outside_of_the_part(part: str) -> None:
    body = preset("adult_male")
    shape = body.parts[body.index(part)].shape
    vertices, faces = hull_mesh(shape, 0.004)
    assert faces.shape == shape.mesh().faces.shape
    away = shape.distance(vertices.astype(np.float64))
    assert away.min() > 0.001
    assert away.max() < 0.0055
