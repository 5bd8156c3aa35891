"""A film made ready to be tracked: its pictures at every working size, and its scenes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.surface_points import SurfacePoints
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.solver.placed import lens_of
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.windows import MARGIN, body_windows, window_around
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import ClipLoader, Memory, WorkingSize
from keypose.tracker.video.pyramid import Clip


class PreparedFilm:
    """One film, its camera, and what is left out of its pictures; safe to use from threads."""

    def __init__(
        self,
        video: Video,
        camera: Camera,
        masks: Sequence[IgnoreMask],
        static: bool,
        memory: Memory,
        steady: SteadyCamera | None,
        turns: Array | None,
    ) -> None:
        """static, turns: see `Tracker`, as for the others."""
        self._loading = (masks, static, memory, steady, turns)
        self._video, self._memory = video, memory
        self.camera = camera
        self._loaders: dict[WorkingSize, ClipLoader] = {}

    @property
    def frame_count(self) -> int:
        """The number of frames of the video."""
        return self._video.info.frame_count

    @property
    def shows_background(self) -> bool:
        """Whether pictures are compared with one of the empty scene."""
        return self._loading[1] or self._loading[4] is not None

    def loader(self, longest: int) -> ClipLoader:
        """The loader for segments of up to this many frames."""
        size = WorkingSize.for_camera(self.camera, longest, self._memory)
        if size not in self._loaders:
            self._loaders[size] = ClipLoader(self._video, self.camera, size, *self._loading)
        return self._loaders[size]

    def pictures(self, skeleton: Skeleton, motion: Trajectory) -> Clip:
        """The pictures of the frames of a motion, around the body as it is posed there: elsewhere
        they are prepared once a motion leads there."""
        loader = self.loader(len(motion))
        lens = lens_of(loader.size.camera(loader.camera))
        windows = body_windows(skeleton, lens, *motion.writable())
        return loader.load(
            motion.first_frame,
            motion.last_frame,
            window_around(windows),
            window_around(windows, MARGIN),
        )

    def scene(
        self,
        skeleton: Skeleton,
        poses: Sequence[Pose],
        longest: int,
        density: float,
        sample: Callable[[Skeleton, float], SurfacePoints],
    ) -> Scene:
        """The scene of up to so many frames in which the body is about as in these poses."""
        loader = self.loader(longest)
        return Scene.of(skeleton, loader.size.camera(loader.camera), poses, density, sample)

    def before_plate(self, scene: Scene, clip: Clip, motion: Trajectory) -> Scene:
        """The scene with parts that stood, at both ends of a motion, where the empty scene was
        taken; itself where that is not known."""
        if not self.shows_background:
            return scene
        shown, ends = clip.shown, (motion.first_frame, motion.last_frame)
        pictures = [shown.levels[0][frame - clip.first_frame] for frame in ends]
        poses = [motion.pose(frame) for frame in ends]
        return scene.before_plate(
            list(zip(pictures, poses, strict=True)), shown.seen_by(scene.lens)
        )
