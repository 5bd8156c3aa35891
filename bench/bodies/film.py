"""Rendered films of several bodies whose motion is known exactly, and sessions of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.keeping import ROOT, digest, place_for
from bench.keyed import jittered
from bench.sequences import FPS, video_of
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.operations.track import track_session
from keypose.tracker.session import Keyframe, Session, VideoReference
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.storage.fingerprints import segment_keys
from keypose.tracker.storage.results import Results
from keypose.tracker.tracking.pool import TrackFinished
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video
from keypose.tracker.video.still_camera import still_camera
from tests.rendering.render import Stage, add_body
from tests.rendering.scenes import camera
from tests.rendering.settings import RenderSettings

Keyposes = Mapping[str, Mapping[int, Pose]]
"""Poses by the id of their body and by frame."""
SEEDS: Final = (1, 2, 3)
"""Of keyframes that are disturbed as by a hand."""


@dataclass(frozen=True, eq=False)
class Actor:
    """A body and its true motion.

    seed: of the texture that it wears.
    """

    id: str
    body: Body
    truth: Trajectory
    seed: int

    @cached_property
    def skeleton(self) -> Skeleton:
        return Skeleton.of(self.body)

    @cached_property
    def joints(self) -> Array:
        """(N, J, 3) true joints and landmarks, metres."""
        return self.truth.joints(self.skeleton)

    def stage(self, lens: Camera) -> Stage:
        """What the renderer draws: every seed has a texture and colours of its own."""
        stage = Stage.of(self.skeleton, lens, RenderSettings(seed=self.seed))
        return replace(stage, colours=np.roll(stage.colours, self.seed, axis=1))

    def poses(self, frames: Sequence[int]) -> dict[int, Pose]:
        """The true poses at these frames."""
        return {frame: self.truth.pose(frame) for frame in frames}


@dataclass(frozen=True, eq=False)
class Film:
    """Grey pictures (N, H, W) of bodies before a camera that stands still."""

    name: str
    actors: tuple[Actor, ...]
    camera: Camera
    grey: NDArray[np.uint8]

    @cached_property
    def video(self) -> Video:
        return video_of(len(self.grey), self._picture)

    def _picture(self, frame: int) -> NDArray[np.uint8]:
        return np.asarray(cv2.cvtColor(np.array(self.grey[frame]), cv2.COLOR_GRAY2RGB), np.uint8)

    @cached_property
    def stands_still(self) -> bool:
        """Whether the program finds that the camera does, and so takes a plate."""
        return still_camera(self.video).still

    def keyposes(self, frames: Sequence[int]) -> dict[str, dict[int, Pose]]:
        """The true poses of all bodies at these frames."""
        return {actor.id: actor.poses(frames) for actor in self.actors}

    def session(self, keyposes: Keyposes) -> Session:
        """A session of the bodies that are posed, begun as the program begins one."""
        count, height, width = self.grey.shape
        film = VideoReference(
            path=self.name,
            fingerprint="",
            frame_count=count,
            width=width,
            height=height,
            stands_still=self.stands_still,
        )
        first, *others = (
            TrackedBody(
                id=actor.id,
                body=actor.body,
                keyframes=tuple(
                    Keyframe.of(actor.skeleton, pose, frame, frame / FPS)
                    for frame, pose in sorted(keyposes[actor.id].items())
                ),
            )
            for actor in self.actors
            if actor.id in keyposes
        )
        session = Session.begin(video=film, camera=self.camera, body=first.body)
        return session.model_copy(update={"bodies": (first, *others)})


def rendered_film(name: str, actors: Sequence[Actor]) -> Film:
    """The film of these bodies, whichever is nearer before the others; rendered if it is not kept
    yet."""
    lens = camera()
    truths = [
        content
        for actor in actors
        for content in (
            actor.truth.Rs_parent_part.tobytes(),
            actor.truth.ps_camera_root.tobytes(),
            f"{actor.body!r} {actor.seed}".encode(),
        )
    ]
    key = digest(ROOT / "tests" / "rendering", ROOT / "bench" / "bodies" / "film.py", *truths)
    place = place_for(f"bodies-{name}", key, ".npy")
    if not place.is_file():
        unfinished = place.with_suffix(".part.npy")
        np.save(unfinished, np.stack(list(_pictures(actors, lens))))
        unfinished.replace(place)
    return Film(name, tuple(actors), lens, np.load(place, mmap_mode="r"))


def _pictures(actors: Sequence[Actor], lens: Camera) -> Iterator[NDArray[np.uint8]]:
    stages = [actor.stage(lens) for actor in actors]
    settings = RenderSettings()
    wall = Stage.of(actors[0].skeleton, lens, settings).wall[:, : lens.width]
    rng = np.random.default_rng(settings.seed)
    for frame in range(len(actors[0].truth)):
        picture = wall.copy()
        poses = [actor.truth.pose(frame) for actor in actors]
        for index in sorted(range(len(actors)), key=lambda k: -poses[k].p_camera_root[2]):
            add_body(picture, stages[index], pose_transforms(actors[index].skeleton, poses[index]))
        picture += settings.noise * rng.standard_normal(picture.shape, dtype=np.float32)
        rgb = np.clip(np.rint(picture), 0, 255).astype(np.uint8)
        yield np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY))


def disturbed(film: Film, keyposes: Keyposes, seed: int | None) -> Keyposes:
    """Keyposes as a hand would set them; themselves without a seed."""
    if seed is None:
        return keyposes
    skeletons = {actor.id: actor.skeleton for actor in film.actors}
    return {name: jittered(skeletons[name], poses, seed) for name, poses in keyposes.items()}


def hidden_shares(own: Actor, nearer: Actor, lens: Camera) -> Array:
    """(N,) the share of what a camera would see of one body that another one hides."""
    view = ViewCamera.of(lens)
    meshes = [BodyMesh.of(actor.skeleton) for actor in (own, nearer)]
    shares = []
    for frame in range(len(own.truth)):
        depth, depth_before = (
            raster(mesh, pose_transforms(actor.skeleton, actor.truth.pose(frame)), view).depth
            for mesh, actor in zip(meshes, (own, nearer), strict=True)
        )
        is_own = np.isfinite(depth)
        shares.append(float((depth_before[is_own] < depth[is_own]).mean()))
    return np.array(shares)


def tracked(session: Session, video: Video) -> list[SegmentResult]:
    """The segments of the body that is posed, as the program tracks them."""
    for event in track_session(session, video):
        if isinstance(event, TrackFinished):
            return list(event.result.segments)
    raise AssertionError("tracking ended without saying so")


def all_tracked(session: Session, video: Video) -> Results:
    """The segments of every body of a session."""
    results = Results()
    for body in session.bodies:
        about = session.about(body.id)
        keys = segment_keys(about)
        for segment in tracked(about, video):
            results = results.with_result(replace(segment, key=keys[segment.span]))
    return results
