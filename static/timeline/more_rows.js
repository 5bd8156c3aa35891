// The rows of pins, of the camera, and of other bodies and films come and go.

import { motion } from '../actions/camera.js';
import { allPins, proposedPins } from '../actions/pins.js';
import { server } from '../store/state.js';
import { bodiesHeight } from './marks/bodies.js';
import { filmsHeight } from './marks/films.js';

/** Whether there is anything to give the row of pins to. */
export const hasPins = () => allPins().length + proposedPins().length > 0;

/** Whether the camera's motion has a row. */
export const hasCamera = () => motion() !== null;

/** The timeline gets its row with the first pin or proposal, with the camera's motion, and with every other
 * body and film, once, and never under a pressed pointer. */
export function followRows() {
  const { dataset, style } = document.documentElement;
  const wanted = { pins: wants(hasPins()), camera: wants(hasCamera()) };
  const more = `${server.file ? bodiesHeight() + filmsHeight() : 0}px`;
  const isSame = dataset.pins === wanted.pins && dataset.camera === wanted.camera;
  if (isSame && style.getPropertyValue(MORE) === more) return;
  if (isPointerDown) {
    onRelease = followRows;
    return;
  }
  Object.assign(dataset, wanted);
  style.setProperty(MORE, more);
}

/** What the rows of bodies and films add to the timeline's height. */
const MORE = '--h-more';

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
