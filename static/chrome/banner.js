// A banner over the large view for what concerns everything one does: the server is gone, nothing
// can be saved, or the browser draws no bodies.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { icon } from '../icons.js';
import { backlog } from '../link.js';
import { S, U, put, watch } from '../state.js';
import { count } from './words.js';

U.readOnlyRead = null; // the file whose banner was put away
U.flatRead = false;

export function mountBanner() {
  const place = document.createElement('div');
  place.id = 'banner';
  document.getElementById('screens').append(place);
  const draw = () => render(banner(), place);
  const news = ['u:line', 'u:connected', 'u:dragging', 'u:readOnlyRead', 'u:flat', 'u:flatRead'];
  watch(['file', 'saved', ...news], draw);
  // How many edits wait is known to the link alone.
  setInterval(() => U.line && draw(), 500);
}

function banner() {
  if (U.line || (!U.connected && U.dragging && S.file)) return noLine();
  const isNews = S.saved?.state === 'readonly' && S.file && U.readOnlyRead !== S.file.path;
  if (isNews) return readOnly(S.saved.words);
  return U.flat && S.file && !U.flatRead ? flat() : nothing;
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
  const what = words || 'Read only: nothing is saved.';
  return dismissible('lock', what, () => put('readOnlyRead', S.file.path));
}

function flat() {
  const words = html`<b>This browser draws no 3D, so no body is seen.</b>
    Turn on graphics acceleration in its settings, or open this address in another browser.`;
  return dismissible('warn', words, () => put('flatRead', true));
}

function dismissible(sign, words, dismiss) {
  return html`<div class="banner check" role="alert">
    ${icon(sign)}<span>${words}</span>
    <button class="ib s" aria-label="Dismiss" title="Dismiss" @click=${dismiss}>${icon('x')}</button>
  </div>`;
}
