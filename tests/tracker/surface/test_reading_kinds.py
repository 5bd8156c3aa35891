"""What is promised of mesh files: the surface as it was written, or a plain sentence."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.files.parsing.glb import read_glb
from keypose.tracker.surface.files.parsing.obj import read_obj
from keypose.tracker.surface.files.parsing.ply import read_ply
from keypose.tracker.surface.files.parsing.raw import MeshRefused, RawMesh
from keypose.tracker.surface.files.parsing.tidying import tidy
from tests.tracker.surface.mesh_files import BOX, CORNERS, QUADS, GlbFile, obj, ply, standing_box

READERS = {"ply": read_ply, "obj": read_obj, "glb": read_glb}


def read(kind: str, content: bytes) -> RawMesh:
    return READERS[kind](io.BytesIO(content))


def corners(mesh: RawMesh) -> Array:
    """(F, 3, 3) the corners of every face, which say the same however vertices are numbered."""
    return mesh.vertices[mesh.faces]


def refusal(read: Callable[[], Any]) -> str:
    with pytest.raises(MeshRefused) as caught:
        read()
    sentence = str(caught.value)
    assert sentence.endswith(".")
    assert ": " in sentence  # what to do
    return sentence


# --- what other programs write ----------------------------------------------------------------


@pytest.mark.parametrize("kind", ["ply", "obj", "glb"])
def test_what_another_program_wrote_is_read_as_it_was(kind: str) -> None:
    written = trimesh.creation.icosphere(subdivisions=2, radius=0.9)
    exported = written.export(file_type=kind)
    content = exported.encode() if isinstance(exported, str) else exported
    mesh = read(kind, content)
    np.testing.assert_allclose(corners(mesh), written.vertices[written.faces], atol=1e-6)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_all_forms_of_ply_say_the_same(form: str) -> None:
    mesh = read("ply", ply(form=form))
    np.testing.assert_array_equal(mesh.faces, BOX)
    np.testing.assert_allclose(mesh.vertices, CORNERS, atol=1e-6)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_faces_of_different_corner_counts_are_cut_into_triangles(form: str) -> None:
    mixed = [*QUADS[:3], *BOX[6:].tolist()]
    mesh = read("ply", ply(faces=mixed, form=form))
    assert len(mesh.faces) == 12
    assert_closed(mesh.faces)


def test_faces_of_many_corners_are_cut_into_triangles_in_text_files() -> None:
    angle = np.linspace(0, 2 * np.pi, 7, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    tip = np.array([[0.0, 0.0, 1.0]])
    sides = [(k, (k + 1) % 7, 7) for k in range(7)]
    faces = [tuple(reversed(range(7))), *sides]
    mesh = read("obj", obj(np.vstack([ring, tip]), faces))
    assert len(mesh.faces) == 5 + 7
    assert_closed(mesh.faces)


def assert_closed(faces: NDArray[np.int64]) -> None:
    """Every edge runs once forward and once backward."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()
    assert sorted(map(tuple, edges)) == sorted((b, a) for a, b in edges)


# --- odd but legal ------------------------------------------------------------------------------


def test_a_ply_of_a_scanner_may_hold_colours_normals_and_textures_too() -> None:
    content = (
        b"ply\r\nformat ascii 1.0\r\nobj_info scan\r\nelement camera 1\r\nproperty float view\r\n"
        b"element vertex 3\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\n"
        b"property float nx\r\nproperty uchar red\r\nelement face 1\r\nproperty uchar flags\r\n"
        b"property list uchar float texcoord\r\nproperty list uchar uint vertex_index\r\n"
        b"end_header\r\n7\r\n0 0 0 1 255\r\n1 0 0 1 255\r\n0 1 0 1 255\r\n4 2 .5 .5 3 0 1 2\r\n"
    )
    mesh = read("ply", content)
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize("name", ["zncc", "quality"])
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_how_well_cameras_agree_is_read_from_the_vertices(name: str, form: str) -> None:
    agreement = np.linspace(-1, 1, 8)
    mesh = read("ply", ply(form=form, extra={"red": np.ones(8), name: agreement}))
    assert mesh.consistency is not None
    np.testing.assert_allclose(mesh.consistency, agreement, atol=1e-6)


def test_agreement_that_is_no_number_is_that_of_a_place_no_two_cameras_see() -> None:
    agreement = np.array([np.nan, 7.0, -3.0, 0.5, 0.5, 0.5, 0.5, 0.5])
    mesh = tidy(read("ply", ply(extra={"zncc": agreement})))
    assert mesh.consistency is not None
    assert mesh.consistency[:4].tolist() == [-1.0, 1.0, -1.0, 0.5]


def test_an_obj_may_number_backwards_name_textures_and_break_its_lines() -> None:
    content = (
        b"# by hand\nmtllib ../../etc/passwd\no thing\nv 0 0 0 1 1 1\nv 1 0 0 1 1 1\n"
        b"vt 0 0\nvn 0 0 1\nv 0 1 0\nf 1/1/1 2//1 \\\n 3/1\nusemtl gold\ns off\n"
        b"v 0 0 1 # top\nf -1 -3/1 1/1/1 # side\n"
    )
    mesh = read("obj", content)
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 1, 0]]
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]


def test_corners_numbered_backwards_count_from_the_vertices_above_their_face() -> None:
    content = (
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf -3 -2 -1\nf -6 5 -1\n"
    )
    assert read("obj", content).faces.tolist() == [[0, 1, 2], [3, 4, 5], [0, 4, 5]]
    too_far = read("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 -2 -1\nv 0 0 1\n")
    assert "not among its vertices" in refusal(lambda: tidy(too_far))


def test_parts_and_materials_of_an_obj_change_no_order_and_repeat_no_vertex() -> None:
    names = [b"usemtl a", b"usemtl b", b"g arm", b"o leg", b"s 1", b"usemtl a", b"g arm"]
    lines = obj().splitlines()
    for number, name in enumerate(names):
        lines.insert(9 + 2 * number, name)
    mesh = read("obj", b"mtllib a.mtl\n" + b"\n".join(lines))
    assert mesh.vertices.tolist() == CORNERS.tolist()
    assert mesh.faces.tolist() == BOX.tolist()


@pytest.mark.parametrize("kind", ["ply", "ascii", "obj"])
def test_the_triangles_of_a_polygon_stand_where_it_stood_around_its_first_corner(kind: str) -> None:
    polygons = [(0, 2, 3, 1), (4, 5, 6), (0, 1, 5, 7, 6), (2, 6, 7, 3)]
    expected = [
        [0, 2, 3], [0, 3, 1], [4, 5, 6], [0, 1, 5], [0, 5, 7], [0, 7, 6], [2, 6, 7], [2, 7, 3]
    ]  # fmt: skip
    write = {"ply": ply, "ascii": partial(ply, form="ascii"), "obj": obj}[kind]
    mesh = read("ply" if kind == "ascii" else kind, write(faces=polygons))
    assert mesh.faces.tolist() == expected
    np.testing.assert_allclose(mesh.vertices, CORNERS, atol=1e-6)


def test_a_text_ply_may_break_its_rows_anywhere() -> None:
    whole = ply(form="ascii")
    broken = whole.replace(b"\n3 0 2 1\n3 1 2 3\n", b"\n3\n0 2\n1 3 1 2 3\n")
    assert broken != whole
    assert read("ply", broken).faces.tolist() == BOX.tolist()


@pytest.mark.parametrize("form", ["binary_little_endian", "ascii"])
def test_what_follows_the_last_face_is_not_looked_at(form: str) -> None:
    assert read("ply", ply(form=form) + b"0 0 0\n").faces.tolist() == BOX.tolist()


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_lines_may_end_as_on_any_system(end: bytes) -> None:
    mesh = read("obj", (b"  " + obj()).replace(b"\n", end))
    np.testing.assert_array_equal(mesh.faces, BOX)
    np.testing.assert_allclose(mesh.vertices, CORNERS, atol=1e-6)


# --- the parts of a GLB -------------------------------------------------------------------------


def test_parts_of_a_glb_lie_where_its_nodes_put_them() -> None:
    glb = GlbFile()
    inner = glb.node(mesh=glb.mesh(glb.box(), glb.box()), scale=[2, 1, 1], translation=[1, 0, 0])
    outer = glb.node(children=[inner], rotation=[0, 0, np.sqrt(0.5), np.sqrt(0.5)])
    matrix = np.eye(4)
    matrix[:3, 3] = [0, 0, 9]
    other = glb.node(mesh=0, matrix=matrix.T.ravel().tolist())
    glb.document["scenes"] = [{"nodes": []}, {"nodes": [outer, other]}]
    glb.document["scene"] = 1
    turned = (CORNERS * [2, 1, 1] + [1, 0, 0]) @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    mesh = tidy(read("glb", glb.content()))
    expected = np.vstack([turned, CORNERS + np.array([0, 0, 9])])
    np.testing.assert_allclose(sorted(mesh.vertices.tolist()), sorted(expected.tolist()), atol=1e-6)
    assert len(mesh.faces) == 4 * len(BOX)


def test_only_what_hangs_in_the_scene_is_shown() -> None:
    glb = GlbFile()
    shown = glb.node(mesh=glb.mesh(glb.box()))
    glb.node(mesh=0, translation=[9, 0, 0])
    glb.document["scenes"] = [{"nodes": [shown]}]
    np.testing.assert_allclose(tidy(read("glb", glb.content())).vertices, CORNERS, atol=1e-6)


def test_a_mirrored_part_still_shows_its_outside() -> None:
    glb = GlbFile()
    glb.node(mesh=glb.mesh(glb.box()), scale=[-1, 1, 1])
    mesh = read("glb", glb.content())
    assert trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).volume > 0


def test_points_and_lines_of_a_glb_are_no_surface() -> None:
    glb = GlbFile()
    lone = {"attributes": {"POSITION": glb.numbers(CORNERS + 5)}}
    glb.node(mesh=glb.mesh({**lone, "mode": 0}, {**lone, "mode": 1}, glb.box()))
    np.testing.assert_allclose(tidy(read("glb", glb.content())).vertices, CORNERS, atol=1e-6)


def odd(**facts: Any) -> bytes:
    """A GLB with the box and more."""
    glb = GlbFile()
    glb.node(mesh=glb.mesh(glb.box()))
    glb.document |= facts
    return glb.content()


def odd_box(**facts: Any) -> bytes:
    """A GLB with a box that has more, or other indices."""
    glb = GlbFile()
    glb.node(mesh=glb.mesh({**glb.box(), **facts}))
    return glb.content()


def beyond() -> bytes:
    """A GLB whose first part has a corner that only the second has a vertex for."""
    glb = GlbFile()
    glb.node(mesh=glb.mesh(glb.box()))
    glb.document["meshes"][0]["primitives"][0]["indices"] = glb.numbers(BOX.ravel() + 1, "u2")
    glb.node(mesh=glb.mesh(glb.box()))
    return glb.content()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (odd(animations=[{"channels": [], "samplers": []}]), "numbered meshes, one per time step"),
        (odd(skins=[{"joints": [0]}]), "numbered meshes, one per time step"),
        (odd_box(targets=[{"POSITION": 0}]), "numbered meshes, one per time step"),
        (odd(extensionsUsed=["KHR_draco_mesh_compression"]), "without mesh compression"),
        (odd(extensionsRequired=["EXT_meshopt_compression"]), "without mesh compression"),
        (odd(extensionsUsed=["KHR_mesh_quantization"]), "without mesh compression"),
        (odd_box(mode=6), "plain triangles"),
        (odd(accessors=[{"sparse": {}}]), "plain triangles"),
        (odd(meshes=[]), "holds no vertices"),
        (odd(scenes=[{"nodes": []}]), "holds no vertices"),
        (beyond(), "not among its vertices"),
    ],
)
def test_what_a_glb_holds_besides_meshes_at_rest_is_refused(content: bytes, words: str) -> None:
    assert words in refusal(lambda: read("glb", content))


# --- a surface of what a file states ------------------------------------------------------------


@pytest.mark.parametrize("kind", ["ply", "obj"])
def test_vertices_that_a_file_repeats_are_one(kind: str) -> None:
    soup = CORNERS[BOX.ravel()]  # every face has corners of its own, as at the seams of a texture
    write = {"ply": ply, "obj": obj}[kind]
    stated = read(kind, write(soup, np.arange(36).reshape(12, 3)))
    assert stated.faces.tolist() == np.arange(36).reshape(12, 3).tolist()
    mesh = tidy(stated)
    assert mesh.vertices.shape == (8, 3)
    assert_closed(mesh.faces)
    np.testing.assert_allclose(corners(mesh), CORNERS[BOX], atol=1e-6)


def test_faces_without_extent_and_vertices_without_faces_are_left_out() -> None:
    vertices = np.vstack([[[9.0, 9, 9]], CORNERS, [[np.nan, 0, 0]]])
    faces = np.vstack([BOX + 1, [[1, 1, 2], [3, 3, 3]]])
    mesh = tidy(RawMesh(vertices, faces))
    assert mesh.vertices.tolist() == CORNERS.tolist()
    assert mesh.faces.tolist() == BOX.tolist()


def test_thin_faces_stay_for_without_them_there_would_be_holes() -> None:
    middle = (CORNERS[0] + CORNERS[1]) / 2  # on the edge between two faces, of one of them only
    faces = [*BOX[1:].tolist(), [0, 2, 8], [8, 2, 1], [0, 8, 1]]
    mesh = tidy(RawMesh(np.vstack([CORNERS, middle]), np.array(faces)))
    assert_closed(mesh.faces)


def test_an_edge_of_three_faces_is_no_reason_to_refuse() -> None:
    fin = np.vstack([CORNERS, [[0.2, -1.0, 0.0]]])
    mesh = tidy(RawMesh(fin, np.vstack([BOX, [[0, 1, 8]]])))
    assert len(mesh.faces) == 13


def test_the_order_of_vertices_and_faces_is_kept() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=2)
    mesh = tidy(RawMesh(np.array(sphere.vertices), np.array(sphere.faces)))
    assert mesh.vertices.tolist() == sphere.vertices.tolist()
    assert mesh.faces.tolist() == sphere.faces.tolist()


def test_agreement_of_vertices_that_become_one_is_averaged() -> None:
    soup = np.vstack([CORNERS, CORNERS])
    faces = np.vstack([BOX[:6], BOX[6:] + 8])
    mesh = tidy(RawMesh(soup, faces, np.r_[np.full(8, 0.2), np.full(8, 0.6)]))
    assert mesh.consistency is not None
    np.testing.assert_allclose(mesh.consistency, 0.4)


# --- what is no mesh ----------------------------------------------------------------------------


def many(count: int) -> bytes:
    return ply().replace(b"element face 12", b"element face %d" % count)


def lists(counted: bytes, count: float) -> bytes:
    """A PLY file whose first face has so many corners, counted in this type."""
    kind = {b"uint": "<u4", b"float": "<f4", b"double": "<f8", b"char": "<i1"}[counted]
    row = 1 + 3 * 4  # bytes of the face as it is written there
    head = ply(faces=[(0, 1, 2)]).replace(b"list uchar", b"list " + counted)[:-row]
    return head + np.array(count, kind).tobytes() + np.arange(3, dtype="<i4").tobytes()


@pytest.mark.parametrize(
    ("kind", "content", "words"),
    [
        ("ply", b"\x80\x04\x95pickle", "does not begin as a PLY file"),
        ("ply", b"ply\nformat ascii 1.0\n" + b"comment x\n" * 9000, "header without an end"),
        ("ply", b"ply\nformat morse 1.0\nend_header\n", "not understood"),
        ("ply", b"ply\nelement vertex 3\nend_header\n", "how it is written"),
        ("ply", many(0), "no faces, only points"),
        ("ply", many(10_000_000), "10,000,000 faces"),
        ("ply", ply()[:-5], "cut short"),
        ("ply", ply(form="ascii")[:-9], "cut short"),
        ("ply", ply(form="ascii")[:-20] + b"word\n", "something else where numbers"),
        ("ply", ply().replace(b"float y", b"float u"), "where its vertices are"),
        ("ply", ply().replace(b"float y", b"quad  y"), "unknown type"),
        ("ply", ply(extra={"z": CORNERS[:, 0]}).replace(b"face", b"tristrips"), "strips"),
        ("ply", b"ply\nformat ascii 1.0\nelement vertex -3\nend_header\n", "not understood"),
        ("obj", b"\0" * 200, "no text"),
        ("obj", b"hello there\n" * 40, "no vertices"),
        ("obj", obj(faces=[]), "no faces, only points"),
        ("obj", obj() + b"f 1 2 0\n", "numbered 0"),
        ("obj", obj() + b"f 1 2 x\n", "something else where numbers"),
        ("obj", obj() + b"f 1 2 1e300\n", "impossible corner"),
        ("obj", obj() + b"v 1 2\n", "fewer than 3 numbers"),
        ("ply", lists(b"uint", 0xFFFFFFFF), "impossible length"),
        ("ply", lists(b"float", np.nan), "impossible length"),
        ("ply", lists(b"double", 1e300), "impossible length"),
        ("ply", lists(b"char", -1), "impossible length"),
        ("ply", lists(b"uint", 900_000), "cut short"),
        ("glb", b"\x80\x04\x95pickle", "does not begin as a GLB file"),
        ("glb", standing_box()[:-40], "cut short"),
        ("glb", standing_box()[:200], "cut short"),
    ],
)  # fmt: skip
def test_what_is_no_mesh_is_refused_in_a_sentence(kind: str, content: bytes, words: str) -> None:
    assert words in refusal(lambda: read(kind, content))


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (RawMesh(CORNERS, BOX + 1), "not among its vertices"),
        (RawMesh(CORNERS, BOX - 1), "not among its vertices"),
        (RawMesh(CORNERS + np.array([0, np.nan, 0]), BOX), "not finite"),
        (RawMesh(CORNERS + np.array([0, np.inf, 0]), BOX), "not finite"),
        (RawMesh(CORNERS * 1e12, BOX), "farther than"),
        (RawMesh(CORNERS * 0, BOX), "larger than a point"),
        (RawMesh(CORNERS, np.zeros((4, 3), np.int64)), "larger than a point"),
        (RawMesh(np.outer(range(len(CORNERS)), [1.0, 2.0, 3.0]), BOX), "wider than a line"),
        (RawMesh(CORNERS * 1e-200, BOX), "larger than a point"),
    ],
)
def test_a_surface_that_is_nonsense_is_refused_in_a_sentence(mesh: RawMesh, words: str) -> None:
    with np.errstate(invalid="ignore"):
        assert words in refusal(lambda: tidy(mesh))


@given(
    kind=st.sampled_from(["ply", "text", "obj", "glb"]),
    changes=st.lists(st.tuples(st.floats(0, 1), st.binary(min_size=1, max_size=4)), max_size=3),
    kept=st.floats(0.3, 1),
)
def test_damage_gives_a_mesh_or_a_failure_and_never_a_face_without_vertices(
    kind: str, changes: list[tuple[float, bytes]], kept: float
) -> None:
    whole = {
        "ply": ply(), "text": ply(form="ascii"), "obj": obj(), "glb": standing_box()
    }[kind]  # fmt: skip
    damaged = bytearray(whole)
    for place, content in changes:
        start = int(place * len(damaged))
        damaged[start : start + len(content)] = content
    try:
        with np.errstate(all="ignore"):
            mesh = tidy(
                read("ply" if kind == "text" else kind, bytes(damaged[: int(kept * len(whole))]))
            )
    except Exception:  # noqa: BLE001 — the child answers whatever is raised with a sentence
        return
    assert np.isfinite(mesh.vertices).all()
    assert mesh.faces.min() >= 0
    assert mesh.faces.max() < len(mesh.vertices)


def test_no_other_file_is_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither what an OBJ calls its materials nor what a GLB calls its textures and buffers."""
    opened: list[object] = []
    for name in ("builtins.open", "io.open", "os.open", "socket.socket"):
        monkeypatch.setattr(name, lambda *found, **_: opened.append(found))
    read("obj", b"mtllib secret.mtl\n" + obj())
    read("ply", ply().replace(b"by hand", b"TextureFile secret.png"))
    glb = GlbFile()
    glb.document["images"] = [{"uri": "http://127.0.0.1/secret.png"}]
    glb.node(mesh=glb.mesh(glb.box()))
    read("glb", glb.content())
    glb.document["buffers"][0]["uri"] = "secret.bin"
    assert "in other files" in refusal(lambda: read("glb", glb.content()))
    assert opened == []


_READ_UNDER_WATCH = """
import io, json, sys
from keypose.tracker.surface.files.child import READERS
kind, content, opened = sys.argv[1], sys.stdin.buffer.read(), []
READERS[kind](io.BytesIO(content))  # so that nothing is imported while it is watched
def note(event, facts):
    if event.split(".")[0] in ("open", "os", "socket", "subprocess", "urllib", "shutil", "import"):
        opened.append(f"{event} {facts}")
sys.addaudithook(note)
READERS[kind](io.BytesIO(content))
seen = list(opened)
open("/dev/null").close()  # the watch is awake
print(json.dumps([seen, len(opened)]))
"""


def naming_others(kind: str) -> bytes:
    """A whole mesh that names files, addresses and commands wherever its kind has room for them."""
    if kind == ".glb":
        glb = GlbFile()
        glb.document["images"] = [{"uri": "http://127.0.0.1:1/a.png"}, {"uri": "/etc/passwd"}]
        glb.document["extensions"] = {"X_links": {"uri": "../../secret.glb"}}
        glb.node(mesh=glb.mesh(glb.box()))
        return glb.content()
    if kind == ".obj":
        called = b"call /etc/passwd\ncsh touch x\nmtllib http://127.0.0.1:1/a.mtl\n"
        return called + b"maplib /etc/passwd\nshadow_obj /etc/passwd\n" + obj() + b"call a.obj 1\n"
    return ply().replace(b"by hand", b"TextureFile /etc/passwd\nobj_info file:///etc/passwd")


@pytest.mark.parametrize("kind", [".ply", ".obj", ".glb"])
def test_nothing_that_a_file_names_is_opened_fetched_or_run(kind: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _READ_UNDER_WATCH, kind],
        input=naming_others(kind),
        cwd=Path(__file__).parents[3],
        stdout=subprocess.PIPE,
        check=True,
    )
    assert json.loads(done.stdout) == [[], 1]


@pytest.mark.parametrize(
    "uri", ["secret.bin", "/etc/passwd", "http://127.0.0.1:1/a.bin", "data:;base64,AAAA", "", None]
)
@pytest.mark.parametrize("number", [0, 1])
def test_numbers_that_a_glb_keeps_elsewhere_are_not_looked_for(
    uri: str | None, number: int
) -> None:
    glb = GlbFile()
    glb.document["buffers"] += [{"byteLength": 10**6}]
    glb.document["buffers"][number]["uri"] = uri
    glb.node(mesh=glb.mesh(glb.box()))
    for view in glb.document["bufferViews"]:
        view["buffer"] = number
    assert "in other files" in refusal(lambda: read("glb", glb.content()))
