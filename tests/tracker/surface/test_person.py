"""A person found in the images of calibrated cameras takes the place of silhouettes."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.errors import SurfaceError
from keypose.tracker.keypoints.blazepose import NAMES, Seen
from keypose.tracker.keypoints.detect import LOOK_PARTS
from keypose.tracker.keypoints.person_mask import MASK_SIDE, PersonMask
from keypose.tracker.keypoints.region import Region
from keypose.tracker.surface.cameras.hulls import Hulls
from keypose.tracker.surface.cameras.rig import Rig
from keypose.tracker.surface.placing import Placement
from tests.rendering.studio import write_studio
from tests.tracker.surface.ball_cases import P_BALL, RADIUS_M, studio

PLACED = Placement("m", "-y", np.zeros(3))
"""As the camera frame: what is written lies where the ball does."""
VIEWS, SHOTS = studio(3)
WIDTH = VIEWS[0].camera.width
HEIGHT = VIEWS[0].camera.height
WHOLE = Region((WIDTH - 1) / 2, (HEIGHT - 1) / 2, WIDTH)
BALL = Region(320.0, 240.0, 256.0)
VOXEL_M = 0.02


def radius_px() -> float:
    """Of the ball, which all cameras look straight at from equally far."""
    distance = float(np.linalg.norm(VIEWS[0].of_view(P_BALL)))
    return VIEWS[0].camera.fx * RADIUS_M / float(np.sqrt(distance**2 - RADIUS_M**2))


@dataclass
class Disc:
    """A network that sees the ball wherever it looks, its rim less surely than half."""

    sees: Callable[[NDArray[np.uint8], Region], bool] = lambda picture, region: True
    looked: list[Region] = field(default_factory=list)
    fingerprint: str = "disc"

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        self.looked.append(region)
        to_picture = region.to_picture(MASK_SIDE)
        rows, columns = np.indices((MASK_SIDE, MASK_SIDE))
        uv = np.stack([columns, rows], axis=-1) @ to_picture[:, :2].T + to_picture[:, 2]
        away = np.linalg.norm(uv - (WHOLE.x, WHOLE.y), axis=-1) / radius_px()
        share = np.select([away < 1, away < 1.4], [0.9, 0.4])
        presence = float(self.sees(picture, region))
        points = len(NAMES)
        p_hips = np.zeros((points, 3))
        mask = PersonMask.of(region, share)
        return Seen(np.zeros((points, 2)), np.ones(points), p_hips, presence, BALL, mask)


@pytest.fixture
def cameras(tmp_path: Path) -> Path:
    return write_studio(tmp_path, VIEWS, [SHOTS] * 3, PLACED)


def changed(cameras: Path, **fields: object) -> Rig:
    """The cameras with fields exchanged, by the file."""
    data = json.loads(cameras.read_bytes())
    for camera in data["cameras"]:
        camera |= fields
    cameras.write_text(json.dumps(data))
    return Rig.open(cameras)


def test_a_ball_seen_by_a_network_has_the_hull_of_its_silhouettes(cameras: Path) -> None:
    with Hulls(Rig.open(cameras), VOXEL_M) as masked:
        expected = masked.mesh(0)
    with Hulls(changed(cameras, silhouettes=None), VOXEL_M, Disc()) as hulls:
        assert hulls.step_count == 3
        mesh = hulls.mesh(0)
    assert mesh.consistency is not None
    assert np.linalg.norm(mesh.vertices - P_BALL, axis=1).min() == pytest.approx(
        RADIUS_M, abs=VOXEL_M / 2
    )
    for bound in (np.min, np.max):
        of_both = [bound(each.vertices, axis=0) for each in (mesh, expected)]
        np.testing.assert_allclose(*of_both, atol=VOXEL_M)
    assert hulls.left_out == {}


@pytest.mark.parametrize(
    ("box", "first"),
    [(None, WHOLE), ((220, 90, 410, 460), Region.of_box((220, 90, 410, 460), WIDTH, HEIGHT))],
)
def test_the_first_step_is_looked_at_in_the_box_or_whole_and_others_where_it_was_before(
    cameras: Path, box: tuple[float, ...] | None, first: Region
) -> None:
    network = Disc()
    with Hulls(changed(cameras, box=box), VOXEL_M, network) as hulls:
        hulls.mesh(0)
        assert network.looked == [first.rounded(LOOK_PARTS), BALL] * 3
        network.looked.clear()
        hulls.mesh(1)
        assert network.looked == [BALL] * 3, "where it stays, no look more"


def test_who_is_lost_is_looked_for_as_at_first(cameras: Path) -> None:
    network = Disc()
    with Hulls(Rig.open(cameras), VOXEL_M, network) as hulls:
        hulls.mesh(0)
        network.looked.clear()
        network.sees = lambda picture, region: len(network.looked) > 1
        hulls.mesh(1)
    assert network.looked[:2] == [BALL, WHOLE.rounded(LOOK_PARTS)]


def test_a_camera_that_shows_nobody_is_left_out_and_told(cameras: Path) -> None:
    hidden = cameras.parent / VIEWS[1].name / "images" / "0001.png"
    cv2.imwrite(str(hidden), np.zeros((HEIGHT, WIDTH), np.uint8))
    with Hulls(Rig.open(cameras), VOXEL_M, Disc(lambda picture, _: bool(picture.any()))) as hulls:
        for step in range(3):
            hulls.mesh(step)
    assert hulls.left_out == {VIEWS[1].name: {1}}


def test_one_camera_alone_makes_no_hull(cameras: Path) -> None:
    network = Disc()
    network.sees = lambda picture, region: len(network.looked) <= 2
    alone = pytest.raises(SurfaceError, match=r'found by 1 of the 3 cameras.*give a "box"')
    with Hulls(Rig.open(cameras), VOXEL_M, network) as hulls, alone:
        hulls.mesh(0)
    assert hulls.left_out == {}  # the step is refused, and says why


@pytest.mark.parametrize(
    ("box", "words"),
    [
        ((9, 9, 9, 90), "Camera 'camera_00': The box around the person has no size"),
        ((700, 9, 800, 90), "Camera 'camera_00': The box around the person lies outside"),
    ],
)
def test_a_box_that_is_none_is_refused(cameras: Path, box: tuple[float, ...], words: str) -> None:
    with pytest.raises(SurfaceError, match=words):
        Hulls(changed(cameras, box=box), VOXEL_M, Disc())


def test_a_person_needs_images(cameras: Path) -> None:
    with pytest.raises(SurfaceError, match="Only 0 of the 3 cameras have images: at least two"):
        Hulls(changed(cameras, images=None), VOXEL_M, Disc())
