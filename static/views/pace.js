// A browser without a graphics card draws four views too slowly to follow a hand. Where pictures
// come late, the view that is looked at draws first, and the others less often.

import { ui, watch } from '../store/state.js';

const SLOW_MS = 24;
const REST_MS = 250;
const SETTLED_MS = 120;
/** A step to another frame is measured so long. */
const STEP_MS = 400;

let late = 0;
let last = 0;
let measuring = false;
let stepped = -Infinity;

export function mountPace() {
  watch(['u:playing', 'u:dragging'], begin);
  watch(['view'], () => {
    stepped = performance.now();
    begin();
  });
}

/**
 * When a view draws, in milliseconds: how long it rests between two pictures, how far it stays
 * behind what asks for one, how long after the last wish it draws once more, and whether it draws
 * only once what came at once.
 */
export function pace(isLookedAt) {
  const settled = Math.max(SETTLED_MS, 4 * late);
  const once = late > SLOW_MS;
  const waits = once && !isLookedAt;
  return { rest: waits ? REST_MS : 0, behind: waits ? 2 * late : 0, settled, once };
}

function begin() {
  if (measuring || !isBusy()) return;
  measuring = true;
  last = 0;
  requestAnimationFrame(measure);
}

function isBusy() {
  return ui.playing || ui.dragging || performance.now() - stepped < STEP_MS;
}

function measure(now) {
  if (last) late += 0.2 * (Math.min(now - last, 500) - late);
  last = now;
  measuring = isBusy();
  if (measuring) requestAnimationFrame(measure);
}
