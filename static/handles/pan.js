// Panning and zooming a view: wheel, middle button, Space-drag, the pan tool, two fingers.

import { clamp } from '../controls/arithmetic.js';
import { setUi } from '../store/state.js';
import { interaction, redrawSoon } from './interaction.js';
import { distance } from './space.js';

const PER_NOTCH = 0.0015;
const PER_PINCH = 0.01;
const LINE_PX = 33;

/** The wheel zooms at the pointer. */
export function wheel(view, event, x, y) {
  event.preventDefault();
  if (interaction.drag) return;
  const px = event.deltaY * (event.deltaMode === 1 ? LINE_PX : 1);
  // A pinch on a trackpad comes as a wheel with Ctrl and small steps.
  const rate = event.ctrlKey && Math.abs(px) < 50 ? PER_PINCH : PER_NOTCH;
  view.zoomAt(x, y, Math.exp(-clamp(px, -240, 240) * rate));
}

/** Begin to pan the view. */
export function beginPan(view, x, y) {
  interaction.panning = { view: view.name, x, y };
  setUi('dragging', true);
  redrawSoon();
}

export function movePan(view, x, y) {
  const { panning } = interaction;
  view.panBy(x - panning.x, y - panning.y);
  Object.assign(panning, { x, y, moved: true });
}

export function endPan() {
  interaction.panning = null;
  setUi('dragging', false);
  redrawSoon();
}

/** Two fingers: what lies between them stays between them. */
export function pinch(view, before, after) {
  const middle = (pair) => [0, 1].map((i) => (pair[0][i] + pair[1][i]) / 2);
  const [was, is] = [middle(before), middle(after)];
  view.panBy(is[0] - was[0], is[1] - was[1]);
  const spread = distance(...before);
  if (spread > 10) view.zoomAt(is[0], is[1], distance(...after) / spread);
}
