// The playhead: the frame all tabs look at, and moving it. It shows its own frame at once; the
// server's answer takes over as soon as it has heard of the last move.

import { server, ui, setUi } from '../../store/state.js';
import { send } from '../../store/link.js';
import { clampFrame } from '../draw/scale.js';
import { paced } from '../../controls/gesture.js';

/** Where this tab has sent the playhead: {frame, n}, n null until it is told. */
let wanted = null;
let stopping = false;

const tellSoon = paced(tell);

function tell(target) {
  wanted = { frame: target, n: send({ do: 'go', frame: target }) };
}

/** The frame the playhead stands on. */
export function frame() {
  if (wanted !== null && wanted.n !== null && (server.done ?? 0) >= wanted.n) wanted = null;
  return wanted === null ? clampFrame(server.view?.frame ?? 0) : wanted.frame;
}

/** Move the playhead. The server hears of it before any edit that follows. */
export function goTo(target) {
  glideTo(target);
  if (!stopping) tellSoon.flush();
}

/** Move it as part of a drag: the server hears of it once per animation frame, newest wins. */
export function glideTo(target) {
  const next = clampFrame(target);
  if (next === frame()) return;
  wanted = { frame: next, n: null };
  setUi('timeHead', next);
  tellSoon(next);
}

/** A drag has ended: tell where. */
export function settle() {
  tellSoon.flush();
}

/** Stop playing: whoever takes the playhead in hand wants it to stay. */
export function hold() {
  if (!ui.playing) return;
  setUi('playing', false);
  // Playing ends with the next animation frame, and tells where it ended: a move comes after that.
  stopping = true;
  requestAnimationFrame(() => (stopping = false));
}
