// The note of this frame, over the picture; a click edits it.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { noteAt, noteLine } from '../actions/notes.js';
import { perform, titleOf } from '../actions/actions.js';
import { icon } from '../controls/icons.js';
import { server, ui } from '../store/state.js';

export function notebar() {
  const note = noteAt(server.view.frame);
  if (!note || ui.layout === 'quad') return nothing;
  return html`<button class="glass" id="mnote" title=${titleOf('note')} @click=${() => perform('note')}>
    ${icon('note')}<span class="words">${note.text || noteLine(note)}</span></button>`;
}
