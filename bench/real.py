"""Real people: pixels at the marked joints between keyframes that were posed on marks alone.

`keyed.py` says what keyframes are made of. Each figure is the median over keyframes disturbed
by 0.5° a joint and 3 mm at the root, with its smallest and largest value beside it; no difference
smaller than that spread is one. A stance, where a planted ankle must not shake, is given for each
clip in `clips.py`: frames over which the marks of that ankle move by less than a mark is good to.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

from bench.clips import Clip, clip
from bench.keeping import Absent
from bench.keyed import jittered, keyed
from bench.measures import Over, figures
from bench.table import Expected, Report, Table
from bench.tracking import Tracked, linear, track
from keypose.app.document.defaults import Defaults
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, joined
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.detect import Seed, detect
from keypose.tracker.keypoints.detectors import open_detector
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.model_files import Model, find_model
from keypose.tracker.keypoints.region import MARGIN, Region
from keypose.tracker.session.settings import Cue, TrackSettings
from keypose.tracker.tracking.cues.drafted import DraftedKeypoints
from keypose.tracker.tracking.cues.sources import (
    DetectedKeypoints,
    KeypointSource,
    SteadyKeypoints,
)
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video

JITTERS = 8


@dataclass(frozen=True, eq=False)
class Posed:
    """A clip between keyframes; its pictures are prepared once for all disturbances of these.

    steady: the camera in whose place it is tracked, where its own moves.
    """

    clip: Clip
    video: Video
    skeleton: Skeleton
    keyposes: Mapping[int, Pose]
    prepared: dict[bool, Tracker] = field(default_factory=dict)
    drafts: dict[str, Keypoints] = field(default_factory=dict)
    steady: SteadyCamera | None = None

    def tracker(
        self, static_camera: bool = False, network: Model | None = None, *, drafted: bool = False
    ) -> Tracker:
        """A tracker of these keyframes, with a picture of the empty scene or without, and with a
        network's keypoints or without; as it drafted them, or looked for from the keyframes."""
        if static_camera not in self.prepared:
            self.prepared[static_camera] = Tracker(
                self.video,
                self.clip.camera,
                self.skeleton,
                self.keyposes,
                static_camera=static_camera,
                steady=self.steady,
            )
        source: KeypointSource | None = None
        if network is not None:
            source = DetectedKeypoints(
                self.video,
                self.clip.camera,
                model=network,
                every_second=network.skips_frames_at(self.video.info.fps),
            )
        if source is not None and network is not None and drafted:
            source = DraftedKeypoints(self._drafted(network), source, self.clip.camera)
        if source is not None and self.steady is not None:
            source = SteadyKeypoints(source, self.steady)
        plain = self.prepared[static_camera]
        return plain.renewed(self.skeleton, self.keyposes, keypoints=source)

    def _drafted(self, network: Model) -> Keypoints:
        """What a draft of the frames about the keyframes sees, from a box at the first of these;
        once for all disturbances."""
        if network.name not in self.drafts:
            at, last, camera = min(self.keyposes), max(self.keyposes), self.clip.camera
            around = Region.of_pose(self.skeleton, self.keyposes[at], camera)
            r = around.side / (2 * MARGIN)
            box = around.x - r, around.y - r, around.x + r, around.y + r
            seed = Seed.of_box(at, box, camera.width, camera.height)
            self.drafts[network.name] = detect(
                self.video.frame,
                (at, last),
                [seed],
                open_detector(network),
                every_second=network.skips_frames_at(self.video.info.fps),
            )
        return self.drafts[network.name]

    def disturbed(self, seed: int) -> Posed:
        """The same, its keyframes disturbed."""
        return replace(self, keyposes=jittered(self.skeleton, self.keyposes, seed))


Way = Callable[[Posed], Tracked]
"""A way to get from keyframes to the motion between them."""


@dataclass(frozen=True)
class Row:
    """Keyframes on a clip. most: pixels that mean and median should not exceed."""

    name: str
    clip: str
    keyframes: tuple[int, ...]
    most: tuple[float, float] | None = None


ROWS = (
    Row("person-30", "person", (0, 30, 60, 90), (4.0, 3.2)),
    Row("person-60", "person", (0, 60), (4.5, 3.7)),
    Row("person-90", "person", (0, 90), (6.0, 5.0)),
    Row("walk-20", "walk", (30, 50, 70)),  # at double support
    Row("walk-20-mid", "walk", (40, 60), (4.5, 3.5)),  # at mid-stance
    Row("walk-40", "walk", (30, 70), (4.5, 3.5)),
    Row("arms-20", "arms", (20, 40, 60)),
    Row("arms-40", "arms", (20, 60)),
    Row("camera4-30", "camera4", (0, 30, 60, 90)),  # these two were never tuned on
    Row("camera4-60", "camera4", (0, 60)),
)
PRINTED = (
    "mean",
    "median",
    "p90",
    "worst",
    "over_10",
    "root_mm",
    "keys_mm",
    "depth_mm",
    "jitter_px",
)


def interpolated(posed: Posed) -> Tracked:
    """Nothing tracked, nothing found."""
    steps = [Pass("interpolation", trajectory, None) for trajectory in linear(posed.tracker())]
    return Tracked([SegmentResult.on_the_way(step) for step in steps])


def with_settings(settings: TrackSettings, *, drafted: bool = False) -> Way:
    """Tracked as settings say, with keypoints of a draft or looked for from the keyframes."""

    def way(posed: Posed) -> Tracked:
        network = find_model(settings.network_used)
        used = network if "keypoints" in settings.cues_used else None
        tracker = posed.tracker(bool(settings.static_camera), used, drafted=drafted)
        return track(tracker, **settings.model_dump())

    return way


BOTH: tuple[Cue, ...] = ("brightness", "keypoints")
NETWORK = Defaults().network
WAYS: dict[str, Way] = {
    "linear": interpolated,
    "brightness": with_settings(TrackSettings(cues=("brightness",))),
    "keypoints alone": with_settings(TrackSettings(cues=("keypoints",), network=NETWORK)),
    "by full alone": with_settings(TrackSettings(cues=BOTH, network="full")),
    "keypoints": with_settings(TrackSettings(cues=BOTH, network=NETWORK)),
    "of a draft": with_settings(TrackSettings(cues=BOTH, network=NETWORK), drafted=True),
}
SINGLE = ("linear", "brightness", "keypoints alone", "by full alone")
"""Of these nothing is expected: both cues together, by both networks, are to be no worse."""


def real(report: Report) -> None:
    """The whole group."""
    report.note("px at marked joints strictly between keyframes posed on their marks alone;")
    report.note(f"median (least–most) over {JITTERS} disturbances of 0.5° and 3 mm")
    table = report.table("by keyframes", "way", *PRINTED, wide=PRINTED)
    for row in ROWS:
        try:
            _measured(row, table)
        except Absent as absent:
            report.note(f"{row.name} left out: {absent} is not here")


def _measured(row: Row, table: Table) -> None:
    """One row of keyframes, every way and every disturbance."""
    shown = clip(row.clip)
    hand = keyed(shown, row.keyframes)
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in WAYS}
    with Video.open(shown.video) as video:
        posed = Posed(shown, video, hand.skeleton, hand.poses)
        for seed, (name, way) in product(range(JITTERS), WAYS.items()):
            motion = joined(way(posed.disturbed(seed)).trajectories)
            runs[name].append(figures(shown, hand.skeleton, motion, row.keyframes))
    for name, values in runs.items():
        over = {figure: Over(tuple(v[figure] for v in values)) for figure in values[0]}
        expected = []
        if row.most is not None and name not in SINGLE:
            both = zip(("mean", "median"), row.most, strict=True)
            expected = [Expected(what, over[what].median, most, "px") for what, most in both]
        table.row(row.name, name, *(over.get(f, "–") for f in PRINTED), expected=expected)
