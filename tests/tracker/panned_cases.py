"""A film from a camera that pans, with exact truth, and a session about it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.session import Keyframe, Session, VideoReference
from keypose.tracker.session.camera_motion import CameraMotion
from keypose.tracker.storage.files import save_session
from tests.tracker import session_cases as cases

FRAMES = 24
WIDTH = 320
HEIGHT = 180
CAMERA = Camera(width=WIDTH, height=HEIGHT, fx=300.0, fy=300.0, cx=159.5, cy=89.5)
PAN = np.radians(9.0)


def Rs_camera_world() -> Array:
    """(N, 3, 3) of a pan to the right with a little shake, the identity at first."""
    t = np.linspace(0, 1, FRAMES)
    shake = 0.003 * np.sin(np.arange(FRAMES) * 1.7)
    return exp_rotation(np.stack([shake, -PAN * t, 0.5 * shake], axis=1))


def path() -> CameraPath:
    return CameraPath.of(Rs_camera_world(), np.zeros((FRAMES, 3)), np.ones(FRAMES))


@lru_cache(maxsize=1)
def pictures() -> list[NDArray[np.uint8]]:
    """What such a camera sees of a wall far away."""
    rng = np.random.default_rng(3)
    wall = np.zeros((500, 900), np.float32)
    for scale in (2, 5, 12):
        noise = rng.normal(0, 1, (500 // scale + 2, 900 // scale + 2)).astype(np.float32)
        wall += cv2.resize(noise, (900, 500), interpolation=cv2.INTER_CUBIC) * scale**0.5
    wall = cv2.normalize(wall, None, 10, 245, cv2.NORM_MINMAX)
    middle = np.array([[1, 0, 290], [0, 1, 160], [0, 0, 1.0]])
    found = []
    for R in Rs_camera_world():
        H = CAMERA.K @ R @ np.linalg.inv(middle @ CAMERA.K)
        grey = cv2.warpPerspective(wall, H, (WIDTH, HEIGHT), flags=cv2.INTER_CUBIC)
        found.append(np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[..., None], 3, axis=2))
    return found


def session(motion: CameraMotion | None = None) -> Session:
    """A body that stands still in the world, keyed at three frames."""
    world = cases.pose(0.4)
    keyframes = []
    for frame in (2, 12, 22):
        R = Rs_camera_world()[frame]
        Rs = world.Rs_parent_part.copy()
        Rs[0] = R @ Rs[0]
        pose = Pose(Rs, R @ world.p_camera_root)
        keyframes.append(Keyframe.of(cases.SKELETON, pose, frame, frame / 25))
    video = VideoReference(
        path="film", fingerprint="", frame_count=FRAMES, width=WIDTH, height=HEIGHT,
        stands_still=False,
    )  # fmt: skip
    return Session.begin(
        video=video, camera=CAMERA, body=cases.body(), keyframes=tuple(keyframes),
        camera_motion=motion,
    )  # fmt: skip


def panned() -> Session:
    """The same with the camera's motion known."""
    return session(CameraMotion.of("turns", path(), np.full(FRAMES, 0.1)))


def write(folder: Path) -> Path:
    """The session's file beside its film."""
    (folder / "film").mkdir(parents=True)
    for number, picture in enumerate(pictures()):
        good, content = cv2.imencode(".png", picture)
        assert good
        (folder / "film" / f"{number:03}.png").write_bytes(content.tobytes())
    save_session(session(), folder / "session.json")
    return folder / "session.json"
