"""What the writers write: a tracked motion, its times, and what is known of every frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.angle_errors import angle_errors, in_metres
from keypose.tracker.body.film_camera import FilmCamera
from keypose.tracker.body.ground import Ground, ground_of, ground_of_camera
from keypose.tracker.body.joint_angles import Joint, JointAngles, joint_angles
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError
from keypose.tracker.films.errors import FilmErrors
from keypose.tracker.formats.units import Origin
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.session.annotations import Note
from keypose.tracker.session.pins import Pin, sole_of
from keypose.tracker.session.references import Repeats
from keypose.tracker.session.schema import Session
from keypose.tracker.session.verdict import Verdict
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.gait import Gait, gait_of
from keypose.tracker.space.repeated import evened
from keypose.tracker.storage.tracks import Tracks

if TYPE_CHECKING:
    from keypose.tracker.video.info import Timecode

MarkerSetName: TypeAlias = Literal["keypose", "halpe26"]
MARKER_SETS: Final[tuple[MarkerSetName, ...]] = get_args(MarkerSetName)
"""What markers files of markers have, as `keypose.tracker.formats.marker_sets` says."""

TIME_S = 1e-3
"""Times that are off by no more are evenly spaced: containers round them to that."""

AT_KEYFRAME = 0.05
"""A pose so near to a keyframe, in frames of the video, counts as the keyframe's."""


@dataclass(frozen=True)
class RecordedSegment:
    """The frames from one keyframe to the next, and what tracking found there."""

    first_frame: int
    last_frame: int
    verdict: Verdict


@dataclass(frozen=True, eq=False)
class Recording:
    """N consecutive frames. Where one is not tracked, its pose is NaN and it is in no segment.

    They are the video's frames, or poses at a rate of their own
    (`keypose.tracker.formats.sampling`), frame
    n then n / rate seconds after the video's first frame. Segments and open ends have the video's
    numbers in both cases.

    tracks:    the poses and their diagnostics, in the frame of the scene: the camera's, of a camera
               that moves as the film begins.
    stretches: the tracked segments, ascending; neighbours share a keyframe.
    times_s:   (N,) seconds from the video's first frame.
    up_camera: (3,) what is up, a unit vector in that frame.
    open_ends: frames at which a motion of surfaces begins, ends or was stopped without a keyframe.
    rate:      frames a second of all the video's frames on average, or of the poses' own; None
               where the video has no two.
    sampled_at: (N,) which frame of the video a pose belongs to, in fractions; None: its own number.
    filter_hz: the cut-off of the low-pass filter that the poses went through; None: as tracked.
    notes:     what a person wrote at frames of the video.
    part_frames: frames at which limbs alone were keyed, ascending.
    timecode:  the video's; None: its file has none.
    floor_m:   where the floor is, metres along up from the scene's origin; None: as low as the
               body stands.
    path:      of the camera over the whole film; None where it stands still.
    unscaled:  first and last frames of the film over which nothing tells how far the camera went:
               there it is taken to turn alone.
    pins:      what stands still, in frames of the video.
    marker_set: the markers of files of markers.
    origin:    whose ground is the world of files.
    repeats:   repeated frames of the video, where its frames are those of the motion.
    films:     how far joints lie from where each of several films shows them; none of one film.
    kept_ground: the body's ground, where these frames are part of a motion that it is of.
    body_id:   which of a session's bodies it is, where that has several; empty of the only one.
    """

    skeleton: Skeleton
    camera: Camera
    tracks: Tracks
    segments: tuple[RecordedSegment, ...]
    times_s: Array
    up_camera: Array
    open_ends: tuple[int, ...] = ()
    rate: float | None = None
    sampled_at: Array | None = None
    filter_hz: float | None = None
    notes: tuple[Note, ...] = ()
    part_frames: tuple[int, ...] = ()
    floor_m: float | None = None
    timecode: Timecode | None = None
    pins: tuple[Pin, ...] = ()
    marker_set: MarkerSetName = "keypose"
    origin: Origin = "body"
    repeats: Repeats | None = None
    kept_ground: Ground | None = None
    path: CameraPath | None = None
    unscaled: tuple[tuple[int, int], ...] = ()
    films: tuple[FilmErrors, ...] = ()
    body_id: str = ""

    @classmethod
    def of(
        cls,
        session: Session,
        tracks: Tracks,
        segments: Sequence[RecordedSegment],
        times_s: Array,
        timecode: Timecode | None = None,
        films: Sequence[FilmErrors] = (),
        over: Sequence[int] = (),
    ) -> Recording:
        """The motion of a session from its first keyframe to its last, or as far as it reaches.

        times_s are those of all the video's frames, from frame 0. A segment whose frames have no
        poses is left out.  over: frames of the video that are among those of the recording.
        """
        first, last = reach(session, tracks)
        first, last = min(first, *over, first), max(last, *over, last)
        if first < 0 or last >= len(times_s):
            raise FormatError("The tracked motion is longer than the video.")
        return cls(
            Skeleton.of(session.subject.body),
            session.view.camera,
            tracks.in_world(session).between(first, last),
            tuple(s for s in sorted(segments, key=_begin) if _is_tracked(tracks, s)),
            frozen(times_s[first : last + 1]),
            frozen(session.world.up),
            tuple(sorted(_open_ends(session, segments))),
            _mean_rate(times_s),
            notes=session.notes,
            part_frames=tuple(keyframe.frame for keyframe in session.subject.part_keyframes),
            floor_m=session.world.floor_m,
            timecode=timecode,
            pins=session.subject.pins,
            repeats=session.view.video.repeats,
            path=session.camera_path,
            unscaled=_unscaled(session),
            films=tuple(films),
        )

    def __len__(self) -> int:
        return len(self.times_s)

    @property
    def frames(self) -> range:
        """The numbers of the frames."""
        return range(self.tracks.first_frame, self.tracks.first_frame + len(self))

    @property
    def degrees_of_freedom(self) -> int:
        """How many motions were estimated: the highest rank there can be."""
        return int(self.tracks.diagnostics.singular_values.shape[-1])

    @property
    def film_frames(self) -> Array:
        """(N,) which frame of the video each pose belongs to; fractions where it is between two."""
        return np.array(self.frames, dtype=float) if self.sampled_at is None else self.sampled_at

    def timecode_at(self, row: int) -> str | None:
        """The timecode of the video's frame that is nearest to a pose."""
        nearest = round(float(self.film_frames[row]))
        return None if self.timecode is None else self.timecode.at(nearest)

    @cached_property
    def errors_by_film(self) -> tuple[FilmErrors, ...]:
        """Those of `films` at these frames, or at the video's that are nearest: as the motion was
        tracked, before any filter."""
        return tuple(film.at(self.film_frames) for film in self.films)

    @property
    def first_file_number(self) -> int | None:
        """The number in the name of the film's first image file; None where it is no such files, or
        where they are not numbered consecutively."""
        code = self.timecode
        return code.number if code is not None and code.of_files else None

    @property
    def numbers(self) -> range:
        """The numbers of the frames as the shoot counts them: those of image files, where the film
        is such files and each pose is at one of them; else as `frames`."""
        shift = 0 if self.sampled_at is not None else self.first_file_number or 0
        return range(self.frames.start + shift, self.frames.stop + shift)

    @property
    def is_even(self) -> bool:
        """Whether the frames are evenly spaced, at `rate`, to a millisecond."""
        if self.rate is None:
            return False
        off = self.times_s - np.arange(len(self)) / self.rate
        return bool(np.ptp(off) <= 2 * TIME_S)

    @property
    def frames_per_second(self) -> float:
        """The rate, of uneven frames the mean. FormatError where there is none."""
        seconds = float(self.times_s[-1] - self.times_s[0])
        if len(self) < 2 or not 0.0 < seconds < np.inf:
            raise FormatError("A motion needs two frames and the time between them.")
        even = self.rate is not None and self.is_even
        return self.rate if even and self.rate is not None else (len(self) - 1) / seconds

    @cached_property
    def trajectory(self) -> Trajectory:
        """The poses, NaN where not tracked."""
        tracks = self.tracks
        return Trajectory(tracks.first_frame, tracks.Rs_parent_part, tracks.ps_camera_root)

    @cached_property
    def ps_camera_joint(self) -> Array:
        """Joints and landmarks (N, J, 3) in the frame of the scene, metres, NaN where not
        tracked."""
        return frozen(self.trajectory.joints(self.skeleton))

    @cached_property
    def ground(self) -> Ground:
        """The body's own ground. FormatError where no frame is tracked."""
        if self.kept_ground is not None:
            return self.kept_ground
        if not self.tracks.tracked.any():
            raise FormatError("No frame is tracked.")
        return ground_of(self.skeleton, self.trajectory, self.up_camera, self.floor_m)

    @cached_property
    def world(self) -> Ground:
        """The world of all files: the body's ground or the camera's, as `origin` says, and the
        camera's where no frame is tracked. FormatError where the floor is not known either."""
        placed = self.kept_ground is not None or bool(self.tracks.tracked.any())
        if placed and self.origin == "body":
            return self.ground
        floor_m = self.floor_m
        if floor_m is None:
            floor_m = -float(self.ground.p_ground_camera[1])
        return ground_of_camera(self.up_camera, floor_m)

    @property
    def T_world_camera(self) -> Array:
        """(4, 4) from the frame of the scene, the camera's (x right, y down, z forward), to the
        world of all files."""
        return self.world.T_ground_camera

    @cached_property
    def seen_from(self) -> CameraPath | None:
        """Where the camera was at every pose, N of them; None where it stands still."""
        return None if self.path is None else self.path.sampled(self.film_frames)

    @property
    def Ts_world_camera(self) -> Array:
        """(N, 4, 4) from the camera's frame at every pose to the world of all files."""
        if self.seen_from is None:
            return np.broadcast_to(self.T_world_camera, (len(self), 4, 4))
        return np.asarray(self.T_world_camera @ self.seen_from.Ts_world_camera)

    @cached_property
    def as_seen(self) -> Tracks:
        """The poses each in the frame of the camera as it was then."""
        if self.seen_from is None:
            return self.tracks
        trajectory = self.trajectory.carried(self.seen_from.Ts_camera_world)
        Rs, ps = trajectory.Rs_parent_part, trajectory.ps_camera_root
        return replace(self.tracks, Rs_parent_part=Rs, ps_camera_root=ps)

    @cached_property
    def ps_seen_joint(self) -> Array:
        """Joints and landmarks (N, J, 3) in the frame of the camera as it was then, metres."""
        if self.seen_from is None:
            return self.ps_camera_joint
        tracks = self.as_seen
        motion = Trajectory(tracks.first_frame, tracks.Rs_parent_part, tracks.ps_camera_root)
        return frozen(motion.joints(self.skeleton))

    def camera_at(self, row: int) -> Camera:
        """The camera with the focal length it has at a pose."""
        return FilmCamera(self.camera, self.seen_from).at(row)

    def with_ground(self) -> Recording:
        """The recording with its ground given, so that parts of it and filtered ones lie in the
        same world; itself where no frame is tracked."""
        return replace(self, kept_ground=self.ground) if self.tracks.tracked.any() else self

    @cached_property
    def joint_angles(self) -> tuple[JointAngles, ...]:
        """The angles of a person's joints by their clinical names, the pelvis' on the body's own
        ground; none of another body."""
        return self.joint_angles_in(self.ground) if self.tracks.tracked.any() else ()

    def joint_angles_in(self, world: Ground) -> tuple[JointAngles, ...]:
        """The angles of a person's joints with the pelvis' in a world; none of another body."""
        Rs = self.tracks.Rs_parent_part
        angles = joint_angles(self.skeleton.body, Rs, world.R_ground_camera)
        errors = self._angle_errors(world)
        if errors is None:
            return angles
        return tuple(replace(each, errors_deg=np.degrees(errors[each.joint])) for each in angles)

    def _angle_errors(self, world: Ground) -> dict[Joint, Array] | None:
        """By how much angles are expected to be off; None where no depth was lifted."""
        diagnostics, tracks = self.tracks.diagnostics, self.as_seen
        if diagnostics.expected_error is None or diagnostics.expected_depth is None:
            return None
        motion = Trajectory(tracks.first_frame, tracks.Rs_parent_part, tracks.ps_camera_root)
        zoom = 1.0 if self.seen_from is None else self.seen_from.zoom
        across_m = in_metres(diagnostics.expected_error, self.camera, tracks.ps_camera_root, zoom)
        R_world_camera = world.R_ground_camera
        if self.seen_from is not None:
            R_world_camera = R_world_camera @ self.seen_from.Ts_world_camera[:, :3, :3]
        return angle_errors(
            self.skeleton, motion, across_m, diagnostics.expected_depth, R_world_camera
        )

    @cached_property
    def foot_pins(self) -> tuple[Pin, ...]:
        """The pins that hold feet, in the numbers of these frames."""
        feet = {part.name for part in self.skeleton.body.parts if sole_of(part)}
        film = self.film_frames
        pins = []
        for pin in self.pins:
            if pin.part in feet and pin.last_frame >= film[0] and pin.first_frame <= film[-1]:
                first, last = (self.frames[int(np.abs(film - f).argmin())] for f in pin.span)
                pins.append(pin.model_copy(update={"first_frame": first, "last_frame": last}))
        return tuple(pins)

    @cached_property
    def evened(self) -> Recording:
        """The recording as without repeated frames, which speeds and accelerations are taken of."""
        motion = evened(self.trajectory, self.repeats)
        if motion is self.trajectory:
            return self
        Rs, ps = motion.Rs_parent_part, motion.ps_camera_root
        tracks = replace(self.tracks, Rs_parent_part=Rs, ps_camera_root=ps)
        return replace(self, tracks=tracks, repeats=None)

    @cached_property
    def gait(self) -> Gait:
        """Heel strikes, toe offs and strides, of feet as they are pinned, or else found standing
        in a motion without gaps; empty where none stands, or nothing is tracked."""
        pins = self.foot_pins
        if not self.tracks.tracked.any() or len(self) < 2:
            return Gait((), ())
        if not pins and self.tracks.tracked.all():
            rate, up = self.frames_per_second, self.up_camera
            eyes = None if self.seen_from is None else self.seen_from.Ts_world_camera[:, :3, 3]
            pins = proposed_pins(self.skeleton, self.evened.trajectory, rate, up, eyes)
        motion = self.evened.trajectory
        return gait_of(self.skeleton, motion, self.times_s, self.ground, pins)

    def whole(self, name: str) -> Recording:
        """Cut to the first and last tracked frame, for a format of this name that holds no gaps.

        FormatError names the frames between that are not tracked.
        """
        rows = np.flatnonzero(self.tracks.tracked)
        if not len(rows):
            raise FormatError("No frame is tracked.")
        whole = self.between(self.frames[int(rows[0])], self.frames[int(rows[-1])])
        if not whole.tracks.tracked.all():
            missing = whole.tracks.runs(tracked=False)
            which = f"Frames {missing} are" if " " in missing else f"Frame {missing} is"
            raise FormatError(
                f"{which} not tracked, and {name} holds no gaps: track them first, or choose CSV, "
                "NPZ, TRC or C3D."
            )
        return whole

    def between(self, first: int, last: int) -> Recording:
        """The frames first to last, of those that there are."""
        start, end = first - self.tracks.first_frame, last + 1 - self.tracks.first_frame
        return replace(
            self,
            tracks=self.tracks.between(first, last),
            times_s=self.times_s[start:end],
            sampled_at=None if self.sampled_at is None else self.sampled_at[start:end],
        )

    @cached_property
    def notes_at(self) -> tuple[tuple[Note, ...], ...]:
        """Every frame's notes; where poses have a rate of their own, at the nearest of them."""
        at: list[list[Note]] = [[] for _ in range(len(self))]
        film = self.film_frames
        for note in self.notes:
            if film[0] - 0.5 <= note.frame <= film[-1] + 0.5:
                at[int(np.argmin(np.abs(film - note.frame)))].append(note)
        return tuple(tuple(notes) for notes in at)

    @cached_property
    def segment_at(self) -> NDArray[np.int64]:
        """(N,) the segment a frame is in, −1 for none: of two, the one that begins there."""
        at, film = np.full(len(self), -1), self.film_frames
        for i, segment in enumerate(self.segments):
            at[(film >= segment.first_frame) & (film <= segment.last_frame)] = i
        at[~self.tracks.tracked] = -1
        at.setflags(write=False)
        return at

    @cached_property
    def at_keyframe(self) -> NDArray[np.bool_]:
        """(N,) True at a keyframe, whose pose is not a tracked one."""
        ends = {frame for s in self.segments for frame in (s.first_frame, s.last_frame)}
        return self._at(sorted(ends - set(self.open_ends)))

    @property
    def at_part_keyframe(self) -> NDArray[np.bool_]:
        """(N,) True where limbs alone were keyed."""
        return self._at(self.part_frames)

    def _at(self, frames: Sequence[int]) -> NDArray[np.bool_]:
        near = np.abs(self.film_frames[:, None] - np.array(frames, dtype=float)) <= AT_KEYFRAME
        is_near = np.asarray(near.any(axis=1))
        is_near.setflags(write=False)
        return is_near


def reach(session: Session, tracks: Tracks) -> tuple[int, int]:
    """First and last frame of a session's keyframes and motion."""
    keyed = [keyframe.frame for keyframe in session.subject.keyframes]
    last = tracks.first_frame + len(tracks.tracked) - 1
    return min([tracks.first_frame, *keyed]), max([last, *keyed])


def on_one_ground(recordings: Sequence[Recording]) -> list[Recording]:
    """Recordings of one scene in one world: the first body's ground, as low as the lowest stands
    where the floor is not known."""
    grounds = [recording.ground for recording in recordings]
    x, _, z = grounds[0].p_ground_camera
    y = max(float(ground.p_ground_camera[1]) for ground in grounds)
    ground = replace(grounds[0], p_ground_camera=frozen([x, y, z]))
    return [replace(recording, kept_ground=ground) for recording in recordings]


def named_apart(recording: Recording, names: Sequence[str]) -> tuple[str, ...]:
    """Names in a file of several bodies: the body's stands before a colon, as Vicon has subjects
    and Maya has namespaces."""
    return tuple(f"{recording.body_id}:{name}" for name in names)


def _unscaled(session: Session) -> tuple[tuple[int, int], ...]:
    motion = session.view.camera_motion
    if motion is None or session.camera_path is None:
        return ()
    return tuple(
        (camera_finding.first_frame, camera_finding.last_frame)
        for camera_finding in motion.unscaled
    )


def _mean_rate(times_s: Array) -> float | None:
    """Frames a second; None where there are no two, or no time between them."""
    seconds = float(times_s[-1] - times_s[0]) if len(times_s) else 0.0
    return (len(times_s) - 1) / seconds if 0.0 < seconds < np.inf else None


def _open_ends(session: Session, segments: Sequence[RecordedSegment]) -> set[int]:
    """Frames where segments of surfaces end without a keyframe."""
    ends = {frame for s in segments for frame in (s.first_frame, s.last_frame)}
    keyed = [keyframe.frame for keyframe in session.subject.keyframes]
    return set(session.evidence.open_ends(keyed, ends))


def _begin(segment: RecordedSegment) -> int:
    return segment.first_frame


def _is_tracked(tracks: Tracks, segment: RecordedSegment) -> bool:
    start, end = (f - tracks.first_frame for f in (segment.first_frame, segment.last_frame))
    return 0 <= start < end < len(tracks.tracked) and bool(tracks.tracked[start : end + 1].all())
