"""Films by cameras that turn, zoom and move, with all that is true of them, kept on disk.

film = camera_film("walk-around")
for grey in film.grey(): ...      # (H, W) uint8, frame after frame
film.path                         # where the camera was, exactly
film.motion, film.motion_world    # the person, seen from the camera and in the world
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from bench.camera_worlds import Floats, Panorama, Room
from bench.clips import clip
from bench.keeping import ROOT, digest, place_for
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.body.raster import raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import (
    Array,
    apply_transform,
    exp_rotation,
    log_rotation,
    rotation_between,
    transform,
)
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.video import Video
from keypose.tracker.video.encode import MP4, FilmWriter
from tests.rendering.angles import Angles, wave
from tests.rendering.ground import lowest_sole
from tests.rendering.render import TO_LIGHT, Stage, add_body
from tests.rendering.settings import RenderSettings

FPS = 30
WIDTH = 960
HEIGHT = 540
FLOOR_M = 1.4
"""The room's floor below the camera at the first frame, but for its shake."""
NEARLY_LOSSLESS = replace(MP4, options={"crf": "6", "preset": "veryfast"})
STRIPS = 27
"""Of a picture by a rolling shutter, each seen at a moment of its own."""
FEET = ("left_foot", "right_foot")


@dataclass(frozen=True, eq=False)
class CameraFilm:
    """A film and what is true of it.

    path:         of the camera, its world the camera's frame at frame 0.
    hidden:       (N, H, W/8) packed bits of the pixels that do not show the background.
    motion:       of the person, in the camera's frame at each frame; motion_world: in the world.
    stances:      part, first and last frame of feet that stand still in the world, all of it exact.
    """

    name: str
    video: Path
    camera: Camera
    path: CameraPath
    hidden: NDArray[np.uint8]
    skeleton: Skeleton | None = None
    motion: Trajectory | None = None
    motion_world: Trajectory | None = None
    stances: tuple[tuple[str, int, int], ...] = ()

    def __len__(self) -> int:
        return len(self.path)

    def grey(self) -> Iterator[NDArray[np.uint8]]:
        """Grey pictures (H, W), decoded one after the other."""
        with Video.open(self.video, cache_bytes=0) as video:
            for _, picture in video.frames(0, len(self)):
                assert picture is not None
                yield np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))

    def mask(self, frame: int, grown_px: int = 12) -> NDArray[np.bool_]:
        """(H, W) what is not background, with a margin."""
        bits = np.unpackbits(self.hidden[frame], axis=-1, count=self.camera.width)
        size = (2 * grown_px + 1,) * 2
        return cv2.dilate(bits, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, size)) > 0


@dataclass(frozen=True, eq=False)
class Plan:
    """A film before it is rendered. path and motion: in a world of its own, floor below it.

    scenery: gives the background (H, W, 3) that a camera sees.
    shutter: share of the frame time that it is open.  readout: of the frame time, from the first
    row to the last; the path is that of the middle row.
    """

    path: CameraPath
    motion: Trajectory
    focal_px: float
    scenery: Callable[[], Panorama | Room]
    shutter: float = 0.0
    noise: float = 2.0
    exposure: float = 0.08
    readout: float = 0.0

    @property
    def camera(self) -> Camera:
        cx, cy = (WIDTH - 1) / 2, (HEIGHT - 1) / 2
        f = self.focal_px
        return Camera(width=WIDTH, height=HEIGHT, fx=f, fy=f, cx=cx, cy=cy)

    @property
    def key(self) -> bytes:
        """What it is told from others by."""
        motion, plain = self.motion, (self.focal_px, self.shutter, self.noise, self.exposure)
        plain += (self.readout, "spline") if self.readout else ()
        arrays = (self.path.Ts_camera_world, self.path.zoom, motion.Rs_parent_part)
        return b"".join([*(a.tobytes() for a in arrays), repr(plain).encode()])


def camera_film(name: str) -> CameraFilm:
    """The film of a name in FILMS; rendered if it is not kept yet. Absent without its material."""
    return WARPED[name]() if name in WARPED else _rendered_film(name)


def _rendered_film(name: str) -> CameraFilm:
    plan, skeleton = PLANS[name](), Skeleton.of(preset("adult_male"))
    video, beside = _places(name, plan.key)
    if not (video.is_file() and beside.is_file()):
        _write(_pictures(plan, skeleton), video, beside)
    T_world = np.linalg.inv(plan.path.Ts_camera_world[0])
    path = CameraPath(plan.path.Ts_camera_world @ T_world, plan.path.zoom)
    motion_world = moved(plan.motion, np.linalg.inv(T_world)[None])
    return CameraFilm(
        name,
        video,
        plan.camera,
        path,
        np.load(beside, mmap_mode="r"),
        skeleton,
        moved(motion_world, path.Ts_camera_world),
        motion_world,
        tuple((foot, 0, len(path) - 1) for foot in FEET),
    )


def _places(name: str, key: bytes) -> tuple[Path, Path]:
    """Where a film is kept, and what hides its background."""
    rendering = [ROOT / "tests" / "rendering" / f"{n}.py" for n in ("render", "shade", "texture")]
    made_by = digest(Path(__file__).with_name("camera_worlds.py"), *rendering, key)
    plain = "camera-" + name.replace(" ", "-").replace(",", "")
    return place_for(plain, made_by, ".mp4"), place_for(plain, made_by, ".npy")


def moved(motion: Trajectory, Ts: Array) -> Trajectory:
    """A motion (N) in another frame, by Ts (N or 1, 4, 4)."""
    Rs, ps = motion.writable()
    Rs[:, 0] = Ts[:, :3, :3] @ Rs[:, 0]
    ps = (Ts[:, :3, :3] @ ps[..., None])[..., 0] + Ts[:, :3, 3]
    return Trajectory(motion.first_frame, Rs, ps)


def _write(
    pictures: Iterator[tuple[NDArray[np.uint8], NDArray[np.bool_]]], video: Path, beside: Path
) -> None:
    """The film, and what hides its background."""
    hidden, unfinished = [], video.with_suffix(".part.mp4")
    with FilmWriter(
        unfinished, (WIDTH, HEIGHT), Fraction(1, FPS), Fraction(FPS), kind=NEARLY_LOSSLESS
    ) as film:
        for pts, (picture, body) in enumerate(pictures):
            film.add(picture, pts)
            hidden.append(np.packbits(body, axis=-1))
    np.save(beside, np.stack(hidden))
    unfinished.replace(video)


def _pictures(
    plan: Plan, skeleton: Skeleton
) -> Iterator[tuple[NDArray[np.uint8], NDArray[np.bool_]]]:
    """Every frame, and where the person is on it."""
    scenery, rng = plan.scenery(), np.random.default_rng(5)
    stage = Stage.of(skeleton, plan.camera, RenderSettings(noise=0.0))
    shares = (np.arange(5) + 0.5) / 5 - 0.5 if plan.shutter else np.zeros(1)
    for frame in range(len(plan.path)):
        light, body = 0.0, np.zeros((HEIGHT, WIDTH), np.bool_)
        for moment in plan.shutter * shares:
            one, where = _read_out(plan, scenery, stage, frame + float(moment))
            light, body = light + one / len(shares), body | where
        light = light * (1 + plan.exposure * np.sin(frame / 40))
        light = light + plan.noise * rng.standard_normal(light.shape, dtype=np.float32)
        yield np.clip(np.rint(light), 0, 255).astype(np.uint8), body


def _read_out(
    plan: Plan, scenery: Panorama | Room, stage: Stage, time: float
) -> tuple[Floats, NDArray[np.bool_]]:
    """The light (H, W, 3) about a moment, strip after strip, and where the person is."""
    if not plan.readout:
        return _exposed(plan, scenery, stage, time, (0, HEIGHT))
    edges = np.linspace(0, HEIGHT, STRIPS + 1).astype(int)
    strips = []
    for first, beyond in pairwise(edges.tolist()):
        late = plan.readout * ((first + beyond) / 2 / HEIGHT - 0.5)
        strips.append(_exposed(plan, scenery, stage, time + late, (first, beyond)))
    return np.concatenate([s[0] for s in strips]), np.concatenate([s[1] for s in strips])


def _exposed(
    plan: Plan, scenery: Panorama | Room, stage: Stage, time: float, rows: tuple[int, int]
) -> tuple[Floats, NDArray[np.bool_]]:
    """The light (rows, W, 3) of some rows at a moment, and where the person is."""
    T, zoom = _smoothly_at(plan.path, time) if plan.readout else _at(plan.path, time)
    f, first = zoom * plan.focal_px, rows[0]
    camera = plan.camera.model_copy(
        update={"fx": f, "fy": f, "cy": plan.camera.cy - first, "height": rows[1] - first}
    )
    light = np.ascontiguousarray(scenery.seen(camera, T))
    view = ViewCamera.of(camera)
    Ts = T @ _posed(plan.motion, stage.skeleton, time)
    add_body(light, replace(stage, view=view, to_light=T[:3, :3] @ TO_LIGHT), Ts)
    return light, raster(stage.mesh, Ts, view).part >= 0


def _at(path: CameraPath, time: float) -> tuple[Array, float]:
    """T_camera_world and zoom between two frames."""
    i = int(np.clip(np.floor(time), 0, len(path) - 2))
    share, Ts = time - i, path.Ts_camera_world
    R = rotation_between(Ts[i, :3, :3], Ts[i + 1, :3, :3], [share])[0]
    p = (1 - share) * Ts[i, :3, 3] + share * Ts[i + 1, :3, 3]
    return transform(R, p), float((1 - share) * path.zoom[i] + share * path.zoom[i + 1])


def _smoothly_at(path: CameraPath, time: float) -> tuple[Array, float]:
    """The same on a cubic spline through the frames about: hands do not jerk at every frame."""
    first = int(np.clip(np.floor(time) - 4, 0, max(len(path) - 10, 0)))
    Ts = path.Ts_world_camera[first : first + 10]
    places = np.concatenate([log_rotation(Ts[:, :3, :3]), Ts[:, :3, 3]], axis=1)
    place = CubicSpline(np.arange(first, first + len(Ts)), places)(time)
    T_world_camera = transform(exp_rotation(place[:3]), place[3:])
    return np.linalg.inv(T_world_camera), 1.0


def _posed(motion: Trajectory, skeleton: Skeleton, time: float) -> Array:
    """Ts_world_part (P, 4, 4) between two frames."""
    i = int(np.clip(np.floor(time), 0, len(motion) - 2))
    Rs, ps = motion.Rs_parent_part, motion.ps_camera_root
    R = rotation_between(Rs[i], Rs[i + 1], [time - i])[0]
    return part_transforms(skeleton, R, (1 - time + i) * ps[i] + (time - i) * ps[i + 1])


# --- persons and paths


def standing_person(frames: int, p_floor: tuple[float, float, float]) -> Trajectory:
    """Someone whose feet stand still, all above the hips in lively motion."""
    skeleton, s = Skeleton.of(preset("adult_male")), np.arange(frames) / FPS
    a = Angles(skeleton, frames)
    a.turn("waist", 0.02, 0.25)
    a.turn("chest", 0.12 * wave(s, 0.31), 0.35 * wave(s, 0.23, 0.3), 0.10 * wave(s, 0.17, 1.1))
    a.turn("head", 0.15 * wave(s, 0.42, 0.6), 0.35 * wave(s, 0.27))
    for side, sign, hz in (("left", 1.0, 0.33), ("right", -1.0, 0.41)):
        a.turn(f"{side}_upper_arm", -0.7 + 0.6 * wave(s, hz), 0, -sign * (0.4 + 0.3 * wave(s, hz)))
        a.turn(f"{side}_forearm", -1.0 + 0.7 * wave(s, 1.3 * hz, 1.0))
        a.turn(f"{side}_thigh", -0.05 * sign, 0.0, -0.09 * sign)
        a.turn(f"{side}_shin", 0.08)
    down = float(lowest_sole(skeleton, a.rotations()[:1])[0])
    return a.trajectory(np.subtract(p_floor, (0.0, down, 0.0)))


def shaken(frames: int, rms: float, seed: int, seconds: float = 0.12) -> Array:
    """(N, 3) of a hand that is never quite still."""
    rng = np.random.default_rng([seed, 3])
    slow, quick = (
        gaussian_filter1d(rng.standard_normal((frames, 3)), FPS * wide, axis=0)
        for wide in (seconds, seconds / 3)
    )
    return np.asarray(rms * (slow / slow.std(axis=0) + 0.12 * quick / quick.std(axis=0)))


def hand_held(
    p_world: Array,
    yaw: Array,
    pitch: Array,
    seed: int,
    turn_deg: float = 0.4,
    move_m: float = 0.015,
) -> CameraPath:
    """A camera carried along p_world (N, 3), turned by yaw and pitch (N,), radians."""
    count = len(p_world)
    zero = np.zeros(count)
    R = exp_rotation(np.stack([zero, yaw, zero], -1))
    R = R @ exp_rotation(np.stack([pitch, zero, zero], -1))
    R = R @ exp_rotation(shaken(count, np.radians(turn_deg), seed))
    T_world_camera = transform(R, p_world + shaken(count, move_m, seed + 1))
    return CameraPath(np.linalg.inv(T_world_camera), np.ones(count))


def _turning(frames: int, shutter: float = 0.0) -> Plan:
    """Pan, tilt and zoom there and back, from a tripod that shakes a little."""
    turn = np.sin(2 * np.pi * np.arange(frames) / (frames - 1))
    yaw, pitch = np.radians(18.0) * turn, np.radians(4.0) * np.sin(np.pi * turn)
    path = hand_held(np.zeros((frames, 3)), yaw, pitch, 11, turn_deg=0.05, move_m=0.0)
    zoom = 1.0 + 0.6 * np.sin(np.pi * np.arange(frames) / (frames - 1)) ** 2
    person = standing_person(frames, (0.0, 0.95, 5.2))
    return Plan(CameraPath(path.Ts_camera_world, zoom), person, 960.0, Panorama.of, shutter)


def _walk_around(
    frames: int = 300, shutter: float = 0.0, noise: float = 2.0, readout: float = 0.0
) -> Plan:
    """3 m on an arc about the person, who stays in the picture's middle."""
    centre, radius = np.array([0.0, 0.0, 2.9]), 2.9
    angle = 3.0 / radius * _eased(frames)
    away = np.stack([np.sin(angle), np.zeros(frames), -np.cos(angle)], -1)
    p = centre + radius * away
    p[:, 1] += 0.012 * np.sin(2 * np.pi * 1.8 * np.arange(frames) / FPS)
    wander = np.radians(1.5) * np.sin(np.arange(frames) / 37)
    path = hand_held(p, -angle + wander, np.full(frames, np.radians(-8.0)), 21)
    person = standing_person(frames, (0.0, FLOOR_M, 2.9))
    return Plan(path, person, 720.0, Room.of, shutter, noise, readout=readout)


def _dolly(frames: int = 300) -> Plan:
    """2 m straight ahead, toward and past a person at the side."""
    p = np.outer(_eased(frames), [0.0, 0.0, 2.0])
    path = hand_held(p, np.zeros(frames), np.full(frames, np.radians(-4.0)), 31)
    return Plan(path, standing_person(frames, (0.6, FLOOR_M, 4.6)), 720.0, Room.of)


def _still_hand(frames: int = 300) -> Plan:
    """Someone who films from one place, by hand."""
    zero = np.zeros(frames)
    path = hand_held(np.zeros((frames, 3)), zero, zero - np.radians(8.0), 41, 0.5, 0.015)
    return Plan(path, standing_person(frames, (0.0, FLOOR_M, 2.9)), 720.0, Room.of)


def _turn_then_walk(frames: int = 300) -> Plan:
    """A third of the film turns only; then 2 m to the side."""
    share = np.clip((np.arange(frames) - frames / 3) / (frames * 2 / 3), 0, 1)
    p = np.outer(3 * share**2 - 2 * share**3, [2.0, 0.0, 0.3])
    yaw = np.radians(10) * np.sin(np.arange(frames) / 30)
    path = hand_held(p, yaw, np.full(frames, np.radians(-4.0)), 51, 0.3, 0.0)
    return Plan(path, standing_person(frames, (0.8, FLOOR_M, 3.6)), 720.0, Room.of)


def _there_and_back(frames: int = 600) -> Plan:
    """2.5 m on an arc and back, looking well to either side: all that was seen comes back."""
    centre, radius, share = np.array([0.0, 0.0, 2.9]), 2.9, np.linspace(0, 1, frames)
    angle = 2.5 / radius * np.sin(np.pi * share) ** 2
    p = centre + radius * np.stack([np.sin(angle), np.zeros(frames), -np.cos(angle)], -1)
    aside = np.radians(25) * np.sin(4 * np.pi * share)
    path = hand_held(p, -angle + aside, np.full(frames, np.radians(-8.0)), 61)
    return Plan(path, standing_person(frames, (0.0, FLOOR_M, 2.9)), 720.0, Room.of)


def _eased(frames: int) -> Array:
    """(N,) from 0 to 1 at even speed but for the ends."""
    x = np.linspace(0, 1, frames)
    speed = np.clip(np.minimum(x, 1 - x) / 0.1, 0.02, 1)
    return np.concatenate([[0], np.cumsum(speed[1:])]) / speed[1:].sum()


ROLLING = "walk-around, rolling shutter"
READOUT = 0.6

PLANS: dict[str, Callable[[], Plan]] = {
    "pan and zoom": lambda: _turning(1000),
    "pan and zoom, blurred": lambda: _turning(300, shutter=0.5),
    "walk-around": _walk_around,
    "walk-around, blurred, noisy": lambda: _walk_around(150, 0.5, 7.0),
    ROLLING: lambda: _walk_around(150, readout=READOUT),
    "dolly": _dolly,
    "still hand": _still_hand,
    "turn, then walk": _turn_then_walk,
    "there and back": _there_and_back,
}


# --- the real walk, turned


def warped_turns(first: int = 30, last: int = 70, pan_deg: float = 6.0) -> Array:
    """(N, 3, 3) how that camera is turned against the one that took the film."""
    n = np.arange(first, last + 1)
    shake = [0.3 * np.sin(1.7 * n), 0.3 * np.sin(1.1 * n), 0.4 * np.sin(0.9 * n)]
    pan = pan_deg * ((n - first) / (last - first) - 0.5)
    return exp_rotation(np.radians(np.stack([shake[0], pan + shake[1], shake[2]], -1)))


def _warped_walk(first: int = 30, last: int = 70, pan_deg: float = 6.0) -> CameraFilm:
    """The film of someone who walks as a camera had taken it that pans and shakes by 0.3°."""
    here, Rs = clip("walk"), warped_turns(first, last, pan_deg)
    video, beside = _places("warped walk", Rs.tobytes())
    if not (video.is_file() and beside.is_file()):
        _write(_warped(Rs, first), video, beside)
    Ts = transform(Rs @ Rs[0].T, np.zeros((len(Rs), 3)))
    path = CameraPath(Ts, np.ones(len(Rs)))
    return CameraFilm("warped walk", video, here.camera, path, np.load(beside, mmap_mode="r"))


def _warped(Rs: Array, first: int) -> Iterator[tuple[NDArray[np.uint8], NDArray[np.bool_]]]:
    """Frames, and where the woman or nothing is."""
    here, size = clip("walk"), (WIDTH, HEIGHT)
    K = here.camera.K
    marked = json.loads((here.video.parent / "marked_joints.json").read_text())["frames"]
    frames = sorted(int(f) for f in marked)
    middles = np.array([np.mean(list(marked[str(f)].values()), axis=0) for f in frames])
    with Video.open(here.video) as video:
        for i, R in enumerate(Rs):
            H = K @ R @ np.linalg.inv(K)
            u, v = (np.interp(first + i, frames, middles[:, k]) for k in range(2))
            seen = np.zeros((HEIGHT, WIDTH), np.uint8)
            seen[3:-3, 3:-3] = 1
            low, high = (int(u) - 90, int(v) - 150), (int(u) + 90, int(v) + 150)
            cv2.rectangle(seen, low, high, 0, -1)
            picture = cv2.warpPerspective(video.frame(first + i), H, size)
            yield np.asarray(picture), cv2.warpPerspective(seen, H, size) == 0


WARPED: dict[str, Callable[[], CameraFilm]] = {"warped walk": _warped_walk}
FILMS = (*WARPED, *PLANS)


def feet(film: CameraFilm) -> Array:
    """(N, 2, 3) of the feet's joints in the camera's frame, metres, as tracking would find them."""
    assert film.motion is not None
    assert film.skeleton is not None
    Ts = film.motion.transforms(film.skeleton)
    return Ts[:, [film.skeleton.body.index(foot) for foot in FEET]][..., :3, 3]


def feet_stray_mm(film: CameraFilm, path: CameraPath) -> float:
    """How far the standing feet stray from their mean in the world by a path, at most."""
    world = np.stack(
        [apply_transform(T, p) for T, p in zip(path.Ts_world_camera, feet(film), strict=True)]
    )
    return 1000 * float(np.linalg.norm(world - world.mean(axis=0), axis=-1).max())
