// What the pointer drags or hovers on the timeline, so that the drawing can show it.

import { ui, setUi } from '../../store/state.js';

ui.timeGrabbed = null;
ui.timeHover = null;

/**
 * null | {kind: "scrub"} | {kind: "pan"}
 * | {kind: "key", from, to, copy, taken, refused} | {kind: "angle", frame, axis, from, deg}
 * | {kind: "note", from, to, taken}
 * | {kind: "box", from, to} | {kind: "keys", frames, to, held, end: "first" | "last" | null, copy, taken, refused}
 * | {kind: "span", end: "first" | "last"} | {kind: "pin", index, end: "first" | "last" | "middle", from: {first, last}}
 */
export function grabbed() {
  return ui.timeGrabbed;
}

export function setGrabbed(what) {
  setUi('timeGrabbed', what);
}

/** null | {kind: "key", frame} | {kind: "note", frame} | {kind: "grip", end} | {kind: "segment", first, last}
 * | {kind: "curvekey", frame} | {kind: "place", frame}
 * | {kind: "box", from, to} | {kind: "keys", frames, to, held, end: "first" | "last" | null, copy, taken, refused}
 * | {kind: "pin", index, end} | {kind: "proposal", part, first} */
export function hovered() {
  return ui.timeHover;
}

export function setHovered(what) {
  if (JSON.stringify(what) !== JSON.stringify(ui.timeHover)) setUi('timeHover', what);
}
