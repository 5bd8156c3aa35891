// Panning, zooming and orbiting a view: wheel, middle button, Space-drag, the pan tool, two fingers;
// in the free view also the right button, and Alt with the left one.

import { clamp } from '../controls/arithmetic.js';
import { setUi } from '../store/state.js';
import { interaction, redrawSoon } from './interaction.js';
import { distance } from './space.js';

const PER_NOTCH = 0.0015;
const PER_PINCH = 0.01;
const LINE_PX = 33;

/** What turns a wheel by one notch, in the unit of old that every browser still reports. */
const NOTCH = 120;
const SAME_GESTURE_MS = 200;
let fingers = { at: -Infinity, isTwo: false };

/** The wheel zooms at the pointer; in the free view two fingers on a trackpad orbit. */
export function wheel(view, event, x, y) {
  event.preventDefault();
  if (interaction.drag) return;
  if (view.orbitBy && !event.ctrlKey && isTwoFingers(event)) {
    view.orbitBy(-event.deltaX, -event.deltaY);
    return;
  }
  const px = event.deltaY * (event.deltaMode === 1 ? LINE_PX : 1);
  // A pinch on a trackpad comes as a wheel with Ctrl and small steps.
  const rate = event.ctrlKey && Math.abs(px) < 50 ? PER_PINCH : PER_NOTCH;
  view.zoomAt(x, y, Math.exp(-clamp(px, -240, 240) * rate));
}

/** A trackpad sends many small steps in both directions, a wheel whole notches in one. */
function isTwoFingers(event) {
  const { timeStamp: now, deltaX, deltaMode, wheelDeltaY = NOTCH } = event;
  const isNotch = deltaMode !== 0 || (deltaX === 0 && Math.abs(wheelDeltaY) % NOTCH === 0);
  const isTwo = now - fingers.at < SAME_GESTURE_MS ? fingers.isTwo : !isNotch;
  fingers = { at: now, isTwo };
  return isTwo;
}

/** Begin to pan the view, or to orbit. */
export function beginPan(view, x, y, isOrbit = false) {
  interaction.panning = { view: view.name, x, y, isOrbit };
  setUi('dragging', true);
  redrawSoon();
}

export function movePan(view, x, y) {
  const { panning } = interaction;
  if (panning.isOrbit) view.orbitBy(x - panning.x, y - panning.y);
  else view.panBy(x - panning.x, y - panning.y);
  Object.assign(panning, { x, y, moved: true });
}

export function endPan() {
  interaction.panning = null;
  setUi('dragging', false);
  redrawSoon();
}

/** Two fingers: what lies between them stays between them; in the free view they orbit. */
export function pinch(view, before, after) {
  const middle = (pair) => [0, 1].map((i) => (pair[0][i] + pair[1][i]) / 2);
  const [was, is] = [middle(before), middle(after)];
  if (view.orbitBy) view.orbitBy(is[0] - was[0], is[1] - was[1]);
  else view.panBy(is[0] - was[0], is[1] - was[1]);
  const spread = distance(...before);
  if (spread > 10) view.zoomAt(is[0], is[1], distance(...after) / spread);
}
