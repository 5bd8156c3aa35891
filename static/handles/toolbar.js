// The tools down the left side of the large view.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { iconOf, isOn, keyOf, labelOf, perform } from '../actions/actions.js';
import { icon } from '../controls/icons.js';

const TOOLS = /** @type {const} */ (['select', 'rotate', 'move', 'ends', 'size']);
const PAN_KEY = 'Space'; // while it is down, whatever the tool

export function toolbar() {
  return html`<div class="glass" id="tools" role="toolbar" aria-orientation="vertical" aria-label="Tools" @keydown=${walk}>
    ${TOOLS.map((id) => toolButton(id, keyOf(id)))}
    <hr />
    ${toolButton('pan', PAN_KEY)}
  </div>`;
}

/** @param {import('../actions/actions.js').ActionId} id */
function toolButton(id, key) {
  const letter = key.length === 1 ? html`<span class="k">${key}</span>` : nothing;
  return html`<button class="ib" data-tool=${id} aria-label=${labelOf(id)} aria-pressed=${isOn(id)}
    @click=${() => perform(id)}>${icon(iconOf(id))}${letter}${tipOf(id, key)}</button>`;
}

/** The words and the key of a button on a bar, shown beside it. */
export const tipOf = (id, key) => html`<span class="tip" aria-hidden="true">${labelOf(id)} <kbd>${key}</kbd></span>`;

/** Up and down walk along the bar, as in every toolbar. */
function walk(event) {
  const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (!step) return;
  const buttons = [...event.currentTarget.querySelectorAll('button')];
  const at = buttons.indexOf(document.activeElement);
  buttons[(at + step + buttons.length) % buttons.length].focus();
  event.preventDefault();
  event.stopPropagation();
}
