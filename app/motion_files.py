"""The tracked motion as files for other programs, whichever door it leaves by."""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass
from typing import Literal, TypeAlias

from app.editor.state import EditorState
from app.results import frames_in_words
from tracker.errors import FormatError
from tracker.formats.bvh import bvh
from tracker.formats.csv import angles_csv, joints_csv
from tracker.geometry import Array
from tracker.skeleton import Skeleton
from tracker.trajectory import Trajectory, joined

MotionFormat: TypeAlias = Literal["csv", "bvh"]


@dataclass(frozen=True)
class File:
    """One file to save; `suffix` follows the session's name."""

    content: bytes
    media_type: str
    suffix: str


def motion_files(
    format_name: MotionFormat, skeleton: Skeleton, motion: Trajectory, times_s: Array
) -> dict[str, str]:
    """The files' texts by their names; times_s (N,) are those of the motion's frames."""
    if len(times_s) != len(motion):
        raise FormatError("The tracked motion is longer than the video.")
    if format_name == "bvh":
        mean_s = float(times_s[-1] - times_s[0]) / (len(times_s) - 1)
        return {"motion.bvh": bvh(skeleton, motion, mean_s)}
    return {
        "joints.csv": joints_csv(skeleton, motion, times_s),
        "angles.csv": angles_csv(skeleton, motion, times_s),
    }


def motion_archive(format_name: MotionFormat, edit: EditorState) -> File:
    """The motion as one file: several are packed into a zip. FormatError where frames lack."""
    motion = whole_motion(edit)
    times_s = edit.times_s[motion.first_frame : motion.last_frame + 1]
    files = motion_files(format_name, edit.skeleton, motion, times_s)
    if len(files) == 1:
        return File(next(iter(files.values())).encode(), "text/plain", f".{format_name}")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(zipfile.ZipInfo(name), text, zipfile.ZIP_DEFLATED)  # without a clock
    return File(packed.getvalue(), "application/zip", f"-{format_name}.zip")


def whole_motion(edit: EditorState) -> Trajectory:
    """The motion over all segments; FormatError names those that are not tracked."""
    if len(edit.keys) < 2:
        raise FormatError("There is no motion yet: pose two keyframes and track.")
    finished = {span: t for span, t in edit.fitting.items() if t.finished}
    spans = list(zip(edit.keys, edit.keys[1:], strict=False))
    missing = [span for span in spans if span not in finished]
    if missing:
        words = ", ".join(frames_in_words(*span) for span in missing)
        raise FormatError(f"Frames {words} are not tracked as they stand: track them first.")
    return joined([finished[span].trajectory for span in spans])
