// The tools down the left side of the large view.

import { html } from '../vendor/lit-html/lit-html.js';
import { ui, setUi } from '../store/state.js';
import { icon } from '../controls/icons.js';
import { PAN, TOOLS } from './tools.js';

export function toolbar() {
  return html`<div class="glass" id="tools" role="toolbar" aria-orientation="vertical" aria-label="Tools" @keydown=${walk}>
    ${TOOLS.map((tool) => toolButton(tool, html`<span class="k">${tool.key}</span>`))}
    <hr />
    ${toolButton(PAN, '')}
  </div>`;
}

function toolButton({ name, icon: sign, label, key }, letter) {
  return html`<button class="ib" data-tool=${name} aria-label=${label} aria-pressed=${ui.tool === name}
    @click=${() => setUi('tool', name)}>
    ${icon(sign)}${letter}<span class="tip" aria-hidden="true">${label} <kbd>${key}</kbd></span>
  </button>`;
}

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
