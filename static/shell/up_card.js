// What was found of the up direction, on a card in a corner of the large view while the lines that show
// it lie on the picture: its words, and where ways disagree which one to take. The next edit takes it away.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop } from '../controls/focus.js';
import { actionButton } from '../actions/buttons.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server, watch } from '../store/state.js';
import { onViews } from '../views/views.js';
import { placeInCorner } from '../guide/places.js';

let corner = null; // where the card stands
let placed = null; // the words it showed then

export function mountUpCard() {
  const place = addOnTop('found-up', 'div');
  const draw = () => {
    render(isOpen() ? card() : nothing, place);
    if (isOpen()) stand(place.firstElementChild);
  };
  watch(['up', 'camera', 'view', 'file', 'u:layout'], draw);
  onViews(draw);
  addEventListener('resize', () => requestAnimationFrame(draw));
}

/** Take the card and the lines away; returns whether there were any. */
export function closeUp() {
  if (!isOpen()) return false;
  send({ do: 'close_up' });
  return true;
}

const isOpen = () => Boolean(server.file && server.up);

function card() {
  const { words, choices } = server.up;
  const isSure = server.camera.up_is_sure && choices.length === 0;
  return html`<div class="coach fitcard" role="status" aria-label="Up direction">
    <div class="row head">
      ${icon(isSure ? 'check' : 'warn')}<b>Up direction</b>
      <span class="sp"></span>
      <button class="ib s" title="Close" data-key="Esc" aria-label="Close" @click=${closeUp}>${icon('x')}</button>
    </div>
    <p>${words}</p>
    <div class="row foot">
      ${choices.map(choice)}
      <span class="sp"></span>
      ${actionButton('undo', undefined, { label: 'Undo', title: 'Undo the up direction' })}
    </div>
  </div>`;
}

/** @param {import('../store/shapes.js').UpChoice} one */
function choice({ label, ...taken }) {
  return html`<button type="button" class="btn sm" @click=${() => send({ do: 'take_up', ...taken })}>${label}</button>`;
}

/** It is placed once for its words, and does not wander while one looks. */
function stand(element) {
  const { words } = server.up;
  corner = placeInCorner(element, undefined, words === placed ? corner : null);
  placed = words;
}
