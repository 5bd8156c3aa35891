"""Clips as a person sees them: where joints are in the picture, and roughly how limbs lie in depth.

Of a rendered clip that is known at every frame. A real one is marked by hand on some; between these
the marks are carried on: along the rough joints that four cameras saw, shifted so that they meet
the marks, or, where marks are five frames apart, by cubic splines. Marks that are left out, one
frame at a time, are found again so to 3.5 and 6.4 px in the median, from marks twice as far apart
as those that are used. Depth of a real clip is the reading of
its marks in `keyed.py`, which uses no other view.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from bench.clips import Clip, place
from bench.clips import clip as real_clip
from bench.keeping import ROOT, Absent, digest, kept_folder
from bench.keyed import keyed
from keypose.app.document.defaults import Defaults
from keypose.sample_videos.make_samples import encode
from keypose.sample_videos.posing import MARKS
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import interpolate, joined
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session import Session, VideoReference
from keypose.tracker.solver.posed import BodyPoint
from keypose.tracker.storage.files import load_session
from keypose.tracker.video import Video
from keypose.tracker.video.still_camera import still_camera
from tests.rendering.scenes import Scene, scene
from tests.rendering.settings import RenderSettings

SIZE = (640, 360)
JOINTS = (
    "head_top",
    *(
        f"{side}_{part}"
        for side in ("left", "right")
        for part in (
            "upper_arm",
            "forearm",
            "hand",
            "thigh",
            "shin",
            "foot",
        )
    ),
)
"""What is seen of a rendered person: as much as is marked of real ones."""
CLIPS = ("balance", "walk", "person", "stride", "throw", "speech")
CARRIED_PX = 4.0
"""How far off marks are that were carried on: between what is told above for either way."""
STRETCHES = {
    "walk": (40, 70), "person": (0, 90), "stride": (24, 96), "throw": (47, 119), "speech": (0, 180),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Watched:
    """A clip before anything is done with it.

    session: without keyframes, its body sized and its lens known.  first, last: the stretch to be
    done.  seen: by frame and name, pixels (u, v) of the rectified picture.  poses: as a person
    understands these frames.  places: where on the body a name lies.  marked: frames marked by
    hand, or rendered; marks of others are carried on.  unmeasured: joints that are posed on and
    that nobody is sure of, such as hips under shorts.  true: as `seen`, without a person's error.
    p_true: by frame and name where joints were in space, metres, camera frame; none where that is
    not known.
    """

    name: str
    video: Path
    session: Session
    first: int
    last: int
    seen: Mapping[int, Mapping[str, tuple[float, float]]]
    poses: Mapping[int, Pose]
    places: Mapping[str, BodyPoint]
    marked: frozenset[int] = frozenset()
    unmeasured: frozenset[str] = frozenset()
    true: Mapping[int, Mapping[str, tuple[float, float]]] = field(default_factory=dict)
    p_true: Mapping[int, Mapping[str, Array]] = field(default_factory=dict)

    @property
    def frames(self) -> int:
        return self.last - self.first + 1

    def slack_px(self, frame: int) -> float:
        """How far off the marks of a frame are."""
        return 0.0 if frame in self.marked else CARRIED_PX

    def until(self, last: int) -> Watched:
        """The clip without what comes after a frame."""
        return replace(
            self,
            last=last,
            seen={f: at for f, at in self.seen.items() if f <= last},
            true={f: at for f, at in self.true.items() if f <= last},
        )

    def unsized(self) -> Watched:
        """The clip as it is opened: with the body of a preset."""
        body = preset("adult_female" if self.name == "walk" else "adult_male")
        places = {name: _on_preset(body, name) for name in self.places}
        session = self.session.changed({"body": body})
        return replace(self, session=session, places=places)

    @property
    def box(self) -> tuple[int, tuple[float, float, float, float]]:
        """A frame and the box that somebody draws there: the marks, and room for hands and hair."""
        frame = max(self.seen, key=lambda f: (len(self.seen[f]), -f))
        uv = np.array(list(self.seen[frame].values()))
        low, high = uv.min(axis=0), uv.max(axis=0)
        room = 0.08 * float(high[1] - low[1])
        width, height = self.session.view.video.width, self.session.view.video.height
        left, top = np.maximum(low - room, 0).tolist()
        right, bottom = np.minimum(high + room, (width - 1, height - 1)).tolist()
        return frame, (left, top, right, bottom)


@cache
def watched(name: str) -> Watched:
    """A clip of CLIPS; Absent when its material is not here."""
    if name == "balance":
        return _balance()
    if name in ("walk", "person"):
        return _real(name)
    return _rendered(name, STRETCHES[name])


def _balance() -> Watched:
    """The bundled clip: its own keyframes are how it is understood, and say where joints are."""
    folder = ROOT / "sample_videos" / "balance"
    session = load_session(folder / "session.json")
    skeleton = Skeleton.of(session.subject.body)
    poses = {keyframe.frame: keyframe.pose(skeleton) for keyframe in session.subject.keyframes}
    bare = session.changed({"keyframes": (), "drafts": (), "results": None})
    video = folder / "balance.mp4"
    known = of_poses("balance", video, _as_new(bare, video), poses)
    known = replace(known, unmeasured=frozenset({"left_thigh", "right_thigh", "head_top"}))
    with suppress(Absent):  # without the rough joints, at the marked frames alone
        return _carried(known, _rough(real_clip("person"), bare.view.camera))
    return known


def _real(name: str) -> Watched:
    """A clip marked by hand."""
    known = real_clip(name)
    frames = [f for f in sorted(known.marks) if STRETCHES[name][0] <= f <= STRETCHES[name][1]]
    hand = keyed(known, frames)
    with Video.open(known.video) as video:
        session = _session(video, known.camera, hand.skeleton.body)
    seen = {}
    for frame in frames:
        uv = _straight(known.camera, np.array(list(known.marks[frame].values())))
        named = zip(known.marks[frame], uv.tolist(), strict=True)
        seen[frame] = {MARKS.get(n, _landmark(n)): (u, v) for n, (u, v) in named}
    marks = {MARKS.get(n, _landmark(n)): n for joints in known.marks.values() for n in joints}
    places = {ours: place(hand.skeleton.body, theirs) for ours, theirs in marks.items()}
    first, last = frames[0], frames[-1]
    marked = Watched(name, known.video, session, first, last, seen, hand.poses, places)
    carried_on = _carried(marked, _rough(known, known.camera))
    return replace(carried_on, p_true=_in_space(known, range(first, last + 1)))


def _in_space(known: Clip, frames: range) -> dict[int, dict[str, Array]]:
    """Rough joints by frame and name, metres, camera frame."""
    if known.space is None:
        return {}
    names, joints = known.space
    return {f: {MARKS[n]: joints[f, i] for i, n in enumerate(names)} for f in frames}


# --- from marked frames to all


def _rough(known: Clip, camera: Camera) -> dict[str, Array]:
    """Rough joints by name, (F, 2) pixels of the rectified picture."""
    if known.space is None:
        return {}
    names, joints = known.space
    uv = camera.without_distortion().project(joints)
    return {MARKS[name]: uv[:, i] for i, name in enumerate(names)}


def _carried(marked: Watched, rough: Mapping[str, Array]) -> Watched:
    """Seen, and understood, at every frame between those that are marked."""
    frames = sorted(marked.seen)
    seen: dict[int, dict[str, tuple[float, float]]] = {
        frame: {} for frame in range(frames[0], frames[-1] + 1)
    }
    for name in marked.places:
        at = [f for f in frames if name in marked.seen[f]]
        uv = np.array([marked.seen[f][name] for f in at])
        for one, other in pairwise(at):
            if frames.index(other) - frames.index(one) == 1:
                for frame in range(one, other + 1):
                    seen[frame][name] = _pixel(carried(at, uv, frame, rough.get(name)))
    return replace(marked, seen=seen, poses=_between(marked.poses), marked=frozenset(frames))


def carried(at: Sequence[int], uv: Array, frame: int, rough: Array | None) -> Array:
    """(2,) where a joint is at a frame, by its marks (N, 2) at others and its rough way (F, 2)."""
    if rough is None:
        return np.asarray(CubicSpline(at, uv)(frame) if len(at) > 2 else _linear(at, uv, frame))
    return np.asarray(rough[frame] + _linear(at, uv - rough[list(at)], frame))


def _linear(at: Sequence[int], uv: Array, frame: int) -> Array:
    return np.array([np.interp(frame, at, column) for column in uv.T])


def _between(poses: Mapping[int, Pose]) -> dict[int, Pose]:
    """A pose for every frame."""
    spans = list(pairwise(sorted(poses)))
    motion = joined([interpolate(poses[a], poses[b], a, b) for a, b in spans])
    return {f: motion.pose(f) for f in range(spans[0][0], spans[-1][1] + 1)}


def _straight(camera: Camera, uv: Array) -> Array:
    """Pixels (J, 2) of the film in its rectified picture."""
    return camera.without_distortion().project(camera.back_project(uv, 1.0))


def _landmark(name: str) -> str:
    return {"Head": "head_top", "hip": "hips"}.get(name, name)


def _rendered(name: str, stretch: tuple[int, int]) -> Watched:
    try:
        quiet = RenderSettings(noise=0.5, background_contrast=9.0)
        shown = scene(name, quiet, SIZE).cut(*stretch)
    except FileNotFoundError:
        raise Absent(f"the recorded motion of {name!r}") from None
    video = _film(name, shown)
    with Video.open(video) as opened:
        session = _session(opened, shown.camera, sized(shown.skeleton.body))
    poses = {frame: shown.truth.pose(frame) for frame in range(len(shown.truth))}
    found, skeleton = of_poses(name, video, session, poses), shown.skeleton
    names = joint_names(skeleton)
    p_true = {}
    for frame, pose in poses.items():
        p = joint_positions(skeleton, pose_transforms(skeleton, pose))
        p_true[frame] = {n: p[names.index(n)] for n in JOINTS}
    return replace(found, p_true=p_true)


def _film(name: str, shown: Scene) -> Path:
    """The scene as a file, made once."""
    truth = shown.truth.Rs_parent_part.tobytes() + shown.truth.ps_camera_root.tobytes()
    key = digest(ROOT / "tests" / "rendering", truth, repr(shown.settings).encode())
    path = kept_folder() / f"film-{name}-{key}.mp4"
    if not path.is_file():
        unfinished = path.with_suffix(".part.mp4")
        encode(shown.frames(), unfinished, 12)
        unfinished.replace(path)
    return path


def sized(body: Body) -> Body:
    """The body as one that somebody has sized: a preset's sizes would be drafted anew, though they
    are those of the person."""
    return body.model_copy(update={"name": "sized"})


def of_poses(name: str, video: Path, session: Session, poses: Mapping[int, Pose]) -> Watched:
    """All joints are seen where the poses have them."""
    skeleton, camera = Skeleton.of(session.subject.body), session.view.camera.without_distortion()
    names, places = joint_names(skeleton), _places(session.subject.body)
    seen = {}
    for frame, pose in poses.items():
        uv = camera.project(joint_positions(skeleton, pose_transforms(skeleton, pose)))
        seen[frame] = {n: _pixel(uv[names.index(n)]) for n in JOINTS}
    first, last = min(poses), max(poses)
    return Watched(name, video, session, first, last, seen, poses, places, frozenset(seen))


def _places(body: Body) -> dict[str, BodyPoint]:
    head = body.index("head")
    found: dict[str, BodyPoint] = {n: ((body.index(n), (0.0, 0.0, 0.0)),) for n in JOINTS[1:]}
    return {"head_top": ((head, body.parts[head].landmarks["head_top"]),), **found}


def _on_preset(body: Body, name: str) -> BodyPoint:
    """Where on a preset's body a joint lies."""
    if name in body.names:
        return ((body.index(name), (0.0, 0.0, 0.0)),)
    return place(body, {"head_top": "Head", "hips": "hip"}[name])


def _pixel(uv: Array) -> tuple[float, float]:
    u, v = uv.tolist()
    return u, v


def _session(video: Video, camera: Camera, body: Body) -> Session:
    info = video.info
    reference = VideoReference(
        path=info.path.name,
        fingerprint=video.fingerprint(),
        frame_count=info.frame_count,
        width=info.width,
        height=info.height,
        stands_still=still_camera(video).still,
    )
    settings = Defaults().track_settings
    return Session.begin(video=reference, camera=camera, body=body, settings=settings)


def _as_new(session: Session, path: Path) -> Session:
    """A session that is there already with the settings of one that is begun."""
    with Video.open(path) as video:
        still = still_camera(video).still
    reference = session.view.video.model_copy(update={"stands_still": still})
    settings = Defaults().track_settings
    return session.changed({"video": reference, "settings": settings})


def noisy(clip: Watched, sigma_px: float, seed: int) -> Watched:
    """The same as one person sees it: every joint beside where it is, at each frame elsewhere.

    sigma_px: root mean square of the distance.
    """
    seen = {}
    for frame, joints in clip.seen.items():
        rng = np.random.default_rng([seed, frame])
        off = rng.normal(0.0, sigma_px / np.sqrt(2), (len(joints), 2)).tolist()
        both = zip(joints.items(), off, strict=True)
        seen[frame] = {name: (u + du, v + dv) for (name, (u, v)), (du, dv) in both}
    return replace(clip, seen=seen, true=clip.seen)
