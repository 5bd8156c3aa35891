"""What a rig's cameras took, read by step."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from keypose.tracker.errors import SurfaceError
from keypose.tracker.surface.cameras.footage import Footage
from keypose.tracker.surface.cameras.hull import surface_of
from keypose.tracker.surface.cameras.rig import Rig
from keypose.tracker.surface.placing import Placement
from tests.rendering.ring import ring_of
from tests.rendering.studio import write_studio
from tests.tracker.surface.ball_cases import P_BALL, ball_field, studio

PLACED = Placement("cm", "+z", np.array([0.0, 0.5, 3.8]))


@pytest.fixture
def cameras(tmp_path: Path) -> Path:
    views, shots = studio(4)
    return write_studio(tmp_path, views, [shots, shots], PLACED)


def opened(cameras: Path, what: str = "images") -> Footage:
    assert what in ("images", "silhouettes")
    return Footage(Rig.open(cameras), what, PLACED.p_camera_surface)  # type: ignore[arg-type]


def changed(cameras: Path, **fields: object) -> None:
    """The first camera's fields exchanged."""
    data = json.loads(cameras.read_bytes())
    data["cameras"][0] |= fields
    cameras.write_text(json.dumps(data))


def test_pictures_and_silhouettes_are_those_taken(cameras: Path) -> None:
    _, shots = studio(4)
    with opened(cameras) as images, opened(cameras, "silhouettes") as shapes:
        assert images.frame_count == shapes.frame_count == 2
        views, pictures = images.pictures(1)
        _, insides = shapes.silhouettes(1)
    assert [view.name for view in views] == [view.name for view in ring_of(4, P_BALL)]
    for shot, picture, inside in zip(shots, pictures, insides, strict=True):
        assert np.abs(picture.astype(int) - shot.picture).max() <= 1  # of grey through colour
        np.testing.assert_array_equal(inside.inside, shot.inside)
        assert inside.known is None


def test_a_mesh_is_judged_where_the_session_places_it(cameras: Path) -> None:
    mesh = surface_of(ball_field(P_BALL, 0.3))
    with opened(cameras) as images:
        zncc = images.rate(mesh, 0).consistency
    assert zncc is not None
    assert np.median(zncc[zncc > -1]) > 0.6


def test_a_picture_that_cannot_be_read_leaves_the_others(cameras: Path) -> None:
    (cameras.parent / "camera_02" / "images" / "0001.png").write_bytes(b"no picture")
    with opened(cameras) as images:
        assert len(images.pictures(0)[0]) == 4
        assert [view.name[-1] for view in images.pictures(1)[0]] == ["0", "1", "3"]


def test_beyond_the_rim_of_a_straightened_silhouette_nothing_is_known(cameras: Path) -> None:
    changed(cameras, distortion=[0.3, 0.0, 0.0, 0.0, 0.0])
    with opened(cameras, "silhouettes") as shapes:
        views, found = shapes.silhouettes(0)
    known = found[0].known
    assert known is not None
    assert not known[0, 0]
    assert known[240, 320]
    assert not (found[0].inside & ~known).any()
    assert not views[0].camera.is_distorted


def test_pictures_of_another_size_are_refused(cameras: Path) -> None:
    changed(cameras, width=639)
    with pytest.raises(SurfaceError, match="640×480 pixels instead of the 639×480"):
        opened(cameras)


def test_cameras_with_different_numbers_of_pictures_are_refused(cameras: Path) -> None:
    (cameras.parent / "camera_03" / "images" / "0001.png").unlink()
    with pytest.raises(SurfaceError, match="'camera_00' has 2 images and camera 'camera_03' 1"):
        opened(cameras)


def test_at_least_two_cameras_must_name_their_pictures(cameras: Path) -> None:
    data = json.loads(cameras.read_bytes())
    for camera in data["cameras"][1:]:
        camera["images"] = None
    cameras.write_text(json.dumps(data))
    with pytest.raises(SurfaceError, match="Only 1 of the 4 cameras have images"):
        opened(cameras)


def test_a_video_will_do_as_well_as_a_folder(cameras: Path) -> None:
    from keypose.sample_videos.make_samples import encode

    _, shots = studio(4)
    colour = np.stack([cv2.cvtColor(shots[0].picture, cv2.COLOR_GRAY2RGB)] * 2)
    encode(np.asarray(colour, np.uint8), cameras.parent / "north.mp4", crf=6)
    changed(cameras, images="north.mp4")
    with opened(cameras) as images:
        _, pictures = images.pictures(1)
    assert np.abs(pictures[0].astype(int) - shots[0].picture).mean() < 3
