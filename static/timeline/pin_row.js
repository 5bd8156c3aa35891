// The row of pins comes and goes.

import { allPins, proposedPins } from '../actions/pins.js';
import { server } from '../store/state.js';

/** Whether there is anything to give a row to. */
export const hasPins = () => allPins().length + proposedPins().length > 0;

/** The timeline gets its row with the first pin or proposal, once, and never under a pressed pointer. */
export function followPins() {
  const { dataset } = document.documentElement;
  const wanted = hasPins() && server.file ? 'yes' : 'no';
  if (dataset.pins === wanted) return;
  if (isPointerDown) onRelease = followPins;
  else dataset.pins = wanted;
}

let isPointerDown = false;
/** @type {() => void} */
let onRelease = () => {};

export function watchPointer() {
  addEventListener('pointerdown', () => (isPointerDown = true), true);
  const up = () => {
    isPointerDown = false;
    onRelease();
    onRelease = () => {};
  };
  for (const kind of ['pointerup', 'pointercancel']) addEventListener(kind, up, true);
}
