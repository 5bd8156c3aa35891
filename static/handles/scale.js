// How big things are drawn: full size in a large view, smaller in a small one.

import { ui } from '../store/state.js';
import { ALL_VIEWS } from '../views/views.js';

const SMALL_UNDER = 260;

/** The view in the large place; with four equal views the camera's. */
export function largeView() {
  return ALL_VIEWS.includes(ui.layout) ? ui.layout : 'main';
}

/** Whether handles and rings get their full size in this view: asked for each of them, so nothing is measured. */
export function isLarge(view) {
  return Math.min(view.window.width, view.window.height) >= SMALL_UNDER;
}

/** Radius of the rotation rings, pixels. */
export const ringRadius = (view) => (isLarge(view) ? 56 : 26);

/** Factor for grab handles. */
export const gripScale = (view) => (isLarge(view) ? 1 : 0.7);
