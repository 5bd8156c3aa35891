// What a draft has found, over the picture until the next edit: how many frames, where to look, undo.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../store/state.js';
import { actionButton } from '../actions/buttons.js';
import { draftedWords, placesWords } from '../actions/drafting.js';
import { placesToConfirm } from '../actions/playhead.js';
import { iconButton } from '../controls/fields.js';
import { icon } from '../controls/icons.js';

export function draftbar() {
  const { draft } = server;
  if (!draft?.latest || ui.draftRead === server.revision || ui.tool === 'box') return nothing;
  return html`<div class="glass" id="mdraft" role="status">
    ${icon('check')}<b>${draftedWords(draft)}</b>
    ${placesToConfirm().length ? actionButton('suggestedFrame', undefined, { name: undefined, label: placesWords(), title: 'Go to the next of them' }) : nothing}
    ${actionButton('undo', undefined, { name: undefined, label: 'Undo draft', title: 'Remove the draft', kind: 'ghost' })}
    ${iconButton({ name: 'x', label: 'Close', act: () => setUi('draftRead', server.revision) })}
  </div>`;
}
