"""Observed surfaces on the page: when they are looked at, and their pictures.

The playhead goes from frame to frame faster than meshes can be read and sent. So a surface is
looked at once the playhead rests, and now and then while it does not; what was wished meanwhile is
forgotten but for the newest.
"""

from __future__ import annotations

import asyncio
import traceback
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from keypose.app.document.open import OpenSession
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.render.video_frames import Frames
from keypose.app.scene.observed import Outdated, SurfaceViews, TintedSource, reading, skin
from keypose.app.state.app_state import AppState, SurfaceSeen
from keypose.app.store.sections import image_version
from keypose.tracker.errors import KeyposeError, SurfaceError
from keypose.tracker.surface.picture import SurfaceVideo
from keypose.tracker.video import Video

REST_S = 0.06
"""The playhead rests when it has stood for so long."""
SELDOM_S = 0.25
"""Between two looks while it does not."""
STALE_S = 0.8
"""The surface of another step is shown no longer than this with a body that has moved on."""
SETTLE_S = 0.15
"""Until a page has drawn a surface it was sent: then the one before goes."""


Found: TypeAlias = tuple[bytes | None, SurfaceSeen]
"""The skin of a surface, None where there is none to show, and what was seen."""


@dataclass(frozen=True, eq=False)
class WantedStep:
    """What was wished: a step as a document has it.  key: equal where it would look the same.

    at_s: when it was wished, by the loop's clock.
    """

    observed: SurfaceViews
    edit: EditorState
    key: tuple[Any, ...]
    at_s: float


class Surfaces:
    """All methods are for the loop's thread; what takes a while is done in one of its own.

    show:   draws a surface in the small views, None: nothing; `settle` some moments later.
    seen:   receives what was seen.  unusable: receives once which steps cannot be used, if any.
    """

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        show: Callable[[bytes | None], None],
        settle: Callable[[], None],
        seen: Callable[[SurfaceSeen], None],
        unusable: Callable[[str], None],
    ) -> None:
        self._loop, self._show, self._settle, self._seen = loop, show, settle, seen
        self._unusable = unusable
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="surfaces")
        self._opened: OpenSession | None = None
        self._observed: SurfaceViews | None = None
        self._wanted: WantedStep | None = None
        self._done: WantedStep | None = None
        self._stale: asyncio.TimerHandle | None = None
        self._later: asyncio.TimerHandle | None = None
        self._looked_at = 0.0
        self._busy = False
        self._known = SurfaceSeen()
        self._has_checked = False
        self._frames: tuple[tuple[Any, ...], Frames] | None = None

    def follow(self, opened: OpenSession | None, edit: EditorState | None) -> None:
        """The state may have changed."""
        if opened is not self._opened:
            self._turn_to(opened)
        if self._observed is None or edit is None:
            return
        self._observed.follow(edit.settled)
        key = _key(edit)
        if self._wanted is not None and self._wanted.key == key:
            return
        self._wanted = WantedStep(self._observed, edit, key, self._loop.time())
        self._plan()
        if self._stale is None:
            self._stale = self._loop.call_later(STALE_S, self._drop_stale)

    async def jpeg(self, index: int, app_state: AppState) -> bytes | None:
        """The picture of a step in the colours chosen; None where the session is of a video.

        VideoError where there is no such step, or the surfaces lie elsewhere meanwhile.
        """
        edit = app_state.edit
        if self._observed is None or edit is None:
            return None
        version = image_version(app_state)
        self._observed.follow(edit.settled)
        of = (version, *reading(edit.settled))
        if self._frames is None or self._frames[0] != of:
            self._leave_frames()
            self._frames = of, Frames(Video(TintedSource(self._observed, edit)))
        return await self._frames[1].jpeg(index, edit.doc.view.camera, version)

    async def video(self, edit: EditorState) -> SurfaceVideo | None:
        """The surfaces as the document has them read; None where the session is of a video."""
        if self._observed is None:
            return None
        self._observed.follow(edit.settled)
        return await asyncio.to_thread(self._observed.video, edit.settled)

    # --- looking

    def _turn_to(self, opened: OpenSession | None) -> None:
        if self._observed is not None:
            self._thread.submit(self._observed.close)
            self._show(None)
        self._leave_frames()
        has_surface = opened is not None and opened.session.evidence.has_surface
        self._opened, self._observed = (
            opened,
            SurfaceViews(opened) if has_surface and opened else None,
        )
        self._wanted, self._done, self._known = None, None, SurfaceSeen()
        self._has_checked = False

    def _plan(self) -> None:
        """Look once the playhead rests, or when it is long ago."""
        done_key = None if self._done is None else self._done.key
        if self._busy or self._wanted is None or self._wanted.key == done_key:
            return
        if self._later is not None:
            self._later.cancel()
        now = self._loop.time()
        wait = min(REST_S, max(0.0, self._looked_at + SELDOM_S - now))
        self._later = self._loop.call_later(wait, self._look)

    def _look(self) -> None:
        self._later = None
        wanted = self._wanted
        if wanted is None or self._busy:
            return
        self._busy, self._looked_at = True, self._loop.time()
        looking = self._loop.run_in_executor(self._thread, _sample, wanted, self._known)
        looking.add_done_callback(lambda done: self._on_sampled(wanted, done))

    def _on_sampled(self, wanted: WantedStep, done: asyncio.Future[Found | None]) -> None:
        self._busy = False
        if wanted.observed is self._observed and not done.cancelled():
            fault = done.exception()
            if fault is not None:  # of ours: what is wished next is looked at all the same
                traceback.print_exception(fault)
                self._done = wanted
                self._show(None)
            elif (sampled := done.result()) is not None:
                glb, self._known = sampled
                self._done = wanted
                self._show(glb)
                self._loop.call_later(SETTLE_S, self._settle)
                self._seen(self._known)
                self._check_all_steps(wanted.observed)
        self._plan()

    def _check_all_steps(self, observed: SurfaceViews) -> None:
        """Once, after something is to be seen: which other steps there will be nothing of."""
        if self._has_checked:
            return
        self._has_checked = True
        checking = self._loop.run_in_executor(None, observed.unusable)
        checking.add_done_callback(lambda done: self._on_all_checked(observed, done))

    def _on_all_checked(self, observed: SurfaceViews, done: asyncio.Future[str]) -> None:
        if observed is not self._observed or done.cancelled():
            return
        fault = done.exception()
        if fault is None:
            if words := done.result():
                self._unusable(words)
        elif not isinstance(fault, KeyposeError):  # of ours; those are reported when a step is met
            traceback.print_exception(fault)

    def _drop_stale(self) -> None:
        """Meshes that are slow to read come late: rather none than that of another step."""
        self._stale = None
        wanted, done = self._wanted, self._done
        if wanted is None or done is None or done.edit.frame == wanted.edit.frame:
            return
        left = done.at_s + STALE_S - self._loop.time()
        if left > 0:
            self._stale = self._loop.call_later(left, self._drop_stale)
        else:
            self._done = None
            self._show(None)

    # --- pictures

    def _leave_frames(self) -> None:
        if self._frames is not None:
            self._frames[1].close()
            self._frames = None


def _key(edit: EditorState) -> tuple[Any, ...]:
    """What a surface's looks depend on."""
    tint, doc = edit.display.tint, edit.settled
    key: tuple[Any, ...] = (*reading(doc), edit.frame, tint, doc.model_keyframe is None)
    if tint not in ("contact", "distance"):
        return key
    pose = shown_pose(edit).pose
    pose_key = (pose.Rs_parent_part.tobytes(), pose.p_camera_root.tobytes())
    return (*key, doc.subject.body, doc.model_keyframe, doc.view.surface, *pose_key)


def _sample(wanted: WantedStep, surface_seen: SurfaceSeen) -> Found | None:
    """The surface as it is sent to the small views, and what was seen of it; None where it lies
    elsewhere by now."""
    observed, edit, frame = wanted.observed, wanted.edit, wanted.edit.frame
    rims = None
    try:
        with suppress(SurfaceError):  # of the step whose surface moves
            rims = observed.rims(edit)
        surface = observed.layer(edit, frame)
        rated = observed.is_rated(edit, frame)
    except Outdated:
        return None
    except KeyposeError as error:
        return None, replace(surface_seen, frame=frame, problem=str(error), faces=0, rims=rims)
    low, high = surface.mesh.vertices.min(axis=0), surface.mesh.vertices.max(axis=0)
    x, y, z = (float(v) for v in (low + high) / 2)
    surface_shown = SurfaceSeen(frame, "", len(surface.mesh.faces), (x, y, z), rims, rated)
    return skin(surface.mesh, surface.colours), surface_shown
