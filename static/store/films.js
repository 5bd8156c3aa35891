// The films besides the first, and which of them stands beside it.

import { server, ui } from './state.js';

/** @typedef {import('./shapes.js').Film} Film */

/** The films besides the first. @returns {Film[]} */
export const films = () => server.films ?? [];

/** The one that takes the other half of the views, or null. @returns {Film | null} */
export const largeFilm = () => films().find(({ id }) => id === ui.filmLarge) ?? null;
