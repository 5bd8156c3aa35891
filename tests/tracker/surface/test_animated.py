"""What is promised of an animated GLB file: the surface that every program shows at that time."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.surface.files.animated import FPS, AnimatedScene
from keypose.tracker.surface.files.parsing.channels import slerp
from keypose.tracker.surface.files.parsing.raw import Refused
from keypose.tracker.surface.files.sequence import MeshSequence
from tests.tracker.surface.mesh_files import BOX, CORNERS, GlbFile

WALK = Path(__file__).parents[4] / "shared/data/mesh_walk"

QUARTER = [0.0, 0.0, np.sin(np.pi / 4), np.cos(np.pi / 4)]
"""A quarter turn about z, from x to y, as x, y, z, w."""


def scene(glb: GlbFile) -> AnimatedScene:
    return AnimatedScene.read(io.BytesIO(glb.content()))


def at(glb: GlbFile, time_s: float) -> Array:
    """(8, 3) the box at a time after the animation's first."""
    step = round(time_s * FPS)
    assert step == pytest.approx(time_s * FPS), "no step lies there"
    return scene(glb).mesh(step).vertices


def moved_box(times: Any, values: Any, path: str = "translation", how: str = "LINEAR") -> GlbFile:
    glb = GlbFile()
    glb.animate(glb.node(mesh=glb.mesh(glb.box())), path, times, values, how)
    return glb


def refusal(read: Callable[[], Any]) -> str:
    with pytest.raises(Refused) as caught:
        read()
    return str(caught.value)


# --- a real one ---------------------------------------------------------------------------------


@pytest.mark.skipif(not WALK.is_dir(), reason="the data folder mesh_walk is not here")
def test_a_walking_person_is_shown_as_the_reference_shows_it() -> None:
    with np.load(WALK / "sequence.npz") as reference:
        vertices, faces = reference["vertices"], reference["faces"]
    with MeshSequence.open(WALK / "CesiumMan.glb") as meshes:
        assert meshes.frame_count == len(vertices)
        assert (meshes.fps, meshes.stated_units, meshes.stated_up) == (30.0, "m", "+y")
        for frame in range(0, meshes.frame_count, 6):
            mesh = meshes.mesh(frame)
            # Vertices are numbered otherwise, for those at the texture's seams became one.
            found, true = mesh.vertices[mesh.faces], vertices[frame][faces]
            np.testing.assert_allclose(found, true, atol=1e-4)
        ends = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        assert (np.unique(ends, axis=0, return_counts=True)[1] == 2).all()  # no hole at a seam


# --- where nodes lie ----------------------------------------------------------------------------


def test_nodes_carry_their_children_along() -> None:
    glb = GlbFile()
    child = glb.node(mesh=glb.mesh(glb.box()), translation=[1, 0, 0], scale=[2, 1, 1])
    middle = glb.node(children=[child], rotation=QUARTER)
    T = np.diag([1.0, 1, 3, 1])
    T[:3, 3] = [0, 0, 5]
    glb.node(children=[middle], matrix=T.T.ravel().tolist())
    turned = (CORNERS * [2, 1, 1] + [1, 0, 0]) @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    np.testing.assert_allclose(at(glb, 0), turned * [1, 1, 3] + [0, 0, 5], atol=1e-6)


def test_a_scene_lies_as_another_program_lays_it() -> None:
    rng = np.random.default_rng(2)
    written = trimesh.Scene()
    parent = None
    for number in range(4):
        T = np.eye(4)
        T[:3, :3] = exp_rotation(rng.normal(size=3))
        T[:3, 3] = rng.normal(size=3)
        shape = trimesh.creation.icosphere(subdivisions=1, radius=0.1 + 0.1 * number)
        written.add_geometry(shape, f"n{number}", f"g{number}", parent, transform=T)
        parent = f"n{number}"
    found = AnimatedScene.read(io.BytesIO(written.export(file_type="glb"))).mesh(0)
    true = np.asarray(written.to_geometry().triangles)
    seen = found.vertices[found.faces]
    for triangle in true[::7]:
        assert np.abs(seen - triangle).max(axis=(1, 2)).min() < 1e-5
    assert len(seen) == len(true)


def test_only_what_hangs_in_the_scene_is_shown() -> None:
    glb = GlbFile()
    shown = glb.node(mesh=glb.mesh(glb.box()))
    glb.node(mesh=glb.mesh(glb.box()), translation=[9, 0, 0])
    glb.document["scenes"] = [{"nodes": []}, {"nodes": [shown]}]
    glb.document["scene"] = 1
    assert len(at(glb, 0)) == 8


def test_a_mirrored_part_still_shows_its_outside() -> None:
    glb = GlbFile()
    glb.node(mesh=glb.mesh(glb.box()), scale=[-1, 1, 1])
    mesh = scene(glb).mesh(0)
    assert trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).volume > 0


@pytest.mark.parametrize("mode", [5, 6])
def test_strips_and_fans_are_faces(mode: int) -> None:
    ring = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    strip = [ring[k] for k in (0, 1, 3, 2)]
    glb = GlbFile()
    positions = glb.numbers(np.array(strip if mode == 5 else ring, dtype=float))
    glb.node(mesh=glb.mesh({"attributes": {"POSITION": positions}, "mode": mode}))
    mesh = scene(glb).mesh(0)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert np.cross(b - a, c - a)[:, 2].tolist() == [1, 1]


# --- over time ----------------------------------------------------------------------------------


def test_steps_are_a_thirtieth_of_a_second_from_the_first_time_on() -> None:
    found = scene(moved_box([0.5, 1.5], [[0, 0, 0], [30, 0, 0]]))
    assert found.frame_count == 31
    assert [found.mesh(k).vertices[0, 0] for k in (0, 1, 30)] == pytest.approx([0, 1, 30])


def test_between_two_times_a_place_runs_straight_and_a_turn_along_its_arc() -> None:
    straight = moved_box([0, 1], [[0, 0, 0], [3, 6, 9]])
    np.testing.assert_allclose(at(straight, 1 / 3), CORNERS + np.array([1, 2, 3]), atol=1e-6)
    turned = moved_box([0, 1], [[0, 0, 0, 1], QUARTER], "rotation")
    third = exp_rotation(np.array([0, 0, np.pi / 6]))
    np.testing.assert_allclose(at(turned, 1 / 3), CORNERS @ third.T, atol=1e-6)


def test_a_turn_takes_the_shorter_way() -> None:
    longer = moved_box([0, 1], [[0, 0, 0, 1], [-value for value in QUARTER]], "rotation")
    third = exp_rotation(np.array([0, 0, np.pi / 6]))
    np.testing.assert_allclose(at(longer, 1 / 3), CORNERS @ third.T, atol=1e-6)


def test_steps_hold_until_the_next_time() -> None:
    held = moved_box([0, 0.5, 1], [[0, 0, 0], [1, 0, 0], [2, 0, 0]], how="STEP")
    assert at(held, 0.4)[0, 0] == 0
    assert at(held, 0.6)[0, 0] == 1
    assert at(held, 1.0)[0, 0] == 2


def test_splines_follow_their_slopes() -> None:
    # x = t³ has these values and slopes at 0 and 2; a cubic spline is that curve itself.
    slopes = [[[0, 0, 0], [0, 0, 0], [0, 0, 0]], [[12, 0, 0], [8, 0, 0], [0, 0, 0]]]
    glb = moved_box([0, 2], np.array(slopes, dtype=float).reshape(6, 3), how="CUBICSPLINE")
    for time_s in (0.0, 0.5, 1.0, 1.7, 2.0):
        assert at(glb, time_s)[0, 0] == pytest.approx(time_s**3, abs=1e-5)


def test_before_and_after_its_own_times_a_part_stands_still() -> None:
    glb = GlbFile()
    late = glb.node(mesh=glb.mesh(glb.box()))
    glb.animate(late, "translation", [0.5, 1.0], [[1, 0, 0], [2, 0, 0]])
    glb.animate(late, "scale", [0.0, 2.0], [[1, 1, 1], [1, 1, 1]])
    assert [at(glb, t)[0, 0] for t in (0.0, 0.8, 2.0)] == pytest.approx([1, 1.6, 2])


def test_half_a_turn_of_quaternions_that_are_equal_is_that_turn() -> None:
    quarter = np.array(QUARTER)
    np.testing.assert_allclose(slerp(quarter, -quarter, 0.5), quarter)
    np.testing.assert_allclose(slerp(quarter, 3 * quarter, 0.5), quarter)


# --- skins and morph targets --------------------------------------------------------------------


def skinned(shares: Any, kind: str = "f4", **facts: Any) -> GlbFile:
    """A box whose lower joint stands still while the upper one moves 1 along x in a second."""
    glb = GlbFile()
    lower = glb.node()
    upper = glb.node(translation=[0, 0, 5])
    Ts = np.tile(np.eye(4), (2, 1, 1))
    Ts[1, :3, 3] = [0, 0, -5]
    box = glb.box()
    box["attributes"]["JOINTS_0"] = glb.numbers(np.tile([0, 1, 0, 0], (8, 1)), "u1")
    box["attributes"]["WEIGHTS_0"] = glb.numbers(shares, kind, **facts)
    matrices = glb.numbers(Ts.swapaxes(1, 2).reshape(2, 16))
    glb.document["skins"].append({"joints": [lower, upper], "inverseBindMatrices": matrices})
    glb.node(mesh=glb.mesh(box), skin=0, translation=[77, 0, 0])  # a skinned node's place is none
    glb.animate(upper, "translation", [0, 1], [[0, 0, 5], [1, 0, 5]])
    return glb


UPPER = CORNERS[:, 2] / 1.7
"""How much of every corner moves with the upper joint."""


def test_a_skin_moves_vertices_by_their_shares() -> None:
    shares = np.column_stack([1 - UPPER, UPPER, 0 * UPPER, 0 * UPPER])
    expected = CORNERS + UPPER[:, None] * [1, 0, 0]
    np.testing.assert_allclose(at(skinned(shares), 1.0), expected, atol=1e-6)


def test_shares_may_be_bytes_and_need_not_add_up() -> None:
    shares = np.column_stack([1 - UPPER, UPPER, 0 * UPPER, 0 * UPPER])
    small = skinned(shares * 255, "u1", normalized=True)
    expected = CORNERS + UPPER[:, None] * [1, 0, 0]
    np.testing.assert_allclose(at(small, 1.0), expected, atol=1e-6)
    np.testing.assert_allclose(at(skinned(shares * 0.5), 1.0), expected, atol=1e-6)


def test_vertices_without_any_share_keep_to_the_first_joint() -> None:
    np.testing.assert_allclose(at(skinned(np.zeros((8, 4))), 1.0), CORNERS, atol=1e-6)


def test_morph_targets_add_up_by_their_weights() -> None:
    glb = GlbFile()
    wider, higher = CORNERS * [1, 0, 0], CORNERS * [0, 0, 1]
    targets = [{"POSITION": glb.numbers(wider)}, {"POSITION": glb.numbers(higher)}]
    node = glb.node(mesh=glb.mesh(glb.box(targets=targets), weights=[0.5, 0]))
    np.testing.assert_allclose(at(glb, 0), CORNERS * [1.5, 1, 1], atol=1e-6)
    glb.animate(node, "weights", [0, 1], [0, 0, 1, 0.5])
    np.testing.assert_allclose(at(glb, 1.0), CORNERS * [2, 1, 1.5], atol=1e-6)
    np.testing.assert_allclose(at(glb, 0.5), CORNERS * [1.5, 1, 1.25], atol=1e-6)


def test_a_morph_target_may_state_only_what_differs() -> None:
    glb = GlbFile()
    rows, shift = glb.view(np.array([3, 6], "<u2")), np.array([[1, 2, 3], [4, 5, 6]], "<f4")
    target = glb.numbers(np.zeros((8, 3)))
    facts = glb.document["accessors"][target]
    del facts["bufferView"]
    facts["sparse"] = {
        "count": 2,
        "indices": {"bufferView": rows, "componentType": 5123},
        "values": {"bufferView": glb.view(shift)},
    }
    glb.node(mesh=glb.mesh(glb.box(targets=[{"POSITION": target}]), weights=[1]))
    expected = CORNERS.copy()
    expected[[3, 6]] += shift
    np.testing.assert_allclose(at(glb, 0), expected, atol=1e-6)
    facts["sparse"]["count"] = 3
    assert "do not fit together" in refusal(lambda: scene(glb))


def test_seams_of_a_texture_are_no_holes_and_lips_that_touch_are_not_sewn() -> None:
    soup, faces = CORNERS[BOX.ravel()], np.arange(36)
    glb = GlbFile()
    box = {
        "attributes": {"POSITION": glb.numbers(soup)},
        "indices": glb.numbers(faces, "u2"),
    }
    moving = glb.node(mesh=glb.mesh(box))
    glb.node(mesh=glb.mesh(box))  # at the same place, and it stays
    glb.animate(moving, "translation", [0, 1], [[0, 0, 0], [0, 0, 1]])
    found = scene(glb)
    assert [len(found.tidy_mesh(step).vertices) for step in (0, 30)] == [16, 16]


# --- damaged ones -------------------------------------------------------------------------------


def damaged(how: Callable[[GlbFile], object]) -> Callable[[], AnimatedScene]:
    shares = np.column_stack([1 - UPPER, UPPER, 0 * UPPER, 0 * UPPER])
    glb = skinned(shares)
    how(glb)
    return lambda: scene(glb)


def accessor(number: int, **facts: Any) -> Callable[[GlbFile], object]:
    return lambda glb: glb.document["accessors"][number].update(facts)


@pytest.mark.parametrize(
    "how",
    [
        accessor(0, count=9),
        accessor(0, count=-1),
        accessor(0, byteOffset=-4),
        accessor(0, byteOffset=2**40),
        accessor(0, componentType=1),
        accessor(0, type="VEC2"),
        accessor(0, bufferView=99),
        accessor(0, bufferView=-1),
        lambda glb: glb.document["bufferViews"][0].update(byteOffset=2**40),
        lambda glb: glb.document["bufferViews"][0].update(byteStride=4),
        lambda glb: glb.document["bufferViews"][0].update(byteStride=10**9),
        lambda glb: glb.document["nodes"][0].update(children=[1, 1]),
        lambda glb: glb.document["nodes"][0].update(children=[0]),
        lambda glb: glb.document["nodes"][0].update(children=[-1]),
        lambda glb: glb.document["nodes"][2].update(mesh=7),
        lambda glb: glb.document["nodes"][2].update(skin=-1),
        lambda glb: glb.document["skins"][0].update(joints=[0, 9]),
        lambda glb: glb.document["skins"][0].update(joints=[0]),
        lambda glb: glb.document["skins"][0].update(joints=[0, 1, 0]),
        lambda glb: glb.document["animations"][0]["channels"][0].update(sampler=1),
        lambda glb: glb.document["animations"][0]["channels"][0]["target"].update(node=3),
        lambda glb: glb.document["animations"][0]["samplers"][0].update(
            interpolation="CUBICSPLINE"
        ),
        lambda glb: glb.document.update(scenes=[{"nodes": [0, 55]}]),
        lambda glb: glb.document.update(scenes=[{"nodes": [2]}], scene=1),
        lambda glb: glb.document.update(accessors={}),
    ],
)
def test_parts_that_do_not_fit_together_are_reported(how: Callable[[GlbFile], object]) -> None:
    assert "do not fit together" in refusal(damaged(how))


def endless(glb: GlbFile) -> None:
    glb.animate(1, "scale", [0, 1e9], [[1, 1, 1], [1, 1, 1]])


def backward(glb: GlbFile) -> None:
    glb.animate(1, "scale", [1, 0], [[1, 1, 1], [1, 1, 1]])


def out_of_range(glb: GlbFile) -> None:
    primitive = glb.document["meshes"][0]["primitives"][0]
    primitive["indices"] = glb.numbers(BOX.ravel() + 1, "u2")


@pytest.mark.parametrize(
    ("how", "words"),
    [
        (endless, "many hours"),
        (backward, "do not ascend"),
        (out_of_range, "not among its vertices"),
        (accessor(1, count=30_000_000), "10,000,000 faces"),
        (lambda glb: glb.document["nodes"].extend([{"mesh": 0}] * 200_000), "faces"),
        (lambda glb: glb.document["nodes"].extend([{}] * 30_000), "30,003 nodes"),
        (lambda glb: glb.document["meshes"][0]["primitives"][0].update(mode=0), "no vertices"),
        (lambda glb: glb.document.update(meshes=[], nodes=[], animations=[]), "no vertices"),
        (lambda glb: glb.document.update(extensionsRequired=["KHR_draco_mesh_compression"]),
         "without mesh compression"),
        (lambda glb: glb.document["meshes"][0]["primitives"][0].update(
            extensions={"KHR_draco_mesh_compression": {}}), "without mesh compression"),
        (lambda glb: glb.document["animations"][0]["samplers"][0].update(interpolation="MAGIC"),
         "not known"),
    ],
)  # fmt: skip
def test_what_cannot_be_shown_is_reported(how: Callable[[GlbFile], object], words: str) -> None:
    assert words in refusal(damaged(how))


def test_an_animation_that_runs_away_loses_only_the_steps_where_it_does(tmp_path: Path) -> None:
    away = [[0, 0, 0], [0, 0, 0], [np.nan, 0, 0]]
    (tmp_path / "away.glb").write_bytes(moved_box([0, 1, 2], away).content())
    with MeshSequence.open(tmp_path / "away.glb") as meshes:
        assert len(meshes.mesh(20).faces) == 12
        with pytest.raises(SurfaceError, match=r'Step 45 \("away.glb"\) has vertices that are not'):
            meshes.mesh(45)
        assert len(meshes.mesh(21).faces) == 12
