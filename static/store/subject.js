// What the session is about. Of a film motion is tracked; to observed surfaces it is fitted.

import { server } from './state.js';

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
  isSurface() ? 'Add a keyframe first' : `Add ${server.keys?.frames.length ? 'a second keyframe' : 'two keyframes'} first`;
