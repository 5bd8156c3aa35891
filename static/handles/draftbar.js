// What a draft has found, over the picture until the next edit: how many frames, where to look, undo.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../store/state.js';
import { actionButton } from '../actions/buttons.js';
import { boxFrameFor, draftedWords, nobodyWords, personWords, placesWords } from '../actions/drafting.js';
import { placesToConfirm } from '../actions/playhead.js';
import { button, iconButton } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { drawBoxAt } from './sketch.js';

export function draftbar() {
  const { draft } = server;
  if (!draft?.latest || ui.draftRead === server.revision || ui.tool === 'box') return nothing;
  const nobody = nobodyWords();
  const person = personWords();
  const at = nobody && boxFrameFor(draft);
  return html`<div class="glass ${nobody || person ? 'lacking' : ''}" id="mdraft" role="status">
    ${icon(nobody || person ? 'warn' : 'check')}
    <span>${nobody ? html`<b>${nobody}</b> ${draftedWords(draft)}` : html`<b>${draftedWords(draft)}</b>`} ${person}</span>
    ${nobody ? button({ label: `Draw a box at ${at}`, title: 'Draft these frames from a box in one of them', act: () => drawBoxAt(at) }) : nothing}
    ${placesToConfirm().length && !ui.review ? actionButton('review', undefined, { name: undefined, label: `${placesWords()}: review`, title: 'Look at them one after another' }) : nothing}
    ${actionButton('undo', undefined, { name: undefined, label: 'Undo draft', title: 'Remove the draft', kind: 'ghost' })}
    ${iconButton({ name: 'x', label: 'Close', act: () => setUi('draftRead', server.revision) })}
  </div>`;
}
