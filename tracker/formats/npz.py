"""The motion with all its diagnostics as a NumPy archive, for own programs.

Frames are the N from the first keyframe to the last, parts P, joints and landmarks J, segments S.
Positions are metres in the camera frame, of a camera that moves in that of the same frame: x right,
y down, z away from the camera. Where a frame is not tracked, its numbers are NaN. The fields
`first_frame`, `part_names`, `Rs_parent_part` and `ps_camera_root` make the file of a motion without
gaps a reference for `keypose evaluate`, too, unless it has a rate of its own. Segments are given by
the video's frames. Of several bodies `bodies` has the names, and each field is `NAME/field`.

    first_frame            ()              number of the first frame in the video
    frame, time_s          (N,)            numbers of the frames; their times, seconds
    film_frame             (N,)            which frame of the video that is: where the motion was
                                           given a rate of its own, `frame` counts by that rate
                                           from the video's first frame, and this has fractions
    timecode               ()              of frame 0 of the video; empty where its file has none
    frames_per_second      ()              the rate, where frames are evenly spaced, or the mean
    filter_hz              ()              cut-off of the low-pass filter (Butterworth, fourth
                                           order, without delay); NaN where it is as tracked
    unscaled_frames        (U, 2)          first and last frames of the film over which nothing
                                           tells how far the camera went: it is taken to turn alone
    part_names             (P,)            text
    names                  (J,)            of joints (each part's own) and landmarks
    Rs_parent_part         (N, P, 3, 3)    rotations in the parents' frames (root: the camera's)
    ps_camera_root         (N, 3)
    ps_camera_joint        (N, J, 3)
    angles_zyx_rad         (N, P, 3)       [z, y, x] with R = Rz·Ry·Rx, running on smoothly
    tracked, keyframe      (N,)            true where there is a pose; where it is a keyframe's
    verdict                (N,)            good, check, lost, or empty where not tracked
    segment                (N,)            row of the three below, −1 where not tracked; a keyframe
                                           between two counts to the one that begins there
    segment_frames         (S, 2)          its two keyframes
    segment_verdict        (S,)
    segment_words          (S,)            the verdict in full
    rank                   (N−1,)          of the step from a frame to the next, −1 where not known
    degrees_of_freedom     ()              the rank that there can be
    observability          (N−1, P)        of the step: 0, all guessed, to 1, all seen
    residual               (N−1, P)        of the step: difference of brightness, of 0 to 255
    film_names             (V,)            of the films of the motion, where there are several
    film_joint_names       (12,)           of the joints that detectors know
    film_error_px          (V, N, 12)      how far each lies from where a film shows it, in its
                                           picture; NaN where it does not see it
    films_seeing           (N, 12)         how many films see it
    K                      (3, 3)          the camera; pixel centres are at integers
    distortion             (5,)            k1, k2, p1, p2, k3
    image_size             (2,)            width and height, pixels
    projection             ()              perspective or telephoto
    telephoto_distance_m   ()              NaN for a perspective camera
    up_camera              (3,)            what is up, a unit vector in the camera frame
    T_world_camera         (4, 4)          from the camera frame to the world of all files, y up,
                                           the floor at zero; NaN where no frame is tracked. Of a
                                           camera that moves as its film begins
    Ts_world_camera        (N, 4, 4)       the same at every frame, of a camera that moves alone
    zoom                   (N,)            its focal length as a multiple of that of K
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.formats.conventions import column_names
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rotation_curves import known_smooth_euler
from keypose.tracker.formats.verdict_words import verdict_words
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.storage.archive import archive_bytes

Arrays: TypeAlias = dict[str, NDArray[Any]]


def npz(recording: Recording, beside: Sequence[Recording] = ()) -> bytes:
    """The bytes of the file; the same motion has the same bytes.

    beside: the other bodies of the scene, of the same frames and world.
    """
    if not beside:
        return archive_bytes(_arrays(recording))
    bodies = (recording, *beside)
    arrays = {
        f"{body.body_id}/{name}": array for body in bodies for name, array in _arrays(body).items()
    }
    return archive_bytes({"bodies": np.array([b.body_id for b in bodies], np.str_), **arrays})


def _arrays(recording: Recording) -> Arrays:
    return {
        **_poses(recording),
        **_findings(recording),
        **_films(recording),
        **_camera(recording.camera),
        "up_camera": recording.up_camera,
        "T_world_camera": _world(recording),
        **_camera_motion(recording),
    }


def _camera_motion(recording: Recording) -> Arrays:
    """Where the camera was at every frame; nothing of one that stands still."""
    path = recording.seen_from
    if path is None:
        return {}
    Ts = _world(recording) @ path.Ts_world_camera
    return {"Ts_world_camera": Ts, "zoom": path.zoom}


def _world(recording: Recording) -> Array:
    return recording.T_world_camera if recording.tracks.tracked.any() else np.full((4, 4), np.nan)


def _poses(recording: Recording) -> Arrays:
    tracks = recording.as_seen
    return {
        "first_frame": _whole(tracks.first_frame),
        "frame": _whole(recording.frames),
        "time_s": recording.times_s,
        "film_frame": recording.film_frames,
        "timecode": _text(str(recording.timecode or "")),
        "frames_per_second": np.array(recording.rate if recording.rate is not None else np.nan),
        "filter_hz": np.array(np.nan if recording.filter_hz is None else recording.filter_hz),
        "unscaled_frames": np.array(recording.unscaled, dtype=np.int64).reshape(-1, 2),
        "part_names": _text(tracks.part_names),
        "names": _text(column_names(recording.skeleton)),
        "Rs_parent_part": tracks.Rs_parent_part,
        "ps_camera_root": tracks.ps_camera_root,
        "ps_camera_joint": recording.ps_seen_joint,
        "angles_zyx_rad": known_smooth_euler(tracks.Rs_parent_part),
    }


def _findings(recording: Recording) -> Arrays:
    tracks, segments, at = recording.tracks, recording.segments, recording.segment_at
    return {
        "tracked": tracks.tracked,
        "keyframe": recording.at_keyframe,
        "segment": _whole(at),
        "verdict": _text([segments[i].verdict.kind if i >= 0 else "" for i in at]),
        "segment_frames": _whole([(s.first_frame, s.last_frame) for s in segments]),
        "segment_verdict": _text([s.verdict.kind for s in segments]),
        "segment_words": _text([verdict_words(s.verdict) for s in segments]),
        "rank": _whole(tracks.diagnostics.rank),
        "degrees_of_freedom": _whole(recording.degrees_of_freedom),
        "observability": tracks.diagnostics.observability,
        "residual": tracks.diagnostics.residual,
    }


def _films(recording: Recording) -> Arrays:
    """What several films show of the joints; nothing of one."""
    films = recording.errors_by_film
    if not films:
        return {}
    px = np.stack([film.px for film in films])
    return {
        "film_names": _text([film.name for film in films]),
        "film_joint_names": _text(JOINTS),
        "film_error_px": px,
        "films_seeing": _whole(np.isfinite(px).sum(axis=0)),
    }


def _camera(camera: Camera) -> Arrays:
    distance = camera.telephoto_distance_m
    return {
        "K": camera.K,
        "distortion": np.array(camera.distortion),
        "image_size": _whole((camera.width, camera.height)),
        "projection": _text(camera.projection),
        "telephoto_distance_m": np.array(np.nan if distance is None else distance),
    }


def _whole(values: Any) -> NDArray[np.int64]:
    """The same type on every system."""
    return np.asarray(values).astype("<i8")


def _text(values: Any) -> NDArray[np.str_]:
    return np.asarray(values, dtype=np.str_)
