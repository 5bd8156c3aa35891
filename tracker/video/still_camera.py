"""Tell whether the camera stands still, and the background behind it: every pixel's median.

Two looks must agree, each by cells of the picture, since people and leaves move before a camera
that stands still and only some cells are theirs. Corners are followed from the first frame to the
sampled ones and back (Lucas and Kanade); and what differs from the background, every pixel's
median over the samples, is asked for the shift of the whole cell that would explain it. The second
look also works on soft gradients, where a pan leaves no corner to follow. Where the film fades, the
sampled frames are made as bright as most of it, and those that show nothing are passed over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.video.video import Video

Grey: TypeAlias = NDArray[np.float32]

DIFFERENCE = 8.0
"""Grey levels by which a pixel must differ from the background to count as moving."""
SMOOTHING_PX = 1.2


def smooth(grey: NDArray[np.uint8] | Grey) -> Grey:
    """A grey picture freed of most of its noise."""
    blurred = cv2.GaussianBlur(grey.astype(np.float32), (0, 0), SMOOTHING_PX)
    return np.asarray(blurred, dtype=np.float32)


def background(pictures: Sequence[NDArray[Any]]) -> Grey:
    """Every pixel's median over grey pictures (H, W)."""
    return np.asarray(np.median(np.stack(pictures), axis=0), dtype=np.float32)


def moving(picture: Grey, plate: Grey) -> NDArray[np.bool_]:
    """Pixels (H, W) of a smoothed picture that do not look as the empty scene does."""
    return np.asarray(np.abs(picture - plate) >= DIFFERENCE)


SAMPLES = 9
"""Frames that are looked at, however long the film is."""
FEWEST_SAMPLES = 3
"""With fewer a background is no median."""
LOOK_PIXELS = 640 * 960
"""Larger pictures are looked at in half, as they are tracked."""
STILL_PX = 0.35
"""A cell stands still where the median of its corners, or its whole, has moved less."""
GRID = 5
"""Cells along each side of the picture."""
FEWEST_IN_CELL = 4
FEWEST_CELLS = 6
SHARE = 0.7
"""Corners that make a cell speak; cells that must speak, and their share that must stand still."""
CORNERS = 500
CORNER_QUALITY = 0.005
RETURN_PX = 0.5
"""A corner counts where it is followed back to within this of where it began."""
MOST_MOVING = 0.5
"""Share of the picture that may move before a camera that stands still."""
SHIFT_SIGMA_PX = 0.05
"""A cell has a known shift where noise would leave it no less certain than this."""
NOISE_GREY = 1.0
"""What the smoothed pictures of a still scene differ by, grey levels, compression included."""
BLANK_GREY = 1.0
BLANK_SHARE = 0.5
"""A cell shows nothing where grey levels have a smaller standard deviation, and a frame is blank,
or a title card, with no more than this of the cells that show something in the fullest one."""
FADED = 0.6
AS_LIKE = 0.9
LITTLE = (32, 18)
"""A frame has faded where it has less of the contrast of the one that has most, and correlates with
the usual one, both made so small, nearly as the others do: what pans to the sky does not. What
compression leaves of such a frame lies a pixel or two aside."""
LEAST_GAIN = 0.1
"""A smaller change of contrast is no fade."""
FITTED_EVERY = 11
FIT_ROUNDS = 5
"""Pixels that the brightness of a faded frame is fitted by, and rounds without those that move."""
AROUND_PX = 5
"""Room around moving pixels in which a corner's window would hold them."""

WINDOW_PX = (15, 15)
HALVED = 1
"""Coarser levels are left out: how far a corner has gone that went far need not be known."""


@dataclass(frozen=True)
class StillCamera:
    """Whether a camera stands still, and what was seen; pixels of the picture looked at.

    still: every sampled frame has enough cells, and enough of them stand still, by both looks.
    share: of the cells that stand still, at the worst frame.  cells: that spoke, at the poorest.
    largest_median_px: the largest of the frames' medians over cells; infinite where nothing spoke.
    moving: the largest share of pixels that differ from the background.  samples: frames read that
    show something.
    """

    still: bool
    share: float
    cells: int
    largest_median_px: float
    moving: float
    samples: int


def still_camera(video: Video) -> StillCamera:
    """Whether the camera of a film stands still. Equal for equal frames.

    A film of fewer than three readable frames is never called still.
    """
    return still_pictures(_sampled(video))


def still_pictures(pictures: list[NDArray[np.uint8]]) -> StillCamera:
    """The same of grey pictures (H, W), the sampled frames in order."""
    pictures = _evenly_bright(pictures)
    if len(pictures) < FEWEST_SAMPLES:
        return StillCamera(False, 0.0, 0, np.inf, 1.0, len(pictures))
    smoothed = [smooth(picture) for picture in pictures]
    plate = background(smoothed)
    away = [moving(picture, plate) for picture in smoothed]
    by_corners = _corner_shifts(pictures, away)
    by_residual = [_residual_shifts(s, plate, a) for s, a in zip(smoothed, away, strict=True)]
    looks = [*by_corners, *by_residual]
    cells = min(len(shifts) for shifts in looks)
    share = min(float((shifts < STILL_PX).mean()) if len(shifts) else 0.0 for shifts in looks)
    median = max(float(np.median(shifts)) if len(shifts) else np.inf for shifts in looks)
    most = max(float(a.mean()) for a in away)
    still = cells >= FEWEST_CELLS and share >= SHARE and most <= MOST_MOVING
    return StillCamera(still, share, cells, median, most, len(pictures))


def _evenly_bright(pictures: list[NDArray[np.uint8]]) -> list[NDArray[np.uint8]]:
    """The pictures that show something, freed of fades."""
    fullness = [_fullness(picture) for picture in pictures]
    fullest = max(fullness, default=0)
    shown = [p for p, full in zip(pictures, fullness, strict=True) if full > BLANK_SHARE * fullest]
    if not shown:
        return []
    by_contrast = sorted(shown, key=lambda picture: float(picture.std()))
    least = FADED * float(by_contrast[-1].std())
    lasting = [picture for picture in by_contrast if picture.std() >= least]
    usual = lasting[len(lasting) // 2]
    alike = AS_LIKE * min(_likeness(usual, picture) for picture in lasting)
    kept = [p for p in shown if p.std() >= least or _likeness(usual, p) < alike]
    return [_as_bright_as(usual, picture) for picture in kept]


def _fullness(picture: NDArray[np.uint8]) -> int:
    """In how many cells a picture shows something."""
    rows = np.array_split(picture, GRID)
    return sum(c.std() >= BLANK_GREY for row in rows for c in np.array_split(row, GRID, axis=1))


def _likeness(picture: NDArray[np.uint8], reference: NDArray[np.uint8]) -> float:
    """The correlation of two pictures made so small that compression has left it."""
    first, second = (
        np.asarray(cv2.resize(p, LITTLE, interpolation=cv2.INTER_AREA), float)
        for p in (picture, reference)
    )
    spread = first.std() * second.std()
    if spread == 0:
        return 0.0
    return float(((first - first.mean()) * (second - second.mean())).mean() / spread)


def _as_bright_as(usual: NDArray[np.uint8], picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A picture with the brightness of another that shows the same scene faded."""
    x, y = (p.ravel()[::FITTED_EVERY].astype(float) for p in (picture, usual))
    gain = y.std() / x.std()
    offset = float(np.median(y - gain * x))
    for _ in range(FIT_ROUNDS):
        off = np.abs(y - gain * x - offset)
        alike = off <= max(DIFFERENCE, float(np.median(off)))
        if x[alike].std() == 0:
            return picture
        gain, offset = np.polyfit(x[alike], y[alike], 1)
    if abs(gain - 1) <= LEAST_GAIN or gain <= 0:
        return picture
    levels = np.clip(np.rint(np.arange(256) * gain + offset), 0, 255)
    return np.asarray(cv2.LUT(picture, levels.astype(np.uint8)), np.uint8)


def sampled_frames(count: int) -> list[int]:
    """Numbers of the frames that are looked at: the ends, and between them at uneven distances,
    so that a shake that keeps time with them is not mistaken for standing still."""
    golden = (np.sqrt(5) - 1) / 2
    inner = np.arange(1, SAMPLES - 1)
    places = (inner + 0.6 * ((inner * golden) % 1.0 - 0.5)) / (SAMPLES - 1)
    return sorted({0, count - 1, *np.rint(places * (count - 1)).astype(int).tolist()})


def _sampled(video: Video) -> list[NDArray[np.uint8]]:
    """The sampled frames that can be read, grey, at the size they are looked at."""
    pictures = []
    for frame in sampled_frames(video.info.frame_count):
        if frame >= video.info.frame_count:  # reading may show that there are fewer
            break
        for _, rgb in video.frames(frame, frame + 1):
            if rgb is not None:
                pictures.append(_small(np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY))))
    return pictures


def _small(grey: NDArray[np.uint8]) -> NDArray[np.uint8]:
    while grey.size > LOOK_PIXELS:
        grey = np.asarray(cv2.pyrDown(grey), dtype=np.uint8)
    return grey


def _corner_shifts(pictures: list[NDArray[np.uint8]], away: list[NDArray[np.bool_]]) -> list[Array]:
    """For every picture but the first the median way of the corners of each cell, pixels.

    Corners at pixels that move in either picture do not count.
    """
    first, (height, width) = pictures[0], pictures[0].shape
    apart = max(5, width // 80)
    corners = cv2.goodFeaturesToTrack(
        first, CORNERS, CORNER_QUALITY, apart, mask=_standing(away[0])
    )
    if corners is None:
        return [np.zeros(0) for _ in pictures[1:]]
    start = np.asarray(corners, np.float32)
    cell = _cell_of(start[:, 0], width, height)
    shifts = []
    for picture, away_now in zip(pictures[1:], away[1:], strict=True):
        reached, returned = _followed(first, picture, start)
        column, row = np.rint(start[:, 0].T).astype(int)
        counts = returned & (_standing(away_now)[row, column] > 0)
        lengths = np.linalg.norm(reached - start[:, 0], axis=1)
        shifts.append(_medians(lengths[counts], cell[counts]))
    return shifts


def _standing(away: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """255 where nothing near moves."""
    kernel = np.ones((2 * AROUND_PX + 1,) * 2, np.uint8)
    return np.asarray(255 * (1 - cv2.dilate(away.astype(np.uint8), kernel)), dtype=np.uint8)


def _followed(
    first: NDArray[np.uint8], picture: NDArray[np.uint8], start: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Where corners (K, 1, 2) are in another picture (K, 2), and whether they are found
    back.
    """
    reached, forward = _follow(first, picture, start)
    back, backward = _follow(picture, first, reached)
    is_found = forward & backward
    return reached[:, 0], is_found & (np.linalg.norm((back - start)[:, 0], axis=1) < RETURN_PX)


def _follow(
    before: NDArray[np.uint8], after: NDArray[np.uint8], start: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    reached, status, _ = cv2.calcOpticalFlowPyrLK(
        before, after, start, start.copy(), winSize=WINDOW_PX, maxLevel=HALVED
    )
    return np.asarray(reached, np.float32), np.asarray(status)[:, 0] > 0


def _cell_of(uv: NDArray[np.float32], width: int, height: int) -> NDArray[np.int64]:
    columns, rows = np.clip((uv * GRID / (width, height)).astype(int), 0, GRID - 1).T
    return np.asarray(columns + GRID * rows)


def _medians(ways: NDArray[np.float32], cell: NDArray[np.int64]) -> Array:
    """The median of each cell that has enough corners."""
    inside = [ways[cell == c] for c in range(GRID**2)]
    return np.array([np.median(w) for w in inside if len(w) >= FEWEST_IN_CELL])


def _residual_shifts(picture: Grey, plate: Grey, away: NDArray[np.bool_]) -> Array:
    """How far each cell of the background would have to be shifted to look as the picture
    does.

    Linear least squares on the gradients of the background, outside moving pixels; cells whose
    gradients say too little in one direction are left out.
    """
    right, down = (cv2.Sobel(plate, cv2.CV_32F, *axis, scale=1 / 8) for axis in ((1, 0), (0, 1)))
    right[away] = down[away] = 0.0
    residual = plate - picture
    xx, xy, yy = (_by_cell(product) for product in (right * right, right * down, down * down))
    normal = np.stack([np.stack([xx, xy], -1), np.stack([xy, yy], -1)], -2)
    moment = np.stack([_by_cell(right * residual), _by_cell(down * residual)], -1)
    textured = np.linalg.eigvalsh(normal)[:, 0] > (NOISE_GREY / SHIFT_SIGMA_PX) ** 2
    shifts = np.linalg.solve(normal[textured], moment[textured][..., None])[..., 0]
    return np.asarray(np.linalg.norm(shifts, axis=-1))


def _by_cell(values: Grey) -> Array:
    """The sums (GRID²,) of values (H, W) over the cells."""
    means = cv2.resize(values, (GRID, GRID), interpolation=cv2.INTER_AREA)
    return np.asarray(means.ravel() * (values.size / GRID**2), dtype=float)
