// The other films of the motion: which one is meant, and when each was taken.

import { openChooser } from '../controls/dialogs.js';
import { isSurface } from '../store/clip.js';
import { films, largeFilm } from '../store/films.js';
import { server, setUi, ui } from '../store/state.js';
import { showLarge } from '../views/views.js';

/** @typedef {import('../store/shapes.js').Film} Film */

/** Decimals of the frame at which a film begins. */
const DIGITS = 4;
/** A clock is moved by so much of a frame while Shift is down. */
export const FINE = 0.1;

/** The one that is meant where none is named: the enlarged one, else the first of them. */
export const filmMeant = () => largeFilm() ?? films()[0];

/** Why no clock of a film can be moved, and none removed. */
export const whyNoFilm = (film = filmMeant()) => (film ? '' : 'There is no other film');

export function whyNotAddFilm() {
  if (isSurface()) return 'Surfaces take no film beside them';
  if (!server.file) return 'Open a video first';
  if (!server.body?.is_persons) return 'A film is added to a person’s motion';
  if (isAddingFilm()) return 'A film is being added';
  return server.keys?.frames.length || server.keys?.drafts.length ? '' : 'Draft this film first, or pose a keyframe';
}

export const isAddingFilm = () => server.job?.state === 'running' && server.job.kind === 'film';

export const chooseFilm = () => openChooser('film');

/** A film's clock moved so that it begins at a frame of the first. */
export const clockMessage = (film, begins) => ({
  do: 'film_clock',
  view: film?.id,
  begins: Number(Number(begins).toFixed(DIGITS)),
});

/** Its camera found for a frame of the first at which it begins. */
export const placeMessage = (film, begins) => ({ ...clockMessage(film, begins), do: 'place_film' });

/** Why no camera of a film can be found. */
export const whyNotPlace = (film = filmMeant()) =>
  whyNoFilm(film) || (isAddingFilm() ? 'A film’s camera is being found' : '');

/**
 * Moved by so many steps.
 * @param {number} steps
 * @param {Film & { step?: number }} film  step: frames, where that is not one.
 */
export function clockBy(steps, film = filmMeant()) {
  return clockMessage(film, (film?.begins ?? 0) + steps * (film?.step ?? 1));
}

/** The picture of a film that is held while the playhead goes on, as its frame; or null. @param {Film} film */
export const heldFrame = (film) => (ui.filmHeld && ui.filmHeld.id === film?.id ? ui.filmHeld.frame : null);

/** Its picture stays, until it is aligned with the present frame or let go. @param {Film} film */
export function holdFilm(film = filmMeant()) {
  const { id, frame } = film;
  setUi('filmHeld', heldFrame(film) === null && frame !== null ? { id, frame } : null);
}

/** Its clock moved so that the picture that is held was taken at the present frame. @param {Film} film */
export function alignMessage(film = filmMeant()) {
  const begins = (server.view?.frame ?? 0) - (heldFrame(film) ?? 0) / (film?.rate ?? 1);
  setUi('filmHeld', null);
  return clockMessage(film, begins);
}

/** Why it cannot be aligned. @param {Film} film */
export const whyNotAlign = (film = filmMeant()) =>
  whyNoFilm(film) || (heldFrame(film) === null ? 'Hold its picture first' : '');

/** "+3.4" */
export const signed = (frames) => `${frames < 0 ? '−' : '+'}${Math.abs(frames).toFixed(1)}`;

/** The film stands beside the large view, in the place of the small ones, or in its corner again. */
export function enlargeFilm(film = filmMeant()) {
  const isLarge = film.id === largeFilm()?.id;
  if (!isLarge && ui.layout === 'quad') showLarge('quad');
  setUi('filmLarge', isLarge ? null : film.id);
}

/** Each of them in turn, and then none: for a key. */
export function nextFilm() {
  const at = films().findIndex(({ id }) => id === largeFilm()?.id);
  enlargeFilm(films()[at + 1] ?? films()[at]);
}
