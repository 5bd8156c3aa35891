// What the pointer holds or hovers on the timeline, so that the drawing can show it.

import { U, put } from '../../store/state.js';

U.timeHeld = null;
U.timeHover = null;

/**
 * null | {kind: "scrub"} | {kind: "pan"}
 * | {kind: "key", from, to, copy, taken, refused} | {kind: "angle", frame, axis, from, deg}
 */
export function held() {
  return U.timeHeld;
}

export function hold(what) {
  put('timeHeld', what);
}

/** null | {kind: "key", frame} | {kind: "segment", first, last} | {kind: "curvekey", frame} */
export function hovered() {
  return U.timeHover;
}

export function hover(what) {
  if (JSON.stringify(what) !== JSON.stringify(U.timeHover)) put('timeHover', what);
}
