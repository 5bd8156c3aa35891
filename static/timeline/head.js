// The playhead: the frame all tabs look at, and moving it. A drag shows its own frame at once; the
// server's answer takes over as soon as it has heard of the last move.

import { S, U, put } from '../state.js';
import { send } from '../link.js';
import { clampFrame } from './scale.js';
import { paced } from './pace.js';

/** Where this tab has sent the playhead: {frame, n}, n null until it is told. */
let wanted = null;

const tell = paced((frame) => {
  wanted = { frame, n: send({ do: 'go', frame }) };
});

/** The frame the playhead stands on. */
export function frame() {
  if (wanted !== null && wanted.n !== null && (S.ack ?? 0) >= wanted.n) wanted = null;
  return wanted === null ? clampFrame(S.view?.frame ?? 0) : wanted.frame;
}

/** Move the playhead; the server hears of it at most once per animation frame. */
export function goTo(target) {
  const next = clampFrame(target);
  if (next === frame()) return;
  wanted = { frame: next, n: null };
  put('timeHead', next);
  tell(next);
}

/** Move it and tell at once: an edit follows that means the new frame. */
export function goNow(target) {
  goTo(target);
  tell.flush();
}

/** Stop playing: whoever takes the playhead in hand wants it to stay. */
export function hold() {
  if (U.playing) put('playing', false);
}
