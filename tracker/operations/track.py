"""Track a saved session with its keyframes, masks and settings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.operations.lifting import depth_lifter
from keypose.tracker.operations.occlusion import ignored_regions
from keypose.tracker.session.annotations import Direction
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence, surface_of
from keypose.tracker.session.references import KeypointFile
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.cache import Detections
from keypose.tracker.storage.covered_joints import covered_joints
from keypose.tracker.storage.evidence import surfaces_of
from keypose.tracker.storage.fingerprints import (
    background_turns,
    has_drafted_keypoints,
    lifts_depth,
    needs_masks,
    segment_keys,
    steady_camera,
    without_part_keyframes,
)
from keypose.tracker.surface.fit.fitter import SurfaceFitter
from keypose.tracker.surface.mesh import Steps
from keypose.tracker.surface.source import UnratedSteps
from keypose.tracker.tracking.ahead.follow import LONGEST, Emit, FoundAhead, follow_ahead
from keypose.tracker.tracking.cues.drafted import DraftedKeypoints
from keypose.tracker.tracking.cues.sources import (
    CorrectedKeypoints,
    DetectedKeypoints,
    GivenKeypoints,
    KeypointSource,
    LiftedKeypoints,
    SteadyKeypoints,
)
from keypose.tracker.tracking.film_beside import FilmBeside
from keypose.tracker.tracking.parts.limb_keyframes import KeyedParts
from keypose.tracker.tracking.pool import Progress, SegmentTracker, Task, never, run_chosen
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import AGAIN, ONCE, Memory


def keyed_parts(session: Session, skeleton: Skeleton) -> list[KeyedParts]:
    """What is exact at frames between keyframes."""
    telephoto = session.view.camera.projection == "telephoto"
    return [
        KeyedParts.of(skeleton, keyframe.frame, keyframe.parts, keyframe.pose(skeleton), telephoto)
        for keyframe in session.subject.part_keyframes
    ]


def tracker_of(
    session: Session,
    video: Video,
    memory: Memory = AGAIN,
    first_motion: Trajectory | None = None,
    like: Tracker | None = None,
    keypoints: Keypoints | None = None,
    fewest: int = 2,
    films: Sequence[FilmBeside] = (),
) -> Tracker:
    """A session's tracker; SessionError with fewer keyframes than the fewest, or without the first
    motion that its settings use.

    keypoints: what `keypoints.of_session` reads beside the session's file.
    films: the other films of the session, as `films_beside` makes them ready.
    like: a tracker of the same video, camera, masks and plate, whose prepared pictures are used.
    """
    require_first_motion(session, first_motion)
    skeleton = Skeleton.of(session.subject.body)
    if like is not None and like.skeleton.body == session.subject.body:
        skeleton = like.skeleton
    poses = {keyframe.frame: keyframe.pose(skeleton) for keyframe in session.subject.keyframes}
    drafted = [keyframe.frame for keyframe in session.subject.keyframes if keyframe.drafted]
    source = people = times_s = None
    steady = steady_camera(session)
    if session.settings.method == "keypose":  # the published method looks for nobody
        source = steadied(keypoint_source(session, video, keypoints), steady)
        people = steadied(_people(session, video, keypoints), steady)
        times_s = video.info.times_s
    parts = keyed_parts(session, skeleton)
    keys = segment_keys(without_part_keyframes(session))
    imported = session.subject.first_motion
    own = [(run.first_frame, run.last_frame) for run in imported.own] if imported else []
    if like is not None:
        return like.renewed(
            skeleton,
            poses,
            first_motion,
            source,
            parts,
            keys,
            fewest=fewest,
            own=own,
            people=people,
            drafted=drafted,
            films=films,
        )
    return Tracker(
        video,
        session.view.camera,
        skeleton,
        poses,
        ignored_regions(session),
        session.has_static_camera,
        memory,
        first_motion,
        source,
        parts,
        keys,
        fewest=fewest,
        own=own,
        people=people,
        steady=steady,
        turns=background_turns(session),
        drafted=drafted,
        times_s=times_s,
        films=films,
    )


def steadied(source: KeypointSource | None, steady: SteadyCamera | None) -> KeypointSource | None:
    """Keypoints as a steady camera sees them; themselves where there is none."""
    return source if source is None or steady is None else SteadyKeypoints(source, steady)


def keypoint_source(
    session: Session, video: Video, keypoints: Keypoints | None
) -> KeypointSource | None:
    """Where keypoints come from, with a person's corrections and without the joints that another
    person lies over at keyframes; None if they do not count."""
    source = _found_keypoints(session, video, keypoints)
    corrections = (
        *session.view.keypoint_corrections,
        *covered_joints(session, session.subject.keyframes),
    )
    if source is not None and corrections:
        source = CorrectedKeypoints(source, corrections)
    if source is None or not lifts_depth(session):
        return source
    return LiftedKeypoints(source, depth_lifter(session, video.info.times_s), keypoints)


def _found_keypoints(
    session: Session, video: Video, keypoints: Keypoints | None
) -> KeypointSource | None:
    if "keypoints" not in session.settings.cues_used or not is_persons(session.subject.body):
        return None
    if session.view.given_keypoints is not None:
        if keypoints is None:
            raise _not_read(session.view.given_keypoints)
        return GivenKeypoints(keypoints)
    detected = detected_keypoints(session, video, masks=needs_masks(session))
    return _or_drafted(detected, session, keypoints)


def _or_drafted(
    detected: KeypointSource, session: Session, keypoints: Keypoints | None
) -> KeypointSource:
    """A network's keypoints, or a draft's where the body lies on them."""
    drafted = session.view.keypoints
    if drafted is None or not has_drafted_keypoints(session):
        return detected
    if keypoints is None:
        raise _not_read(drafted)
    camera, path = session.view.camera, session.camera_path
    return DraftedKeypoints(keypoints, detected, camera, path, drafted.together)


def _not_read(keypoints: KeypointFile) -> SessionError:
    return SessionError(
        f"The keypoints {keypoints.file} were not read; tracking uses them: pass those of "
        "keypoints_of_session(session, folder)."
    )


def _people(session: Session, video: Video, keypoints: Keypoints | None) -> KeypointSource | None:
    """What sees the person's silhouette, where no background shows it."""
    if not needs_masks(session) or not is_persons(session.subject.body):
        return None
    return _or_drafted(detected_keypoints(session, video), session, keypoints)


def detected_keypoints(session: Session, video: Video, *, masks: bool = True) -> DetectedKeypoints:
    """What looks for a session's person with its network, and keeps what it finds.

    masks: whether the person's mask is wanted in each frame.
    """
    model, film = find_model(session.settings.network_used), session.view.video.pictures
    half = not masks and model.skips_frames_at(video.info.fps)
    return DetectedKeypoints(
        video, session.view.camera, film, Detections(), model, half, session.camera_path
    )


def fitter_of(session: Session, video: Video) -> SurfaceFitter:
    """A fitter of a session about surfaces; `video` as `open_video_of` opens it.

    SessionError without a keyframe.
    """
    return SurfaceFitter(session, steps_of(session, video))


def steps_of(session: Session, video: Video) -> Steps:
    """The surfaces that a session is fitted to: its cameras are used only where they count."""
    steps, rated = surfaces_of(video).steps, surface_of(session).weights in ("both", "photo")
    return steps if rated else UnratedSteps(steps)


def track_session(
    session: Session,
    video: Video,
    *,
    segments: Sequence[int] | None = None,
    workers: int = 1,
    cancelled: Callable[[], bool] = never,
    first_motion: Trajectory | None = None,
    keypoints: Keypoints | None = None,
    films: Sequence[FilmBeside] = (),
) -> Iterator[Progress]:
    """Track a session's segments with its own settings; see `pool.run` for the events.

    Each worker may hold one segment's pictures. first_motion, keypoints: what `of_session` of these
    modules reads beside the session's file. films: the other films of the session, as
    `films_beside` makes them ready: SessionError where they are not those that it has. A session
    about surfaces is fitted to them.
    """
    if len(films) != len(session.views) - 1:
        raise SessionError(
            f"The session has {len(session.views)} films, and {len(films) + 1} are given: open the "
            "others with open_other_films and films_beside."
        )
    tracker = _TRACKERS.of(session)(session, video, first_motion, keypoints, films)
    keys = list(segment_keys(session).items())
    chosen = range(len(keys)) if segments is None else sorted(set(segments))
    tasks = [Task(index, keys[index][0], session.settings, keys[index][1]) for index in chosen]
    yield from run_chosen(tracker, session.settings, tasks, workers, cancelled)


def track_ahead(
    session: Session,
    video: Video,
    direction: Direction = "forward",
    *,
    longest: int = LONGEST,
    emit: Emit = lambda motion: None,
    keypoints: Keypoints | None = None,
) -> FoundAhead:
    """Follow the body on from a session's last keyframe, or back from its first, as far as the
    evidence carries; SessionError without a keyframe, or where it is the video's end.

    longest: frames that are followed at most.  emit: is given the motion on the way; raising
    `Cancelled` there ends it, and what was found until then is kept.  keypoints: what
    `keypoints.of_session` reads beside the session's file.
    """
    if not session.subject.keyframes:
        raise SessionError("keyframes: tracking ahead needs one, and the session has none.")
    if session.view.surface is not None:
        raise SessionError("Surfaces are fitted from one keyframe on: use fit, not ahead.")
    frame = session.subject.keyframes[-1 if direction == "forward" else 0].frame
    tracker = tracker_of(session, video, keypoints=keypoints, fewest=1)
    return follow_ahead(tracker, frame, direction, session.settings, emit, longest)


def _film_tracker(
    session: Session,
    video: Video,
    first_motion: Trajectory | None,
    keypoints: Keypoints | None,
    films: Sequence[FilmBeside],
) -> SegmentTracker:
    return tracker_of(session, video, ONCE, first_motion, keypoints=keypoints, films=films)


def _surface_fitter(
    session: Session,
    video: Video,
    _first_motion: Trajectory | None,
    _keypoints: Keypoints | None,
    _films: Sequence[FilmBeside],
) -> SegmentTracker:
    return fitter_of(session, video)


_TRACKERS = ByEvidence({FilmEvidence: _film_tracker, SurfaceEvidence: _surface_fitter})


def require_first_motion(session: Session, first_motion: Trajectory | None) -> None:
    """SessionError unless the motion that the settings start from is there."""
    initial, imported = session.settings.initial, session.subject.first_motion
    if initial == "import" and imported is None:
        raise SessionError(
            "settings.initial is import, but the session has no imported motion: run keypose "
            "import first, or set it to auto."
        )
    if imported is None or imported.own:  # without its own motion a segment starts as any other
        return
    if first_motion is None:
        raise SessionError(
            f"The imported motion {imported.file} was not read; tracking starts from it."
        )
