// The sheet of keys, made from the table of keys.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { server, ui, setUi, watch } from '../store/state.js';
import { words } from '../store/subject.js';
import { GROUPS } from './bindings.js';
import { openGuide } from '../guide/guide.js';
import { dialogIn, toggleSheet } from '../controls/dialogs.js';

const SIGNS = { ArrowLeft: '←', ArrowRight: '→', Backspace: '⌫', Escape: 'Esc' };
const ctrl = /Mac|iPhone|iPad/.test(navigator.platform) ? '⌘' : 'Ctrl';

export function mountSheet() {
  const dialog = dialogIn('keys-sheet', 'Keys', () => setUi('sheet', false));
  watch(['u:sheet', 'file'], () => {
    render(ui.sheet ? sheet() : nothing, dialog);
    if (ui.sheet && !dialog.open) dialog.showModal();
    if (!ui.sheet && dialog.open) dialog.close();
  });
}

function sheet() {
  return html`<div class="in">
    <div class="row sheethead">
      <span class="title">Keys</span><span class="sp"></span>
      ${server.file
        ? html`<button class="btn sm ghost" @click=${showGuide}>Show the first-pose guide</button>`
        : nothing}
      <button class="ib" title="Close   Esc" aria-label="Close" autofocus @click=${toggleSheet}>
        ${icon('x')}
      </button>
    </div>
    <div class="th3">${GROUPS.map(group)}</div>
  </div>`;
}

function group({ title, rows }) {
  return html`<div>
    <h3>${asHere(title)}</h3>
    ${rows.map(
      ({ label, keys }) =>
        html`<div class="kl">
          <span>${asHere(label)}</span>${keys
            .filter((key) => !key.alias)
            .map((key) => html`<kbd>${spoken(key.chord)}</kbd>`)}
        </div>`,
    )}
  </div>`;
}

/** To surfaces a motion is fitted. */
const asHere = (label) => label.replace(/^Track\b/, words().verb);

function spoken(chord) {
  const names = chord.split(' ').map((word) => SIGNS[word] ?? word);
  return names.map((word) => (word === 'Ctrl' ? ctrl : word)).join(' ');
}

function showGuide() {
  setUi('sheet', false);
  openGuide();
}
