"""What a segment's motion was tracked for, as one digest: equal where the motion would be equal.

The quality is not in it: preview and full results of one key are the same motion, found with less
or more care. Of observed surfaces other things decide than of pictures: how the meshes are read and
weighed, and the pose in the mesh that moves with the body; never the camera, which only looks at
them.

A result of an older Keypose may have no key. For it there is the digest of all that is tracked with
besides keyframes, which its file has (`setup_hash`).
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final, TypeAlias

import numpy as np

from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, frozen, rotation_from_quaternion
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.model_files import LIFTER, find_model
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.camera_motion import CameraMotion
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence, surface_of
from keypose.tracker.session.references import KEYPOINT_RUN
from keypose.tracker.storage.bodies_before import keyframes_before
from keypose.tracker.storage.by_id import ById
from keypose.tracker.storage.covered_joints import covered_joints

Span: TypeAlias = tuple[int, int]
"""First and last frame of a segment, as in Session.spans."""

DECIMALS = 9
"""Poses that agree to a billionth of a metre or radian are the same pose."""
_BY_THEMSELVES = {"quality", "initial", "left_out", "cues", "network", "smooth", "find_camera"}
"""Settings that count where they change a motion, or never."""
LIMITS = {"limits_deg", "twist"}
"""What of a part no segment is tracked by; see `stretches`."""
AT_REST = (1.0, 0.0, 0.0, 0.0)


def segment_keys(session: Session) -> dict[Span, str]:
    """The keys of all segments of a session, in the order of their frames."""
    return dict(_keys_of(session))


def _keys_of(session: Session) -> dict[Span, str]:
    return _keys(ById(session), _digest(session.settings.network_used))


@lru_cache(maxsize=32)
def _keys(session: ById, _network: str) -> dict[Span, str]:
    """Cached: called often for an unchanged session.

    _network: its digest, another one once a file of that name is added, replaced or removed.
    """
    return keys_of_spans(session.it, session.it.spans)


def present_keys(session: Session) -> dict[Span, str]:
    """The keys of all segments with the method and the start of the session's results, which its
    settings may no longer have."""
    if session.subject.results is None:
        return segment_keys(session)
    used = session.subject.results.settings_used(session.settings)
    return segment_keys(session.changed({"settings": used}))


def segment_key(session: Session, first: int, last: int) -> str:
    """The key of one segment; KeyError where the session has no such segment."""
    return _keys_of(session)[first, last]


def keys_of_spans(session: Session, spans: Sequence[Span]) -> dict[Span, str]:
    """The keys of a few segments, for a session of which no others are asked."""
    setup = _setup(session)
    at = {keyframe.frame: keyframe for keyframe in session.subject.keyframes}
    return {span: _key(session, setup, at, span) for span in spans}


def without_part_keyframes(session: Session) -> Session:
    """The session whose segments are tracked before limbs are set right in them."""
    if not session.subject.part_keyframes:
        return session
    return session.changed({"part_keyframes": ()})


def setup_hash(session: Session) -> str:
    """SHA-256 of what a motion is tracked with besides keyframes: body, camera, ignore masks; or
    body and surfaces.

    Notes, the camera's `origin` and joint limits do not count: they change no motion.
    """
    return _INPUTS.of(session).whole(session)


def ahead_key(session: Session, keyframe: Keyframe) -> str:
    """Digest what a body is followed ahead with from a keyframe: its pose, the body
    and the camera.
    """
    pose = _pose(ById(keyframe), session.subject.body.names)
    setup = [keyframe.frame, _body(ById(session.subject.body)), _camera(ById(session.view.camera))]
    setup += _woven(session)
    return hashlib.sha256(json.dumps(setup).encode() + pose).hexdigest()[:16]


def open_ends(session: Session) -> tuple[int, ...]:
    """Where a motion of surfaces begins or ends without a keyframe; none of a film's."""
    return session.evidence.open_ends([keyframe.frame for keyframe in session.subject.keyframes])


def _key(session: Session, setup: bytes, at: Mapping[int, Keyframe], span: Span) -> str:
    names = session.subject.body.names
    ends = [at[frame] for frame in span if frame in at]  # an open end has no keyframe
    segment = [span, _INPUTS.of(session).segment(session, span, ends)]
    poses = [_pose(ById(end), names) for end in ends]
    for keyframe in session.subject.part_keyframes:
        if span[0] < keyframe.frame < span[1]:
            exact = json.dumps([keyframe.frame, sorted(keyframe.parts)]).encode()
            poses += [exact, _pose(ById(keyframe), names)]
    return hashlib.sha256(b"\0".join((setup, json.dumps(segment).encode(), *poses))).hexdigest()


def _film_segment(session: Session, span: Span, ends: Sequence[Keyframe]) -> list[Any]:
    """What counts within a segment: masks, corrected keypoints, an own motion, and where
    depth is lifted, which of its keyframes nobody posed."""
    evidence = [*_masks_and_corrections(session, span, ends), *_own_start(session, span)]
    drafted = [end.frame for end in ends if end.drafted and lifts_depth(session)]
    evidence += [{"not_posed": drafted}] if drafted else []
    return [*evidence, *_steadied(session, span), *_bodies_before(session, span, ends)]


def _bodies_before(session: Session, span: Span, ends: Sequence[Keyframe]) -> list[Any]:
    """How other bodies are posed that may be before this one in a segment; nothing where none is
    near it in the picture."""
    if len(session.bodies) == 1:
        return []
    before = [
        [_body(ById(body.body)), [[k.frame, _pose(ById(k), body.body.names).hex()] for k in posed]]
        for body, posed in keyframes_before(session, span, ends)
    ]
    digests = sorted(hashlib.sha256(json.dumps(each).encode()).hexdigest() for each in before)
    return [{"before": digests}] if digests else []


def steady_camera(session: Session) -> SteadyCamera | None:
    """The camera in whose place a session's film is tracked; None where its own stands still.

    It turns along the path as that was found: how a person corrects its turns changes no tracked
    motion. It zooms as corrected, since poses are seen so.
    """
    motion, path = session.view.camera_motion, session.camera_path
    if motion is None or path is None:
        return None
    return _steady(session.view.camera, motion, path)


@lru_cache(maxsize=4)
def _steady(camera: Camera, motion: CameraMotion, path: CameraPath) -> SteadyCamera:
    camera_path = CameraPath(motion.path.Ts_camera_world, path.zoom)
    return SteadyCamera.along(camera, camera_path)


def background_turns(session: Session) -> Array | None:
    """How the steady camera is turned from the world at every frame, (F, 3, 3), where a film
    is compared with the empty scene all around its camera; with keypoints that gains nothing."""
    motion, method = session.view.camera_motion, session.settings.method
    steady = steady_camera(session)
    if method != "keypose" or _uses_keypoints(session) or steady is None:
        return None
    if motion is None or motion.kind != "turns":
        return None
    return turns_of(steady, motion)


def shows_background(session: Session) -> bool:
    """Whether the empty scene is known: before a camera that stands still, or turns alone
    and is tracked without keypoints."""
    return session.has_static_camera or background_turns(session) is not None


@lru_cache(maxsize=4)
def turns_of(steady: SteadyCamera, motion: CameraMotion) -> Array:
    """How the steady camera of one that turns is turned from the world, (F, 3, 3)."""
    return frozen(steady.Rs_steady_camera @ motion.path.Ts_camera_world[:, :3, :3])


def _plate(session: Session) -> list[Any]:
    """What the empty scene all around is put together by; nothing where there is none."""
    motion, steady = session.view.camera_motion, steady_camera(session)
    if motion is None or steady is None or background_turns(session) is None:
        return []
    return [{"around": _around_digest(steady, motion)}]


@lru_cache(maxsize=4)
def _around_digest(steady: SteadyCamera, motion: CameraMotion) -> str:
    numbers = np.concatenate((turns_of(steady, motion).ravel(), steady.zoom))
    return hashlib.sha256(_rounded(numbers)).hexdigest()


def _steadied(session: Session, span: Span) -> list[Any]:
    """How a segment's pictures are turned and enlarged; nothing where they are not."""
    steady = steady_camera(session)
    if steady is None:
        return []
    rows = slice(span[0], span[1] + 1)
    numbers = np.concatenate((steady.Rs_steady_camera[rows].ravel(), steady.zoom[rows]))
    return [{"steady": hashlib.sha256(_rounded(numbers)).hexdigest()}]


def _own_start(session: Session, span: Span) -> list[Any]:
    first_motion = session.subject.first_motion
    run = None if first_motion is None else first_motion.own_run(*span)
    if run is None or session.settings.initial not in ("auto", "import"):
        return []
    return [{"own": [run.first_frame, run.last_frame, run.digest]}]


def _masks_and_corrections(session: Session, span: Span, ends: Sequence[Keyframe]) -> list[Any]:
    """The masks clipped to the segment; their other frames do not count. Where keypoints count,
    also what a person said of them there, which joints another person lies over at its ends, and
    where the person is looked for, what a draft saw."""
    first, last = span
    within = [
        (max(first, mask.first_frame), min(last, mask.last_frame), mask.polygon)
        for mask in session.view.ignore_masks
        if mask.first_frame <= last and mask.last_frame >= first
    ]
    evidence: list[Any] = [*sorted(within), *_drafted(session, span)]
    if not _uses_keypoints(session):
        return evidence
    corrected = [
        [each.frame, each.joint, each.uv]
        for each in (*session.view.keypoint_corrections, *covered_joints(session, ends))
        if first <= each.frame <= last
    ]
    return [*evidence, {"keypoints": corrected}] if corrected else evidence


def has_drafted_keypoints(session: Session) -> bool:
    """Whether a draft's keypoints serve segments as well, for their keypoints or for their
    silhouette: the same network's, with masks of the person where these are wanted."""
    drafted, masks = session.view.keypoints, _looks_for_person(session)
    if drafted is None or not drafted.runs or (masks and not drafted.masks):
        return False
    if not masks and not _uses_keypoints(session):
        return False
    return drafted.model == _digest(session.settings.network_used)


def _drafted(session: Session, span: Span) -> list[Any]:
    """What a draft's keypoints are in a segment; nothing where they do not count."""
    if session.view.keypoints is None or not has_drafted_keypoints(session):
        return []
    beyond = _frames_looked_beyond(session) if lifts_depth(session) else 0
    first, last = max(span[0] - beyond, 0) // KEYPOINT_RUN, (span[1] + beyond) // KEYPOINT_RUN
    runs = session.view.keypoints.runs[first : last + 1]
    return [{"drafted": runs}] if runs else []


LIFTED_FROM_S: Final = 0.5
"""Depth is lifted from no frames farther away; where it is lifted knows more exactly."""


def lifts_depth(session: Session) -> bool:
    """Whether the depth of keypoints is lifted from what is seen around a frame."""
    return "depth" in session.settings.cues_used and _uses_keypoints(session)


def _frames_looked_beyond(session: Session) -> int:
    """How many frames before and after a segment, at most, its depth is lifted from."""
    keyframe, last = session.subject.keyframes[0], session.subject.keyframes[-1]
    rate = (last.frame - keyframe.frame) / max(last.time_s - keyframe.time_s, 1e-6)
    return math.ceil(LIFTED_FROM_S * float(rate))


def _looks_for_person(session: Session) -> bool:
    """Whether a network's masks judge the silhouette."""
    keypose = session.settings.method == "keypose"
    return keypose and needs_masks(session) and is_persons(session.subject.body)


def needs_masks(session: Session) -> bool:
    """Whether the person's masks are wanted, since no background shows their silhouette."""
    return "silhouette" in session.settings.cues_used and not shows_background(session)


def _keyframe_ends(_session: Session, _span: Span, ends: Sequence[Keyframe]) -> list[Any]:
    """Which of a segment's ends are keyframes."""
    return [end.frame for end in ends]


def _setup(session: Session) -> bytes:
    """What every segment's motion depends on besides its poses and masks."""
    return _INPUTS.of(session).setup(session)


def _film_setup(session: Session) -> bytes:
    settings = session.settings.model_dump(mode="json", exclude=_BY_THEMSELVES)
    settings["static_camera"] = session.has_static_camera  # found or chosen is the same motion
    setup = [
        _body(ById(session.subject.body)),
        _camera(ById(session.view.camera)),
        settings,
        *_start(session),
    ]
    setup += [*_cues(session), *_plate(session), *_woven(session), *_other_films(session)]
    return hashlib.sha256(json.dumps(setup, sort_keys=True).encode()).digest()


def _other_films(session: Session) -> list[Any]:
    """What other films show, and how they lie beside the first; nothing where there are none, or
    where they do not count."""
    if not _uses_keypoints(session):
        return []
    counted = {"R_camera_world_wxyz", "p_camera_world", "camera_motion", "camera_keyframes"}
    others = []
    for view in session.views[1:]:
        own = view.model_dump(mode="json", include=counted)
        masks = sorted(
            (mask.first_frame, mask.last_frame, mask.polygon) for mask in view.ignore_masks
        )
        own |= {"film": view.video.fingerprint, "camera": _camera(ById(view.camera))}
        own |= {"clock": [view.film_clock.begins, view.film_clock.rate], "masks": masks}
        own |= {"keypoints": view.keypoints and view.keypoints.file}
        own |= {"static": session.alone(view.id).has_static_camera, "woven": view.video.deinterlace}
        others.append(own)
    path = session.camera_path
    if others and path is not None:
        numbers = np.concatenate((path.Ts_camera_world.ravel(), path.zoom))
        others.append({"first_camera": hashlib.sha256(_rounded(numbers)).hexdigest()})
    return [{"films": others}] if others else []


def _surface_setup(session: Session) -> bytes:
    """The same of surfaces: the body as it was posed in the mesh that moves with it, the meshes,
    and how they are read. A folder may be moved as a whole, so cameras go by their file's content.
    """
    surface, model = surface_of(session), session.model_keyframe
    reading = surface.model_dump(mode="json", exclude={"fps", "model_frame", "cameras"})
    setup: list[Any] = [
        "surface",
        _body(ById(session.subject.body)),
        reading,
        session.view.video.fingerprint,
    ]
    if model is not None:
        pose = hashlib.sha256(_pose(ById(model), session.subject.body.names)).hexdigest()
        setup += [model.frame, pose]
    return hashlib.sha256(json.dumps(setup, sort_keys=True).encode()).digest()


def _film_hash(session: Session) -> str:
    view = session.view.model_dump(
        mode="json",
        include={"camera", "ignore_masks"},
        exclude={"camera": {"origin"}, "ignore_masks": {"__all__": {"note"}}},
    )
    return _sha256({**view, **_whole_body(session)})


def _surface_hash(session: Session) -> str:
    """The cameras go by their file's content: a folder may be moved as a whole."""
    model = session.model_keyframe
    reading = {"fps", "model_frame", "cameras"}
    data = session.view.model_dump(mode="json", include={"surface"}, exclude={"surface": reading})
    data |= _whole_body(session)
    data["meshes"] = session.view.video.fingerprint
    data["model_frame"] = None if model is None else model.frame
    return _sha256(data)


def _whole_body(session: Session) -> dict[str, Any]:
    parts = {"parts": {"__all__": LIMITS}}
    return session.subject.model_dump(mode="json", include={"body"}, exclude={"body": parts})


def _sha256(data: dict[str, Any]) -> str:
    canonical = json.dumps(data, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()


@dataclass(frozen=True)
class _Inputs:
    """What a motion depends on besides its poses.

    setup: for every segment.  segment: for one.  whole: for all, as `setup_hash`.
    """

    setup: Callable[[Session], bytes]
    segment: Callable[[Session, Span, Sequence[Keyframe]], list[Any]]
    whole: Callable[[Session], str]


_INPUTS = ByEvidence(
    {
        FilmEvidence: _Inputs(_film_setup, _film_segment, _film_hash),
        SurfaceEvidence: _Inputs(_surface_setup, _keyframe_ends, _surface_hash),
    }
)


def _cues(session: Session) -> list[Any]:
    """What counts besides brightness; nothing where nothing does."""
    settings, cues = session.settings, list(_keypoints(session))
    if settings.method == "keypose" and "silhouette" in settings.cues_used:
        if not needs_masks(session):
            cues += ["silhouette"]
        elif _looks_for_person(session):
            cues += ["person", _digest(settings.network_used)]
    return cues


def _keypoints(session: Session) -> list[Any]:
    """Which keypoints count.

    Those that a network finds follow from the film and the segment's own keyframes, and those of a
    draft are counted by the segment (`_drafted`).
    """
    if not _uses_keypoints(session):
        return []
    settings, keypoint_file = session.settings, session.view.given_keypoints
    lifted = [LIFTER.sha256, session.view.video.recorded_fps] if lifts_depth(session) else []
    return [
        "keypoints",
        _digest(settings.network_used) if keypoint_file is None else keypoint_file.file,
        *lifted,
    ]


def _digest(network: str) -> str:
    """A network's digest; its name where it is not here: then no result fits."""
    try:
        return find_model(network).sha256
    except KeypointError:
        return network


def _woven(session: Session) -> list[Any]:
    """Whether interlaced frames keep their fields; nothing where not."""
    return [] if session.view.video.deinterlace else ["woven"]


def _uses_keypoints(session: Session) -> bool:
    settings = session.settings
    wanted = settings.method == "keypose" and "keypoints" in settings.cues_used
    return wanted and is_persons(session.subject.body)


def _start(session: Session) -> list[Any]:
    """What segments start from, besides the method's own start."""
    initial, first_motion = session.settings.initial, session.subject.first_motion
    left_out = sorted(set(session.settings.left_out))
    if initial == "templates":
        return [initial, left_out]
    imported = first_motion is not None and not first_motion.own
    start: list[Any] = [initial, first_motion.file] if first_motion and imported else []
    return [*start, left_out] if left_out and initial == "auto" else start


@lru_cache(maxsize=8)
def _body(body: ById) -> str:
    """Names of parts count, since the verdict has them; other captions do not."""
    parts = {"__all__": LIMITS}
    captions = {"name": True, "source": True, "mirror_pairs": True}
    data = body.it.model_dump(mode="json", exclude={**captions, "parts": parts})
    return json.dumps(data, sort_keys=True)


@lru_cache(maxsize=8)
def _camera(camera: ById) -> str:
    return json.dumps(camera.it.model_dump(mode="json", exclude={"origin"}), sort_keys=True)


@lru_cache(maxsize=4096)
def _pose(keyframe: ById, names: tuple[str, ...]) -> bytes:
    """The pose as numbers, the same however its quaternions were signed or left out."""
    wxyz = np.array([keyframe.it.rotations_wxyz.get(name, AT_REST) for name in names])
    numbers = np.concatenate([rotation_from_quaternion(wxyz).ravel(), keyframe.it.root_m])
    return _rounded(numbers)


def _rounded(numbers: Array) -> bytes:
    """Numbers as every machine has them: to nine decimals, without negative zeros."""
    return (np.round(numbers, DECIMALS) + 0.0).tobytes()
