// The sheet of keys, made from the table of actions.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { keySheet, spell } from '../actions/actions.js';
import { mountDialog, toggleSheet } from '../controls/dialogs.js';
import { icon } from '../controls/icons.js';
import { openGuide } from '../guide/guide.js';
import { server, setUi } from '../store/state.js';

export function mountSheet() {
  mountDialog({ id: 'keys-sheet', label: 'Keys', name: 'sheet', names: ['file'], draw: sheet });
}

function sheet() {
  return html`<div class="in">
    <div class="row sheethead">
      <span class="title">Keys</span><span class="sp"></span>
      ${server.file
        ? html`<button class="btn sm ghost" @click=${showGuide}>Show the first-pose guide</button>`
        : nothing}
      <button class="ib" title="Close" data-key="Esc" aria-label="Close" autofocus @click=${toggleSheet}>
        ${icon('x')}
      </button>
    </div>
    <div class="th3">${keySheet().map(group)}</div>
  </div>`;
}

function group({ title, lines }) {
  return html`<div>
    <h3>${title}</h3>
    ${lines.map(
      ({ words, keys }) =>
        html`<div class="kl"><span>${words}</span>${keys.map((chord) => html`<kbd>${spell(chord)}</kbd>`)}</div>`,
    )}
  </div>`;
}

function showGuide() {
  setUi('sheet', null);
  openGuide();
}
