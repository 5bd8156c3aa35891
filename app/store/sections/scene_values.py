"""What is open and how it is looked at, as JSON: file, camera, views, the switches."""

from __future__ import annotations

import hashlib
import math
from dataclasses import asdict

import numpy as np

from keypose.app.editor.drafted import has_drafts_for_other_up, to_lift
from keypose.app.editor.frames import up_of, views_of
from keypose.app.posing import tilt_and_roll
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.evidence_values import surface_version
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.words.up import SURE_DEG, choice_words, off_deg, up_words
from keypose.tracker.body.trajectory import runs
from keypose.tracker.geometry.horizon import horizon_of
from keypose.tracker.session.references import VideoReference
from keypose.tracker.session.schema import Session
from keypose.tracker.video import VideoInfo


def file(app_state: AppState) -> Json:
    """What is open."""
    opened = app_state.opened
    if opened is None:
        return None
    info, doc = opened.info, doc_of(app_state)
    stated = None if doc is None else doc.evidence.fps
    fps = stated or info.fps
    return {
        "name": (doc.title if doc is not None else "") or opened.name,
        "video": info.path.name,
        "path": opened.session_path,
        "id": opened.id,
        "frames": info.frame_count,
        "fps": fps,
        "width": info.width,
        "height": info.height,
        "duration_s": info.frame_count / fps if stated else float(info.times_s[-1]) + 1 / fps,
        "missing": list(info.missing),
        "times": [round(float(t), 4) for t in info.times_s]
        if info.variable_rate and not stated
        else None,
        "lens": None if info.lens is None else asdict(info.lens),
        "taken": None if doc is None else _taken(info, doc.view.video),
        "repeated": len(doc.view.video.repeats.frames) if doc and doc.view.video.repeats else 0,
    }


def _taken(info: VideoInfo, video: VideoReference) -> Json:
    """How a film was taken, by its file and by what a person says."""
    return {
        "file_fps": None if info.container == "images" else info.fps,
        "recorded_fps": video.recorded_fps,
        "interlaced": info.interlaced,
        "deinterlace": video.deinterlace,
        "depth": info.depth,
        "numbering": info.numbering,
    }


def damage(app_state: AppState) -> Json:
    """First and last of every run of frames that tracking leaves out: damaged or missing ones."""
    opened, doc = app_state.opened, doc_of(app_state)
    if opened is None or doc is None or not doc.evidence.can_be_damaged:
        return []
    flags = np.zeros(opened.info.frame_count, dtype=np.bool_)
    flags[[*opened.info.damaged, *opened.info.missing]] = True
    return [list(run) for run in runs(flags)]


def camera(app_state: AppState) -> Json:
    """The calibrated camera as it is at the present frame, and what is up there."""
    doc = doc_of(app_state)
    if doc is None:
        return None
    frame = app_state.edit.frame if app_state.edit else 0
    camera_here, up = doc.film_camera.at(frame), up_of(doc, frame)
    longer = max(camera_here.width / camera_here.fx, camera_here.height / camera_here.fy)
    tilt, roll = tilt_and_roll(up)
    horizon = horizon_of(camera_here, up)
    return {
        **camera_here.model_dump(),
        "fov_deg": math.degrees(2 * math.atan(longer / 2)),
        "focal_mm": camera_here.focal_mm,
        "lens_source": doc.view.lens_source,
        "lens_is_guess": doc.view.lens_is_guess,
        "depth_share": doc.view.depth_share,
        "up": list(up),
        "up_origin": _up_origin(doc),
        "up_off_deg": _up_off_deg(doc),
        "up_is_sure": _up_is_sure(doc),
        "tilt_deg": tilt,
        "roll_deg": roll,
        "lifts": _lifts(app_state, doc),
        "horizon": None if horizon is None else horizon.tolist(),
        "image_version": image_version(app_state),
    }


def _lifts(app_state: AppState, doc: Session) -> Json:
    """Count what drafting anew would change; None where drafts are as the up direction has them."""
    edit = app_state.edit
    if edit is None or not has_drafts_for_other_up(doc):
        return None
    keyed = {keyframe.frame for keyframe in doc.subject.keyframes}
    keyframes = to_lift(doc) & keyed
    touched = [span for span in edit.fitting if keyframes.intersection(span)]
    return {
        "drafts": len(to_lift(doc) - keyed),
        "keyframes": len(keyframes),
        "segments": len(touched),
    }


def _up_origin(doc: Session) -> str:
    if doc.world.up_world is None:
        return "camera"
    if not doc.has_up_of_hand:
        return "found"
    return "feet" if "feet" in doc.world.up_from and doc.subject.pins else "drawn"


def _up_off_deg(doc: Session) -> int | None:
    """What is said as ± of what was found; None of what somebody drew."""
    sigma_rad = doc.world.up_sigma_rad
    return None if sigma_rad is None else off_deg(sigma_rad)


def _up_is_sure(doc: Session) -> bool:
    """Whether it is known well enough to need no horizon, or somebody set it."""
    off = _up_off_deg(doc)
    return doc.has_up_of_hand if off is None else off <= SURE_DEG


def found_up(app_state: AppState) -> Json:
    """What was found of up, until something else is edited: the upright lines in the
    picture, and where ways disagree what each shows, to choose from."""
    up = app_state.up
    if up is None or up.estimate is None:
        return None
    estimate = up.estimate
    rivals = (
        [estimate.used[0], *(disagreement.evidence for disagreement in estimate.apart)]
        if estimate.apart
        else []
    )
    return {
        "words": up_words(estimate),
        "frame": up.frame,
        "lines": [] if up.lines is None else up.lines.ends.round(1).tolist(),
        "choices": [
            {
                "label": choice_words(up_evidence),
                "source": up_evidence.source,
                "up": up_evidence.up.tolist(),
                "sigma_deg": round(min(math.degrees(up_evidence.sigma_rad), 180.0), 3),
            }
            for up_evidence in rivals
            if up_evidence.source != "set"
        ],
    }


def image_version(app_state: AppState) -> str:
    """What pictures are named by: they depend on the video and on the lens's distortion;
    those of observed surfaces on more.

    Browsers keep them by that name, also for the next video on the same port.
    """
    edit, film = app_state.edit, app_state.opened.film if app_state.opened else ""
    if edit is None:
        return ""
    camera = edit.doc.view.camera
    lens = (camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion)
    woven = () if edit.doc.view.video.deinterlace else ("woven",)
    made_of = (film, lens if camera.is_distorted else (), *woven)
    return hashlib.sha256(repr(made_of).encode()).hexdigest()[:16] + surface_version(edit)


def small_view_rotations(app_state: AppState) -> Json:
    """R_view_camera of the three small views, and where the world's origin is for the camera."""
    edit = app_state.edit
    if edit is None:
        return None
    rotations, origin = views_of(edit.doc, edit.frame)
    return {**{name: R.tolist() for name, R in rotations.items()}, "origin": origin.tolist()}


def view(app_state: AppState) -> Json:
    """Where one looks, and the switches."""
    edit = app_state.edit
    if edit is None:
        return None
    looks = edit.display
    return {
        "frame": edit.frame,
        "selected": edit.selected,
        "body": edit.doc.subject.id,
        "mode": looks.mode,
        "opacity": looks.opacity,
        "ghosts": looks.ghosts,
        "trail": looks.trail,
        "floor": looks.floor,
        "background": looks.background,
        "live": looks.live,
        "limits": looks.limits,
        "axes": looks.axes,
        "link": looks.link,
        "tint": looks.tint,
    }
