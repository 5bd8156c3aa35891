"""What was done at a desk done again in a browser, with mouse and keyboard, and counted there.

Presses and keys are counted by the browser itself; D and Alt, which are held while something is
dragged, are no keys of their own. Where handles are is read from the page. Frames, handles and
keyframes only: rings, fits and drafts are not done again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Page

from bench.human.clips import Watched
from bench.human.desk import Desk, Did
from keypose.app.editor import actions as do
from keypose.app.posing.gesture import End, Middle, Root
from keypose.app.posing.handles import handle_named
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.storage.files import save_session
from tests.browser.interaction import Spot, answered, section, spot, until_state

LISTEN = """
() => {
  window.counted = { click: 0, drag: 0, key: 0 };
  let from = null;
  const far = (e) => Math.hypot(e.clientX - from[0], e.clientY - from[1]) > 3;
  addEventListener('pointerdown', (e) => { from = [e.clientX, e.clientY]; }, true);
  addEventListener('pointerup', (e) => {
    if (from) window.counted[far(e) ? 'drag' : 'click'] += 1;
    from = null;
  }, true);
  addEventListener('keydown', (e) => {
    if (!e.repeat && !['d', 'Alt', 'Shift', 'Control'].includes(e.key)) window.counted.key += 1;
  }, true);
}
"""


@dataclass(frozen=True)
class Seen:
    """What the browser counted, and where joints are at each keyframe, pixels of the video."""

    counts: Counter[str]
    joints: dict[int, dict[str, Array]]


def session_for(clip: Watched, settings: TrackSettings, folder: Path) -> Path:
    """The clip as a session that the page opens."""
    path = folder / "session.json"
    reference = clip.session.video.model_copy(update={"path": str(clip.video.absolute())})
    doc = clip.session.model_copy(update={"video": reference, "settings": settings})
    save_session(doc, path)
    return path


def repeated(page: Page, desk: Desk) -> Seen:
    """The desk's script done at a page that has just been opened on the same session."""
    page.evaluate(LISTEN)
    joints: dict[int, dict[str, Array]] = {}
    for did in desk.script:
        _again(page, desk, did)
        if did.messages and isinstance(did.messages[0], do.AddKey):
            joints[did.messages[0].frame] = {n: _uv(page, n) for n in desk.clip.places}
    return Seen(Counter(page.evaluate("() => window.counted")), joints)


def _again(page: Page, desk: Desk, did: Did) -> None:
    """One act."""
    match did.messages:
        case (do.Go() as go,) if did.kind == "click":
            page.mouse.click(*_on_timeline(page, go.frame, desk.state.frame_count - 1))
            until_state(page, "view.frame", lambda frame: frame == go.frame)
        case (do.AddKey() as add,):
            page.keyboard.press("k")
            until_state(page, "keys.frames", lambda frames: add.frame in frames)
        case (do.Drag() as drag,):
            _drag(page, desk, drag)
        case _:
            raise NotImplementedError(did.why)
    answered(page)


def _drag(page: Page, desk: Desk, drag: do.Drag) -> None:
    """A handle from where the page shows it, by as many pixels of the video."""
    if not isinstance(drag.handle, Root | End | Middle):
        raise NotImplementedError(f"dragging a {drag.handle.kind}")
    name = "root" if isinstance(drag.handle, Root) else drag.handle.name
    anchor = handle_named(desk.state.doc.body, name).anchor
    start = spot(page, anchor)
    origin, one = (np.array(_on_screen(page, at)) for at in ((0.0, 0.0), (1.0, 1.0)))
    way = np.subtract(drag.at, drag.from_) * (one - origin)
    held = [key for key, on in (("d", drag.depth), ("Alt", drag.carry)) if on]
    for key in held:
        page.keyboard.down(key)
    _carry(page, start, (start[0] + way[0], start[1] + way[1]))
    for key in held:
        page.keyboard.up(key)
    until_state(page, "pose.stroke", lambda stroke: stroke is None)


def _carry(page: Page, start: Spot, end: Spot) -> None:
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(*end, steps=6)
    page.mouse.up()


def _on_screen(page: Page, at: Sequence[float]) -> Spot:
    """Where a pixel of the video is seen."""
    left, top = page.evaluate(
        """([x, y]) => {
          const view = window.keypose.view('main');
          const [a, b] = view.fromView([x, y]);
          const frame = view.el.getBoundingClientRect();
          return [frame.left + a, frame.top + b];
        }""",
        [float(at[0]), float(at[1])],
    )
    return left, top


def _on_timeline(page: Page, frame: int, last: int) -> Spot:
    box = page.locator("#tsvg").bounding_box()
    assert box is not None
    left, right = box["x"] + 138, box["x"] + box["width"] - 26
    return left + frame * (right - left) / last, box["y"] + 22 + 17


def _uv(page: Page, joint: str) -> Array:
    """(2,) pixels of the video where the page has a joint."""
    place: Any = section(page, "pose.points").get(joint)
    camera = section(page, "camera")
    x, y, z = place
    return np.array([camera["fx"] * x / z + camera["cx"], camera["fy"] * y / z + camera["cy"]])
