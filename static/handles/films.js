// The other films of the motion, as cards in the lower left corner of the large view: the picture with
// the body over it, and the film's clock; and the bars over the one that stands beside it.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { perform, titleOf } from '../actions/actions.js';
import { actionButton, actionIcon } from '../actions/buttons.js';
import { filmEntries } from '../actions/context_menus.js';
import { clockMessage, FINE, heldFrame, signed } from '../actions/films.js';
import { iconButton, numberField } from '../controls/fields.js';
import { openMenuAt } from '../controls/menu.js';
import { films, largeFilm } from '../store/films.js';
import { watch } from '../store/state.js';
import { FilmPicture } from '../views/film_picture.js';
import { view as viewNamed } from '../views/views.js';
import { isFine } from './drag.js';

/** @typedef {import('../store/shapes.js').Film} Film */

/** More are shown smaller. */
const FEW = 2;
/** What is said as ±, and the least that is. */
const SIGMAS = 2;
const LEAST_SAID = 0.05;

/** @type {Map<string, FilmPicture>} */
const pictures = new Map();
const bars = document.createElement('div');
let redraw = () => {};

/** @param {() => void} draw  Draws the bars anew. */
export function mountFilms(draw) {
  redraw = draw;
  bars.className = 'bars';
  viewNamed('film').el.append(bars);
  viewNamed('film').told = draw;
  watch(['films', 'pose', 'solids', 'body', 'view', 'u:filmLarge', 'u:filmHeld', 'u:sight'], follow);
}

/** Those that are shown as cards. */
const inCards = () => films().filter(({ id }) => id !== largeFilm()?.id);

function follow() {
  const there = new Set(inCards().map(({ id }) => id));
  for (const [id, picture] of pictures) {
    if (there.has(id)) continue;
    picture.close();
    pictures.delete(id);
  }
  for (const film of inCards()) pictureOf(film).follow(film);
}

/** @param {Film} film */
function pictureOf({ id }) {
  let picture = pictures.get(id);
  if (!picture) pictures.set(id, (picture = new FilmPicture(redraw)));
  return picture;
}

export function filmCards() {
  const cards = inCards();
  if (!cards.length) return nothing;
  return html`<div class="films ${cards.length > FEW ? 'many' : ''}">${cards.map(card)}</div>`;
}

/** Draw the bars over the film that stands beside the large view. */
export function drawFilmBars() {
  const film = largeFilm();
  render(film ? filmBars(film) : nothing, bars);
}

/** @param {Film} film */
function filmBars(film) {
  const { id, name, words } = film;
  return html`<div class="glass row" id="fhead" data-film=${id}>
      <span class="cut b" title=${words}>${name}</span>${more(film, '#fhead .ib')}
      <span class="vsep"></span>${actionIcon('enlargeFilm', film)}</div>
    <div class="glass row filmclock" id="fclock">${
      heldFrame(film) === null ? [clock(film), actionIcon('holdFilm', film)] : holding(film)
    }</div>
    ${lacking(film, viewNamed('film').why)}`;
}

/** @param {Film} film */
function card(film) {
  const { id, name, words, camera } = film;
  const picture = pictureOf(film);
  return html`<section class="glass filmcard" data-film=${id} aria-label="Film ${name}"
    style="--shape:${camera.width / camera.height}">
    <div class="row filmhead"><span class="cut b" title=${words}>${name}</span><span
      class="sp"></span>${more(film, `[data-film="${id}"] .filmhead .ib`)}</div>
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
  })}${off(sigma)}${step('filmLater')}${sigma === null ? actionIcon('placeFilm', film) : nothing}${also(film)}`;
}

/** Its picture waits for the frame of the first film that shows the same moment. @param {Film} film */
function holding(film) {
  const align = actionButton('alignFilm', film, { kind: 'pri' });
  const letGo = actionIcon('holdFilm', film, { name: 'x' });
  return html`<span class="dim num">${film.frame} held</span>${align}${letGo}`;
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

/** @param {Film} film @param {string} place  Of the button, a selector. */
function more(film, place) {
  const act = () => {
    const { left, bottom } = document.querySelector(place).getBoundingClientRect();
    openMenuAt(`Menu of ${film.name}`, filmEntries(film), [left, bottom]);
  };
  return iconButton({ name: 'more', label: `Menu of ${film.name}`, act });
}
