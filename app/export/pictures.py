"""Pictures of many frames, each as `keypose shot` draws it, in one zip."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

from keypose.app.render.poses import KnownPoses
from keypose.app.render.snapshots import png
from keypose.app.render.stills import Still, still
from keypose.tracker.session.schema import Session
from keypose.tracker.video import Video


def write_pictures(
    out: Path,
    session: Session,
    video: Video,
    poses: KnownPoses,
    frames: Sequence[int],
    wanted: Still,
    drawn: Callable[[int, int], None] = lambda done, of: None,
) -> None:
    """A zip with frame0001.png and so on; `drawn` receives how many of how many are done."""
    digits = max(4, len(str(session.video.frame_count - 1)))
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:  # PNG is packed already
        for done, frame in enumerate(frames, start=1):
            content = png(still(session, video, frame, poses, wanted))
            archive.writestr(zipfile.ZipInfo(f"frame{frame:0{digits}}.png"), content)
            drawn(done, len(frames))
