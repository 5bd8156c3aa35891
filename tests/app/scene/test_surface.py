"""An observed surface in the small views: few triangles, colours at its vertices, never doubled."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import viser._messages as messages

from keypose.app.render.tints import FAR_M, LEGENDS, clay, colours_for_tint, ramp
from keypose.app.scene.nodes import ROOT
from keypose.app.scene.observed import MOST_FACES, decimate, skin
from keypose.app.scene.scene import Stage
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.mesh import SurfaceMesh


def ball(rings: int) -> SurfaceMesh:
    """A closed ball of radius 1 m in rings × 2 rings of faces, about (0, 0, 4)."""
    turn = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    tilt = np.linspace(0.05, np.pi - 0.05, rings)
    around, up = np.meshgrid(turn, tilt)
    p = np.stack([np.sin(up) * np.cos(around), -np.cos(up), np.sin(up) * np.sin(around)], axis=-1)
    at = np.arange(2 * rings * (rings - 1)).reshape(rings - 1, 2 * rings)
    right = np.roll(at, -1, axis=1)
    below = at + 2 * rings
    one = np.stack([at, below, right], axis=-1)
    other = np.stack([right, below, np.roll(below, -1, axis=1)], axis=-1)
    faces = np.concatenate([one.reshape(-1, 3), other.reshape(-1, 3)])
    return SurfaceMesh(p.reshape(-1, 3) + np.array([0, 0, 4]), faces)


FINE = ball(150)
COARSE = ball(20)


def parts_of(glb: bytes) -> tuple[dict[str, Any], bytes]:
    """The document of a GLB and its numbers."""
    magic, version, length = struct.unpack_from("<III", glb)
    assert (magic, version, length) == (0x46546C67, 2, len(glb))
    (size,) = struct.unpack_from("<I", glb, 12)
    return json.loads(glb[20 : 20 + size]), glb[28 + size :]


def column(glb: bytes, name: str) -> Array:
    document, numbers = parts_of(glb)
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    accessor = document["accessors"][attributes[name]]
    view = document["bufferViews"][accessor["bufferView"]]
    count = 3 * accessor["count"]
    return np.frombuffer(numbers, "<f4", count, view["byteOffset"]).reshape(-1, 3).astype(float)


def test_a_fine_surface_has_few_triangles_left_and_keeps_its_shape() -> None:
    assert len(FINE.faces) > 5 * MOST_FACES
    thin = decimate(FINE.vertices, FINE.faces, MOST_FACES)
    assert MOST_FACES / 4 < len(thin.faces) <= MOST_FACES
    radii = np.linalg.norm(thin.vertices - [0, 0, 4], axis=1)
    assert np.abs(radii - 1).max() < 0.01


def test_a_coarse_surface_is_left_as_it_is() -> None:
    thin = decimate(COARSE.vertices, COARSE.faces, MOST_FACES)
    assert thin.faces is COARSE.faces
    assert thin.vertices is COARSE.vertices


def test_colours_go_along_with_what_the_vertices_became() -> None:
    thin = decimate(FINE.vertices, FINE.faces, MOST_FACES)
    left = FINE.vertices[:, 0] < 0
    colours = np.where(left[:, None], (200, 0, 0), (0, 0, 200)).astype(np.uint8)
    kept = thin.means(colours)
    far_left, far_right = thin.vertices[:, 0] < -0.1, thin.vertices[:, 0] > 0.1
    assert (kept[far_left] == [200, 0, 0]).all()
    assert (kept[far_right] == [0, 0, 200]).all()


def test_a_page_receives_a_surface_in_little_more_than_a_picture() -> None:
    assert len(skin(FINE, clay(len(FINE.vertices)))) < 300_000


def test_a_skin_lies_where_the_surface_does_in_linear_colours() -> None:
    colours = np.tile(np.array([255, 188, 0], np.uint8), (len(COARSE.vertices), 1))
    glb = skin(COARSE, colours)
    np.testing.assert_allclose(column(glb, "POSITION"), COARSE.vertices, atol=1e-5)
    np.testing.assert_allclose(column(glb, "COLOR_0")[0], [1, 0.503, 0], atol=1e-3)
    names = [material["name"] for material in parts_of(glb)[0]["materials"]]
    assert names == ["depth", "sheet"]  # static/views/looks.js goes by these names


def test_the_ramp_goes_from_clay_to_plum_and_darkens_all_the_way() -> None:
    shades = ramp(np.linspace(0, 1, 50)).astype(float) @ [0.299, 0.587, 0.114]
    assert (np.diff(shades) <= 0).all()
    assert (ramp(np.zeros(1)) == clay(1)).all()


def test_what_counts_in_full_and_what_is_near_is_clay() -> None:
    values = np.array([1.0, 0.0, np.nan])
    weights, metres = (
        colours_for_tint("contact", values),
        colours_for_tint("distance", FAR_M * (1 - values)),
    )
    np.testing.assert_array_equal(weights, metres)
    np.testing.assert_array_equal(weights[0], clay(1)[0])
    assert weights[1].sum() < weights[0].sum() / 2
    assert f"{100 * FAR_M:g} cm" in LEGENDS["distance"].plum


@pytest.fixture
def stage() -> Iterator[Stage]:
    made = Stage()
    yield made
    made.stop()


def reported(stage: Stage) -> list[messages.Message]:
    """All that the stage tells viser from now on."""
    received: list[messages.Message] = []
    wire: Any = stage._viser.server._websock_server
    report = wire.queue_message

    def queue_message(message: messages.Message) -> None:
        received.append(message)
        report(message)

    wire.queue_message = queue_message
    return received


def on_stage(received: list[messages.Message]) -> set[str]:
    """Names of the surfaces that are there after all this."""
    there: set[str] = set()
    for message in received:
        if isinstance(message, messages.GlbMessage):
            there.add(message.name)
        if isinstance(message, messages.RemoveSceneNodeMessage):
            there.discard(message.name)
    return there


def test_the_surface_before_stands_until_the_next_one_is_drawn(stage: Stage) -> None:
    received, glb = reported(stage), skin(COARSE, clay(len(COARSE.vertices)))
    stage.show_skin(glb)
    stage.settle_skin()
    assert on_stage(received) == {f"{ROOT}/surface/1"}
    stage.show_skin(glb)
    assert on_stage(received) == {f"{ROOT}/surface/0", f"{ROOT}/surface/1"}
    stage.settle_skin()
    assert on_stage(received) == {f"{ROOT}/surface/0"}


def test_never_more_than_two_stand_however_fast_they_come(stage: Stage) -> None:
    received, glb = reported(stage), skin(COARSE, clay(len(COARSE.vertices)))
    for _ in range(5):
        stage.show_skin(glb)
        assert len(on_stage(received)) <= 2


def test_without_a_surface_none_is_left(stage: Stage) -> None:
    received, glb = reported(stage), skin(COARSE, clay(len(COARSE.vertices)))
    stage.show_skin(glb)
    stage.show_skin(glb)
    stage.show_skin(None)
    assert on_stage(received) == set()
