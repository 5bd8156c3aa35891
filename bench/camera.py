"""How well a moving camera's path is found from its film, beside OpenCV's own pieces.

`python -m bench.camera FILM METHOD [unmasked]` measures one in a process of its own: one core, the
time without decoding, the peak of its memory.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from bench import camera_opencv, camera_tracked
from bench.camera_films import FILMS, CameraFilm, camera_film, feet, feet_stray_mm
from bench.children import peak_bytes
from bench.keeping import ROOT, Absent
from bench.table import Expected, Report, Table
from keypose.tracker.camera_motion.find import find_camera_motion, find_moved_path
from keypose.tracker.camera_motion.metric import StandingPoint, scale_from_stances
from keypose.tracker.camera_motion.points import Background
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, log_rotation, transpose

Grey = NDArray[np.uint8]
Method = Callable[[Iterator[Grey], Camera, camera_opencv.Masks], CameraPath]

MOST_TURN_DEG = 0.3
MOST_ZOOM = 0.5
MOST_WAY = 1.0
MOST_MS = 6.0
MOST_STRAY_MM = 8.0
ACROSS_M = 0.01
ALONG_M = 0.03


@dataclass(frozen=True)
class Figures:
    """Errors of a path: degrees, percent of the focal length and of the way; ms and MB it took.

    way: with the scale that fits best; NaN where the camera stays where it is.
    """

    turn_end: float
    turn_max: float
    turn_median: float
    zoom: float
    way: float
    way_median: float
    ms: float
    mb: float


def _moving(pictures: Iterator[Grey], camera: Camera, masks: camera_opencv.Masks) -> CameraPath:
    return find_moved_path(pictures, camera, 0, _background(masks)).path


def _turning(pictures: Iterator[Grey], camera: Camera, masks: camera_opencv.Masks) -> CameraPath:
    found = find_camera_motion(pictures, camera, 0, _background(masks), fixed="turns")
    assert found.path is not None
    return found.path


def _background(masks: camera_opencv.Masks) -> Background:
    """The background, of masks of what is before it."""

    def background(frame: int) -> NDArray[np.bool_] | None:
        hidden = masks(frame)
        return None if hidden is None else ~hidden

    return background


METHODS: dict[str, Method] = {
    "turning": _turning,
    "moving": _moving,
    "OpenCV turning": camera_opencv.turning,
    "OpenCV moving": camera_opencv.moving,
}
TURNED = ("warped walk", "pan and zoom", "pan and zoom, blurred")
"""Films whose camera stays in one place."""


def camera(report: Report) -> None:
    """The whole group."""
    report.note("turn: degrees off the truth; zoom, way: most that focal length and place are off,")
    report.note("percent of the truth and of the way, scale by best fit; one core, no decoding;")
    report.note("feet: standing ones stray from their mean, their true motion by the path found,")
    report.note("the scale by them; shaken: seen 1 cm off across and 3 cm along the line of sight")
    columns = ("turn end", "turn max", "turn median", "zoom %", "way %", "way median", "ms", "MB")
    for name in FILMS:
        try:
            film = camera_film(name)
        except Absent as absent:
            report.note(f"left out: {absent} is not here")
            continue
        _film(report.table(name, *columns), film)
    columns = ("scale % off", "± %", "feet mm", "shaken %", "± %, shaken", "feet mm, shaken")
    table = report.table("scale by standing feet", *columns)
    for name in FILMS:
        if name not in TURNED:
            _scale(table, camera_film(name))
    columns = ("tracked mm", "solved mm", "on the floor mm", "tracked px", "on the floor px")
    camera_tracked.standing(report.table("feet of a body that is tracked", *columns))
    try:
        columns = ("still", "panned", "steady")
        camera_tracked.marks(report.table("the walk at its marks, px", *columns, wide=columns))
    except Absent as absent:
        report.note(f"left out: {absent} is not here")


def _film(table: Table, film: CameraFilm) -> None:
    """All methods for its kind of camera."""
    kind = "turning" if film.name in TURNED else "moving"
    for method in (kind, f"OpenCV {kind}"):
        for masked in (True, False):
            found = in_a_child(film.name, method, masked)
            expected = _expected(found, kind) if method == kind and masked else []
            name = method if masked else f"{method}, no masks"
            table.row(name, *asdict(found).values(), expected=expected)


def _scale(table: Table, film: CameraFilm) -> None:
    """The scale by feet whose motion is true, and by such as are tracked."""
    found = find_moved_path(film.grey(), film.camera, len(film), lambda frame: ~film.mask(frame))
    p, p_true = (path.Ts_world_camera[:, :3, 3] for path in (found.path, film.path))
    true = float((p * p_true).sum() / (p * p).sum())
    figures = []
    for seen in (feet(film), _shaken(feet(film))):
        standing = [StandingPoint(0, seen[:, k]) for k in range(seen.shape[1])]
        scale = scale_from_stances(found.path, standing)
        if scale is None:
            figures += [float("nan")] * 3
            continue
        stray = feet_stray_mm(film, found.in_metres(scale.metres))
        off = 100 * abs(scale.metres / true - 1)
        figures += [off, 100 * scale.sd / scale.metres, stray]
    table.row(film.name, *figures, expected=[Expected("feet", figures[2], MOST_STRAY_MM, "mm")])


def _shaken(p: Array) -> Array:
    """Places (N, K, 3) as far off as tracked ones are, from frame to frame alike."""
    noise = gaussian_filter1d(np.random.default_rng(2).standard_normal(p.shape), 8, axis=0)
    noise *= ACROSS_M / noise.std()
    ray = p / np.linalg.norm(p, axis=-1, keepdims=True)
    return p + noise + (ALONG_M / ACROSS_M - 1) * ray * (noise * ray).sum(axis=-1, keepdims=True)


def _expected(found: Figures, kind: str) -> list[Expected]:
    own = Expected("zoom", found.zoom, MOST_ZOOM, "%")
    if kind == "moving":
        own = Expected("way", found.way, MOST_WAY, "%")
    turn = Expected("turn", found.turn_max, MOST_TURN_DEG, "°")
    return [turn, own, Expected("time", found.ms, MOST_MS, "ms")]


def in_a_child(film: str, method: str, masked: bool) -> Figures:
    """One measurement in a process of its own; the film is made before."""
    camera_film(film)
    command = [
        sys.executable,
        "-m",
        "bench.camera",
        film,
        method,
        *([] if masked else ["unmasked"]),
    ]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    return Figures(**json.loads(done.stdout.splitlines()[-1]))


class Timed:
    """Pictures, and how long they and their masks took to come."""

    def __init__(self, film: CameraFilm, masked: bool) -> None:
        self.film, self.masked, self.seconds = film, masked, 0.0

    def pictures(self) -> Iterator[Grey]:
        source, began = self.film.grey(), time.thread_time()
        for picture in source:
            self.seconds += time.thread_time() - began
            yield picture
            began = time.thread_time()

    def hidden(self, frame: int) -> NDArray[np.bool_] | None:
        """What is before the background; None without masks."""
        began = time.thread_time()
        mask = self.film.mask(frame) if self.masked else None
        self.seconds += time.thread_time() - began
        return mask


def measured(film: CameraFilm, method: Method, masked: bool) -> Figures:
    """One method on one film, in this process."""
    cv2.setNumThreads(1)
    timed, began = Timed(film, masked), time.thread_time()
    path = method(timed.pictures(), film.camera, timed.hidden)
    seconds = time.thread_time() - began - timed.seconds
    turn, zoom, way = errors(path, film.path)
    return Figures(
        float(turn[-1]),
        float(turn.max()),
        float(np.median(turn)),
        float(zoom.max()),
        float(way.max()),
        float(np.median(way)),
        1000 * seconds / len(film),
        peak_bytes() / 1e6,
    )


def errors(path: CameraPath, true: CameraPath) -> tuple[Array, Array, Array]:
    """Of every frame (N,): degrees; percent of the focal length; percent of the way, by the scale
    that fits best."""
    R = path.Ts_camera_world[:, :3, :3] @ transpose(true.Ts_camera_world[:, :3, :3])
    turn = np.degrees(np.linalg.norm(log_rotation(R), axis=-1))
    zoom = 100 * np.abs(path.zoom / true.zoom - 1)
    p, p_true = (one.Ts_world_camera[:, :3, 3] for one in (path, true))
    whole = float(np.linalg.norm(np.diff(p_true, axis=0), axis=-1).sum())
    if not true.moves:
        return turn, zoom, np.full(len(turn), np.nan)
    scale = (p * p_true).sum() / max((p * p).sum(), 1e-300)
    return turn, zoom, 100 * np.linalg.norm(scale * p - p_true, axis=-1) / whole


if __name__ == "__main__":
    figures = measured(camera_film(sys.argv[1]), METHODS[sys.argv[2]], "unmasked" not in sys.argv)
    print(json.dumps(asdict(figures)))
