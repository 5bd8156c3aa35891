// The rows of pins and of the camera come and go.

import { motion } from '../actions/camera.js';
import { allPins, proposedPins } from '../actions/pins.js';
import { server } from '../store/state.js';

/** Whether there is anything to give the row of pins to. */
export const hasPins = () => allPins().length + proposedPins().length > 0;

/** Whether the camera's motion has a row. */
export const hasCamera = () => motion() !== null;

/** The timeline gets its row with the first pin or proposal, and with the camera's motion, once, and never
 * under a pressed pointer. */
export function followRows() {
  const { dataset } = document.documentElement;
  const wanted = { pins: wants(hasPins()), camera: wants(hasCamera()) };
  if (dataset.pins === wanted.pins && dataset.camera === wanted.camera) return;
  if (isPointerDown) onRelease = followRows;
  else Object.assign(dataset, wanted);
}

const wants = (has) => (has && server.file ? 'yes' : 'no');

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
