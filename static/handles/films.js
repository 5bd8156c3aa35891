// The other films of the motion, as cards in the lower left corner of the large view: the picture with
// the body over it, and the film's clock.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { perform, titleOf } from '../actions/actions.js';
import { actionIcon, menuItem } from '../actions/buttons.js';
import { clockMessage, films, FINE, signed } from '../actions/films.js';
import { iconButton, numberField } from '../controls/fields.js';
import { line, openMenuAt } from '../controls/menu.js';
import { ui, watch } from '../store/state.js';
import { FilmPicture } from '../views/film_picture.js';
import { isFine } from './drag.js';

/** @typedef {import('../store/shapes.js').Film} Film */

/** More are shown smaller. */
const FEW = 2;
/** What is said as ±, and the least that is. */
const SIGMAS = 2;
const LEAST_SAID = 0.05;

/** @type {Map<string, FilmPicture>} */
const pictures = new Map();
let redraw = () => {};

/** @param {() => void} draw  Draws the bars anew. */
export function mountFilms(draw) {
  redraw = draw;
  watch(['films', 'pose', 'solids', 'body', 'view', 'u:filmLarge'], follow);
}

function follow() {
  const there = new Set(films().map(({ id }) => id));
  for (const [id, picture] of pictures) {
    if (there.has(id)) continue;
    picture.close();
    pictures.delete(id);
  }
  for (const film of films()) pictureOf(film).follow(film);
}

/** @param {Film} film */
function pictureOf({ id }) {
  let picture = pictures.get(id);
  if (!picture) pictures.set(id, (picture = new FilmPicture(redraw)));
  return picture;
}

export function filmCards() {
  if (!films().length) return nothing;
  return html`<div class="films ${films().length > FEW ? 'many' : ''}">${films().map(card)}</div>`;
}

/** @param {Film} film */
function card(film) {
  const { id, name, words, camera } = film;
  const picture = pictureOf(film);
  const isLarge = ui.filmLarge === id;
  return html`<section class="glass filmcard ${isLarge ? 'large' : ''}" data-film=${id} aria-label="Film ${name}"
    style="--shape:${camera.width / camera.height}">
    <div class="row filmhead"><span class="cut b" title=${words}>${name}</span><span
      class="sp"></span>${more(film)}</div>
    <div class="filmpic" title=${titleOf('enlargeFilm', film)} @click=${() => perform('enlargeFilm', film)}>
      <div class="filmboth">${picture.picture}${picture.figure}</div>${lacking(film, picture.why)}</div>
    <div class="row filmclock">${clock(film)}</div>
  </section>`;
}

/** Why no picture is there. @param {Film} film */
function lacking({ frame }, why) {
  const words = frame === null ? 'This film does not show this moment.' : why;
  return words ? html`<div class="lacking" role="status">${words}</div>` : nothing;
}

/** When it begins, and how to move that. @param {Film} film */
function clock(film) {
  const { id, name, begins, sigma } = film;
  const step = (action) =>
    actionIcon(action, film, { act: () => perform(action, { ...film, step: isFine() ? FINE : 1 }) });
  return html`${step('filmEarlier')}<span class="dim">begins</span>${numberField({
    key: `film ${id}`,
    label: `Frame at which ${name} begins`,
    value: begins,
    step: 1,
    decimals: 1,
    edit: (value) => clockMessage(film, value),
  })}${off(sigma)}${step('filmLater')}${also(film)}`;
}

/** What is said as ±. @param {number | null} sigma */
function off(sigma) {
  if (sigma === null) return nothing;
  return html`<span class="mut num">± ${Math.max(SIGMAS * sigma, LEAST_SAID).toFixed(1)}</span>`;
}

/** Where it may begin as well. @param {Film} film */
function also(film) {
  return film.also.map(
    (at) => html`<button class="chip old num" title=${titleOf('filmBegins')}
      @click=${() => perform('filmBegins', { ...film, at })}>${signed(at)}?</button>`,
  );
}

/** @param {Film} film */
function more(film) {
  const act = () => {
    const { left, bottom } = document.querySelector(`[data-film="${film.id}"] .filmhead .ib`).getBoundingClientRect();
    openMenuAt(
      `Menu of ${film.name}`,
      [
        menuItem('enlargeFilm', film),
        ...film.also.map((at) => menuItem('filmBegins', { ...film, at })),
        menuItem('placeFilm', film),
        line,
        menuItem('addFilm'),
        menuItem('removeFilm', film),
      ],
      [left, bottom],
    );
  };
  return iconButton({ name: 'more', label: `Menu of ${film.name}`, act });
}
