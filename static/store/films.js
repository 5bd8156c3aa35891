// The films besides the first, and which of them stands beside it.

import { server, ui } from './state.js';

/** @typedef {import('./shapes.js').Film} Film */

/** The films besides the first, as they are shown: one whose picture is held shows that. @returns {Film[]} */
export function films() {
  const { films: all = [] } = server;
  const { filmHeld: held } = ui;
  return held ? all.map((film) => (film.id === held.id ? { ...film, frame: held.frame } : film)) : all;
}

/** The one that takes the other half of the views, or null. @returns {Film | null} */
export const largeFilm = () => films().find(({ id }) => id === ui.filmLarge) ?? null;
