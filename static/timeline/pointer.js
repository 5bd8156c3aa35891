// What the pointer drags or is over on the timeline: {kind, ...}, the kind being that of a mark.

import { ui, setUi } from '../store/state.js';

ui.timeGrabbed = null;
ui.timeHover = null;

export const grabbed = () => ui.timeGrabbed;
export const hovered = () => ui.timeHover;

/** What is dragged, if it is of this kind; else null. */
export const held = (kind) => (ui.timeGrabbed?.kind === kind ? ui.timeGrabbed : null);

export const setGrabbed = (what) => setUi('timeGrabbed', what);

export function setHovered(what) {
  if (JSON.stringify(what) !== JSON.stringify(ui.timeHover)) setUi('timeHover', what);
}

const NONE = [];

/** The frames of the keyframes that are on their way: where they were they are not drawn. */
export const onTheWay = () => (ui.timeGrabbed?.frames && !ui.timeGrabbed.copy ? ui.timeGrabbed.frames : NONE);

const SHAKE_MS = 240;

/** Onto another key: what was dragged shakes and goes back. */
export function putBack(what) {
  const shaking = { ...what, refused: true };
  setGrabbed(shaking);
  setTimeout(() => grabbed() === shaking && setGrabbed(null), SHAKE_MS);
}
