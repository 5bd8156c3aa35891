// What the last fit did, on a card in the corner of the large view that is farthest from the body:
// its words, what was before as long as a button is pressed, and Undo. The next edit takes it away.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop } from '../controls/focus.js';
import { actionButton } from '../actions/buttons.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server, ui, watch } from '../store/state.js';
import { onViews } from '../views/views.js';
import { onInteraction } from '../handles/interaction.js';
import { isDragCoveredBy } from '../handles/floating.js';
import { placeInCorner } from '../guide/places.js';

let corner = null; // where the card stands
let placed = null; // the words it showed then
let isPressed = false; // whether the button is down, here

export function mountFitCard() {
  const place = addOnTop('fit', 'div');
  const draw = () => {
    render(isOpen() ? card() : nothing, place);
    if (isOpen()) stand(place.firstElementChild);
  };
  watch(['fit', 'view', 'file', 'u:layout', 'u:dragging'], draw);
  onViews(draw);
  onInteraction(() => isOpen() && fade(place.firstElementChild));
  addEventListener('resize', () => requestAnimationFrame(draw));
  for (const kind of ['pointerup', 'pointercancel', 'blur']) addEventListener(kind, () => lookBack(false));
}

/** Take the card away; returns whether there was one. */
export function closeFit() {
  if (!isOpen()) return false;
  send({ do: 'close_fit' });
  return true;
}

/** The fit of a pose is shown at its own frame. */
function isOpen() {
  return Boolean(server.file && server.fit) && server.fit.frame === server.view?.frame;
}

/** By this tab's button, not by the server's answer: a short press ends too. */
function lookBack(on) {
  if (isPressed === on) return;
  isPressed = on;
  if (on ? isOpen() : server.fit) send({ do: 'look_before', on });
}

function card() {
  const { frame, words, looking_back: back } = server.fit;
  return html`<div class="coach fitcard" role="status" aria-label="Fitted">
    <div class="row head">
      ${icon('wand')}<b>Frame <span class="num">${frame}</span> fitted</b>
      <span class="sp"></span>
      <button class="ib s" title="Close" data-key="Esc" aria-label="Close" @click=${closeFit}>${icon('x')}</button>
    </div>
    <p>${keepUnits(words)}</p>
    <div class="row foot">
      <button class="btn sm before" aria-pressed=${back} data-keeps-focus data-while-held
        title="Hold to see the pose before the fit"
        @pointerdown=${(event) => event.button === 0 && lookBack(true)}
        @keydown=${(event) => holdKey(event, true)} @keyup=${(event) => holdKey(event, false)}
        @blur=${() => lookBack(false)}>${icon('ghost')}Before</button>
      <span class="dim">${back ? 'Before the fit' : 'Hold to compare'}</span>
      <span class="sp"></span>
      ${actionButton('undo', undefined, { label: 'Undo', title: 'Undo fit' })}
    </div>
  </div>`;
}

/** A number stays on the line of its unit. */
const keepUnits = (words) => words.replace(/(\d) (px|cm|mm|%)/g, '$1\u00a0$2');

/** Pressed with the keyboard as with the mouse. */
function holdKey(event, on) {
  if (event.key !== ' ' && event.key !== 'Enter') return;
  event.preventDefault();
  event.stopPropagation();
  if (!event.repeat) lookBack(on);
}

/** It is placed once for its words, and does not wander while one looks. */
function stand(element) {
  fade(element);
  if (ui.dragging || server.fit.looking_back) return;
  const now = server.fit.words;
  corner = placeInCorner(element, undefined, now === placed ? corner : null);
  placed = now;
}

function fade(element) {
  element?.classList.toggle('behind', isDragCoveredBy(element));
}
