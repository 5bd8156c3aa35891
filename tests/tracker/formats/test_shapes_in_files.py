"""Bodies of every shape in the files that other programs read."""

from __future__ import annotations

import numpy as np
import trimesh

from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.shapes import Capsule, Frustum, Solid
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.formats.conventions import end_site
from keypose.tracker.formats.glb import glb
from keypose.tracker.formats.joint_names import matched
from keypose.tracker.formats.marker_sets import places_of
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rigs.skin import lit_mesh
from keypose.tracker.storage.tracks import Tracks
from keypose.tracker.tracking.result import Diagnostics
from tests.tracker.formats.glb_reading import Player
from tests.tracker.formats.recordings import bvh_of
from tests.tracker.shape_cases import every_shape, pair_of, solid_of
from tests.tracker.tracking_cases import CAMERA, random_trajectory


def recorded(skeleton: Skeleton, frames: int = 3) -> Recording:
    motion = random_trajectory(skeleton, 1, frames)
    steps = np.zeros((frames - 1, skeleton.part_count))
    found = Diagnostics(
        np.zeros(frames - 1, np.int64), np.zeros((frames - 1, skeleton.dof_count)), steps, steps
    )
    names = skeleton.body.names
    tracks = Tracks(0, names, motion.Rs_parent_part, motion.ps_camera_root, found)
    return Recording(
        skeleton, CAMERA, tracks, (), np.arange(frames) / 30, np.array([0.0, -1.0, 0.0])
    )


@every_shape
def test_a_glb_shows_the_shape_with_its_outside_out(shape: Solid) -> None:
    made = recorded(Skeleton.of(pair_of(shape)))
    content = glb(made, ["one"] * 3, {"one": (0, 0, 255)})
    own = solid_of(shape.mesh())
    solids = Player.of(content).solids()
    assert len(solids) == made.skeleton.part_count
    for vertices, faces in solids.values():
        solid = trimesh.Trimesh(vertices, faces)
        assert solid.is_watertight
        np.testing.assert_allclose(solid.volume, own.volume, rtol=1e-4)


@every_shape
def test_its_normals_in_a_glb_point_outward(shape: Solid) -> None:
    vertices, normals, _ = lit_mesh(shape)
    assert (np.sum(normals * (vertices - shape.centre), axis=1) > 0).all()


@every_shape
def test_a_bvh_ends_a_limb_without_landmarks_in_its_far_end(shape: Solid) -> None:
    bare = Part(name="one", shape=shape)
    assert end_site(bare) == shape.far_end
    skeleton = Skeleton.of(Body(name="one", parts=(bare,)))
    text = bvh_of(skeleton, random_trajectory(skeleton, 1, 2), 0.04)
    x, y, z = shape.far_end
    offset = text.partition("End Site")[2].split("OFFSET")[1].split()[:3]
    np.testing.assert_allclose([float(v) for v in offset], [x, -y, -z], atol=1e-6)


@every_shape
def test_the_marker_of_a_head_is_in_its_middle(shape: Solid) -> None:
    skeleton = Skeleton.of(Body(name="one", parts=(Part(name="head", shape=shape),)))
    assert places_of(skeleton, ["Head"], "a.csv") == (((0, shape.centre),),)


@every_shape
def test_a_face_is_known_where_the_shape_says_where_it_is(shape: Solid) -> None:
    skeleton = Skeleton.of(Body(name="one", parts=(Part(name="head", shape=shape),)))
    face = shape.face_points()
    assert bool(face) == isinstance(shape, Frustum | Capsule)
    if face:
        x, y, z = face["left_eye"]
        assert face["right_eye"] == (-x, y, z)
        assert -z > 0.5 * shape.half_widths(y)[1]
        found = matched(
            skeleton, ["nose", "left_eye", "right_eye", "left_ear", "right_ear"], "a.csv"
        )
        places = {ours: place for _, ours, place in found.known}
        assert places["nose"] == ((0, face["nose"]),)
