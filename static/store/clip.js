// What the session is about, how long the film is, which frames exist and which are damaged. Of a film
// motion is tracked; to observed surfaces it is fitted.

import { server, ui } from './state.js';

const FILM = { verb: 'Track', doing: 'Tracking', done: 'tracked', what: 'picture', image: 'image', one: 'frame' };
const SURFACES = { verb: 'Fit', doing: 'Fitting', done: 'fitted', what: 'surface', image: 'surface', one: 'step' };

/** Whether there are surfaces instead of a film. */
export const isSurface = () => Boolean(server.surface);

/** The words that go with it. */
export const words = () => (isSurface() ? SURFACES : FILM);

/** How many keyframes there must be: surfaces can be followed from one alone. */
export const fewestKeys = () => (isSurface() ? 1 : 2);

/** Why nothing can be tracked or fitted yet. */
export const tooFewWords = () =>
  isSurface()
    ? 'Add a keyframe first'
    : `Add ${server.keys?.frames.length ? 'a second keyframe' : 'two keyframes'} first`;

export function frameCount() {
  return server.file?.frames ?? 0;
}

export function lastFrame() {
  return Math.max(0, frameCount() - 1);
}

/**
 * First and last frame between the in and the out point, where one of them is set; else null.
 * @returns {[number, number] | null}
 */
export function chosenFrames() {
  const { first, last } = ui.span;
  return first === null && last === null ? null : [first ?? 0, last ?? lastFrame()];
}

export function clampFrame(frame) {
  return Math.min(lastFrame(), Math.max(0, Math.round(frame)));
}

/** [first, last] of the run of damaged frames that a frame lies in, or null. */
export function damageAt(frame) {
  return (server.damage ?? []).find(([first, last]) => first <= frame && frame <= last) ?? null;
}

/** How many frames are damaged. */
export function damagedFrames() {
  return (server.damage ?? []).reduce((sum, [first, last]) => sum + last - first + 1, 0);
}

export function damageWords(first, last) {
  return first === last
    ? `Frame ${first} is damaged in the file and is not used for tracking.`
    : `Frames ${first}–${last} are damaged in the file and are not used for tracking.`;
}
