// A banner over the large view for what concerns everything one does: the server is gone, or
// nothing can be saved.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { icon } from '../icons.js';
import { backlog } from '../link.js';
import { S, U, put, watch } from '../state.js';
import { count } from './words.js';

U.readOnlyRead = null; // the file whose banner was put away

export function mountBanner() {
  const place = document.createElement('div');
  place.id = 'banner';
  document.getElementById('screens').append(place);
  const draw = () => render(banner(), place);
  watch(['file', 'saved', 'u:line', 'u:connected', 'u:dragging', 'u:readOnlyRead'], draw);
  // How many edits wait is known to the link alone.
  setInterval(() => U.line && draw(), 500);
}

function banner() {
  if (U.line || (!U.connected && U.dragging && S.file)) return noLine();
  const isNews = S.saved?.state === 'readonly' && S.file && U.readOnlyRead !== S.file.path;
  return isNews ? readOnly(S.saved.words) : nothing;
}

/** It stirs while one drags: what is done shows only when the line is back. */
function noLine() {
  const pulse = U.dragging ? 'pulse' : '';
  return html`<div class="banner lost ${pulse}" role="alert">
    ${icon('warn')}<span>${U.line === 'ended' ? HAS_ENDED : isAway()}</span>
  </div>`;
}

const HAS_ENDED = html`<b>This page belongs to a Keypose that has ended.</b>
  Open the address the new one printed.`;

function isAway() {
  const advice = 'If it has ended, start it again and open the address it prints.';
  return html`<b>Keypose does not answer.</b> ${waitingEdits()}. ${U.line === 'long' ? advice : nothing}`;
}

/** "3 edits wait here". */
export function waitingEdits() {
  const waiting = backlog();
  if (!waiting) return 'Edits wait here';
  return `${count(waiting, 'edit')} ${waiting === 1 ? 'waits' : 'wait'} here`;
}

function readOnly(words) {
  return html`<div class="banner check" role="alert">
    ${icon('lock')}<span>${words || 'Read only: nothing is saved.'}</span>
    <button class="ib s" aria-label="Dismiss" title="Dismiss" @click=${() => put('readOnlyRead', S.file.path)}>
      ${icon('x')}
    </button>
  </div>`;
}
