// A browser without a graphics card draws four views too slowly to play a film. Where pictures come
// late, the views that nobody looks at draw less often.

import { U, watch } from '../state.js';

const SLOW_MS = 24;
const REST_MS = 250;

let late = 0;
let last = 0;
let measuring = false;

export function mountPace() {
  watch(['u:playing', 'u:dragging'], () => {
    if (measuring || !isBusy()) return;
    measuring = true;
    last = 0;
    requestAnimationFrame(measure);
  });
}

/** Milliseconds a view in the background lets pass between two pictures. */
export function rest() {
  return measuring && late > SLOW_MS ? REST_MS : 0;
}

function isBusy() {
  return U.playing || U.dragging;
}

function measure(now) {
  if (last) late += 0.2 * (Math.min(now - last, 500) - late);
  last = now;
  measuring = isBusy();
  if (measuring) requestAnimationFrame(measure);
}
