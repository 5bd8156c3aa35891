// What the last fit did, on a card in the corner of the large view that is farthest from the body:
// its words, what was before as long as a button is held, and Undo. The next edit takes it away.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server, ui, watch } from '../store/state.js';
import { onViews } from '../views/views.js';
import { onHold } from '../handles/hold.js';
import { isDragCoveredBy } from '../handles/covered_by.js';
import { cornerFor } from '../guide/places.js';
import { count } from '../controls/words.js';

let corner = null; // where the card stands
let placed = null; // what it told then
let held = false; // whether the button is held, here

export function mountFitCard() {
  const place = document.createElement('div');
  place.id = 'fit';
  document.getElementById('screens').append(place);
  const draw = () => {
    render(isOpen() ? card() : nothing, place);
    if (isOpen()) stand(place.firstElementChild);
  };
  watch(['fit', 'view', 'file', 'u:layout', 'u:dragging'], draw);
  onViews(draw);
  onHold(() => isOpen() && fade(place.firstElementChild));
  addEventListener('resize', () => requestAnimationFrame(draw));
  for (const kind of ['pointerup', 'pointercancel', 'blur']) addEventListener(kind, () => lookBack(false));
}

/** Take the card away; tells whether there was one. */
export function closeFit() {
  if (!isOpen()) return false;
  send({ do: 'close_fit' });
  return true;
}

/** What a pose was fitted for is told at its own frame. */
function isOpen() {
  return Boolean(server.file && server.fit) && (server.fit.frame === null || server.fit.frame === server.view?.frame);
}

/** Told by what this tab holds, not by what the server has answered: a short press ends too. */
function lookBack(on) {
  if (held === on) return;
  held = on;
  if (on ? isOpen() : server.fit) send({ do: 'look_before', on });
}

function card() {
  const { frame, words, looking_back: back, changes } = server.fit;
  const [first, rest] = said(words, changes);
  return html`<div class="coach fitcard" role="status" aria-label="Fitted">
    <div class="row head">
      ${icon('wand')}<b>${frame === null ? 'Sizes fitted' : html`Frame <span class="num">${frame}</span> fitted`}</b>
      <span class="sp"></span>
      <button class="ib s" title="Close   Esc" aria-label="Close" @click=${closeFit}>${icon('x')}</button>
    </div>
    <p><span>${first}</span>${rest ? html` <span class="mut">${rest}</span>` : nothing}</p>
    ${changes.length ? table(changes) : nothing}
    <div class="row foot">
      <button class="btn sm before" aria-pressed=${back} data-keeps-focus
        title="Hold to see what was before"
        @pointerdown=${(event) => event.button === 0 && lookBack(true)}
        @keydown=${(event) => holdKey(event, true)} @keyup=${(event) => holdKey(event, false)}
        @blur=${() => lookBack(false)}>${icon('ghost')}Before</button>
      <span class="dim">${back ? 'As it was' : 'Hold to compare'}</span>
      <span class="sp"></span>
      <button class="btn sm" title="Take the fit back   Ctrl Z" @click=${() => send({ do: 'undo' })}>
        ${icon('undo')}Undo
      </button>
    </div>
  </div>`;
}

/** A number stays with its unit; what the table lists is not said as well. */
function said(words, changes) {
  const [first, rest] = sentences(words.replace(/(\d) (px|cm|mm|%)/g, '$1\u00a0$2'));
  return changes.length > 1 ? [`${count(changes.length, 'size')} changed.`, rest] : [first, rest];
}

/** The first sentence, which is the one to read, and the others. */
function sentences(words) {
  const end = words.indexOf('. ');
  return end < 0 ? [words, ''] : [words.slice(0, end + 1), words.slice(end + 2)];
}

/** Held with the keyboard as with the mouse. */
function holdKey(event, on) {
  if (event.key !== ' ' && event.key !== 'Enter') return;
  event.preventDefault();
  event.stopPropagation();
  if (!event.repeat) lookBack(on);
}

/** A row for each size that changed: part, before → after in centimetres. */
function table(changes) {
  return html`<div class="changes" role="table" aria-label="Sizes in centimetres">
    ${changes.map(
      ({ part, what, before, after }) => html`<div class="row" role="row">
        <span class="cut" role="cell" title=${`${part}, ${what}`}>${part} <span class="dim">${what}</span></span>
        ${what === 'thickness' ? inPercent(before, after) : inCentimetres(before, after)}
      </div>`,
    )}
  </div>`;
}

const inCentimetres = (before, after) => html`
  <span class="num mut" role="cell">${before.toFixed(1)}</span><span class="dim">→</span>
  <b class="num" role="cell">${after.toFixed(1)}</b>
  <span class="num dim by" role="cell">${signed(after - before)}</span>`;

/** A part has several sizes across it, and all of them change by the same share. */
const inPercent = (before, after) => {
  const share = Math.round(100 * (after / before - 1));
  return html`<span></span><span></span><b class="num" role="cell">${share < 0 ? '−' : '+'}${Math.abs(share)} %</b>
    <span class="num dim by" role="cell"></span>`;
};

const signed = (cm) => `${cm < 0 ? '−' : '+'}${Math.abs(cm).toFixed(1)}`;

/** It is placed once for what it tells, and does not wander while one looks. */
function stand(element) {
  fade(element);
  if (ui.dragging || server.fit.looking_back) return;
  const told = server.fit.words;
  const { name, x, y } = cornerFor(element, undefined, told === placed ? corner : null);
  [corner, placed] = [name, told];
  element.style.left = `${x}px`;
  element.style.top = `${y}px`;
}

function fade(element) {
  element?.classList.toggle('behind', isDragCoveredBy(element));
}
