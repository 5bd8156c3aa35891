"""When things happen in the page, by its own clock: told by the server, drawn, shown."""

from __future__ import annotations

from typing import Any

from playwright.sync_api import Page

_SETUP = """
async () => {
  const { listen } = await window.keypose.module('store/link.js');
  const { server } = window.keypose;
  const frames = [...document.querySelectorAll('iframe.viser')];
  const role = (frame) => frame.closest('.view').dataset.view;
  let armed = null;

  // Counted is the animation frame after a thing was drawn: only then it can be seen.
  const mark = (name) => {
    if (!armed || armed.begun === null || armed.asked.has(name)) return;
    armed.asked.add(name);
    const mine = armed;
    requestAnimationFrame(() => {
      mine.marks[name] = performance.now() - mine.begun;
      if (mine.needed.every((each) => each in mine.marks)) mine.resolve(mine.marks);
    });
  };
  const told = (name) => {
    if (armed && armed.begun !== null) armed.marks[name] ??= performance.now() - armed.begun;
  };
  const begin = (event) => {
    if (armed && armed.begun === null && event.type === armed.kind) armed.begun = event.timeStamp;
  };
  for (const kind of ['pointermove', 'pointerup', 'keydown']) addEventListener(kind, begin, true);

  // A preview tells nothing before its segment is done.
  const isAtWork = ({ state }) => state === 'waiting' || state === 'tracking';
  let atWork = new Set();
  listen('state', ({ set }) => {
    if ('pose' in set) told('told');
    const segments = set.segments ?? [];
    const passed = segments.some((s) => (
      isAtWork(s) ? s.pass >= 1 : atWork.has(`${s.first} ${s.last}`)
    ));
    if (set.segments) atWork = new Set(
      segments.filter(isAtWork).map(({ first, last }) => `${first} ${last}`),
    );
    if (passed) { told('pass'); mark('pass seen'); }
  });

  const shows = (frame) => {
    const nodes = frame.contentWindow.__viserMutable.nodeRefFromName;
    return server.body.parts.every(({ name }, i) => {
      const [T, at] = [server.pose.T[name], nodes[`/camera/body/${i}`]?.position];
      return at && Math.abs(at.x - T[3]) + Math.abs(at.y - T[7]) + Math.abs(at.z - T[11]) < 1e-4;
    });
  };
  for (const frame of frames) {
    const scene = frame.contentWindow?.__viserMutable?.scene;
    if (scene) scene.onAfterRender = () => {
      if (armed && armed.gate in armed.marks && shows(frame)) mark(role(frame));
    };
  }
  // The camera view's body is painted by the page where 3D is software.
  new MutationObserver(() => {
    if (armed && armed.gate in armed.marks) mark('main');
  }).observe(document.querySelector('#main canvas.figure'), { attributeFilter: ['data-frame'] });
  // The dots of the trail lie in the page; its line, in the views, is drawn with the body.
  new MutationObserver((records) => {
    if (records.some(({ target }) => target.closest?.('g.trail'))) mark('trail');
  }).observe(document.querySelector('#main'), {
    attributeFilter: ['cx', 'd'], childList: true, subtree: true,
  });

  const film = document.querySelector('#main canvas.vid');
  new MutationObserver(() => mark('film')).observe(film, { attributeFilter: ['data-frame'] });

  window.bench = {
    arm(kind, needed, gate) {
      armed = { kind, needed, gate, begun: null, marks: {}, asked: new Set() };
      armed.done = new Promise((resolve) => (armed.resolve = resolve));
    },
    peek: () => armed && { begun: armed.begun, marks: armed.marks },
    done: () => Promise.race([
      armed.done, new Promise((resolve) => setTimeout(resolve, 4000, null)),
    ]),
  };
}
"""

_PLAYED = """
() => new Promise((done) => {
  const film = document.querySelector('#main canvas.vid');
  const times = [];
  const observer = new MutationObserver(() => times.push(performance.now()));
  observer.observe(film, { attributeFilter: ['data-frame'] });
  const look = () => {
    if (times.length && !window.keypose.ui.playing) {
      observer.disconnect();
      done(times);
    } else requestAnimationFrame(look);
  };
  look();
})
"""


class Probe:
    """Milliseconds from an event in the page to what it leads to.

    Marks: "told" the server's answer is here; "main", "top", "side", "front" the view shows it;
    "trail" the dots of the motion are drawn anew; "film" the picture of the video is shown; "pass"
    a tracking pass has come, "pass seen" is drawn.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        page.evaluate(_SETUP)

    def arm(self, kind: str, *needed: str, gate: str = "told") -> None:
        """From the next event of this kind on; views count what they draw after the gate."""
        self._page.evaluate("([k, n, g]) => window.bench.arm(k, n, g)", [kind, needed, gate])

    def marks(self) -> dict[str, float] | None:
        """Wait for all that is needed; None when it does not come."""
        found: Any = self._page.evaluate("() => window.bench.done()")
        return found

    def played(self) -> list[float]:
        """When pictures were shown, milliseconds, until the film has ended."""
        times: list[float] = self._page.evaluate(_PLAYED)
        return times
