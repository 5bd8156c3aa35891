// What a control is called and its key, shown a moment after the pointer rests on it: its title, and
// its `data-key`.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { onRedraw, ui } from '../store/state.js';
import { addOnTop } from './focus.js';
import { belowOrAbove, standAt } from './menu.js';

const REST_MS = 450;
const AGAIN_MS = 300; // from one control to the next the words come at once

let place = null;
let owner = null; // the element under the pointer, and the title it lends us
let title = '';
let timer = 0;
let hiddenAt = 0;

export function mountTips() {
  place = addOnTop('tip', 'div');
  // To a screen reader the control itself gives the title.
  place.setAttribute('aria-hidden', 'true');
  addEventListener('pointerover', (event) => enter(event.target));
  addEventListener('pointerout', (event) => event.relatedTarget === null && leave());
  for (const kind of ['pointerdown', 'keydown', 'wheel', 'blur']) {
    addEventListener(kind, leave, { capture: true, passive: true });
  }
  onRedraw(renew);
}

/** Under a resting pointer a control may change what it says, or go. */
function renew() {
  if (owner === null) return;
  if (!owner.isConnected) return leave();
  if (!owner.title) return;
  title = owner.title;
  owner.removeAttribute('title');
  if (place.firstElementChild) show();
}

function enter(target) {
  const found = target.closest?.('[title]') ?? null;
  if (owner !== null && owner.contains(target) && (found === null || found === owner)) return;
  leave();
  if (!found || ui.dragging || !found.title) return;
  owner = found;
  title = found.title;
  // While it is lent the browser shows none of its own.
  found.removeAttribute('title');
  const wait = performance.now() - hiddenAt < AGAIN_MS ? 0 : REST_MS;
  timer = setTimeout(show, wait);
}

function leave() {
  clearTimeout(timer);
  if (owner === null) return;
  // A title that was set anew in between is the newer one.
  if (!owner.hasAttribute('title')) owner.setAttribute('title', title);
  owner = null;
  if (place.firstElementChild) hiddenAt = performance.now();
  render(nothing, place);
}

function show() {
  if (!owner?.isConnected) return;
  const { key } = owner.dataset;
  render(html`<div class="tip" role="tooltip">${title}${key ? keys(key) : nothing}</div>`, place);
  put(place.firstElementChild, owner.getBoundingClientRect());
}

const keys = (key) => html` <kbd>${key}</kbd>`;

/** Below its control, above it where there is no room; never out of the window. */
function put(tip, at) {
  const { offsetWidth: width, offsetHeight: height } = tip;
  const left = (at.left + at.right - width) / 2;
  standAt(tip, left, belowOrAbove(height, at.bottom + 6, at.top - 6, 4));
}
