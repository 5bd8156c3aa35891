// A banner over the large view for what concerns everything: the server is gone, edits wait.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop } from '../controls/focus.js';
import { icon } from '../controls/icons.js';
import { steadily } from '../controls/layout_hold.js';
import { count } from '../controls/words.js';
import { backlog, discard, release } from '../store/edits.js';
import { hasKey } from '../store/storage.js';
import { lastReceived, send, sendDue } from '../store/link.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { isNarrow, onWidth } from './more.js';

const LOST_MS = 2000;
const LONG_MS = 8000;

let downSince = 0;
/** Why nothing can be sent: null while it can, else 'lost', 'long' after LONG_MS, or 'ended' where the browser is no
 * longer let in. */
ui.line = null;

export function mountConnection() {
  watch(['u:connected', 'u:line', 'u:turnedAway'], () => {
    document.documentElement.classList.toggle('no-line', ui.line !== null);
    tick();
  });
  setInterval(tick, 500);
}

function tick() {
  if (ui.connected) {
    downSince = 0;
    setUi('line', null);
    return;
  }
  downSince ||= lastReceived();
  const down = performance.now() - downSince;
  if (down <= LOST_MS) return;
  setUi('line', ui.turnedAway ? 'ended' : down > LONG_MS ? 'long' : 'lost');
}

ui.readOnlyRead = null; // the file whose banner was put away
ui.flatRead = false; // whether the banner about WebGL was put away

export function mountBanner() {
  const place = addOnTop('banner', 'div');
  const draw = steadily(() => render(banner(), place));
  /** @type {import('../store/shapes.js').Watched[]} */
  const news = [
    'u:line',
    'u:connected',
    'u:dragging',
    'u:readOnlyRead',
    'u:flat',
    'u:flatRead',
    'u:unsent',
    'u:returning',
  ];
  watch(['file', 'saved', ...news], draw);
  onWidth(draw);
  // How many edits wait is known to the link alone.
  setInterval(() => ui.line && draw(), 500);
}

function banner() {
  if (ui.line || (!ui.connected && ui.dragging && server.file)) return noLine();
  if (ui.unsent.length && !ui.returning) return notSent(ui.unsent[0]);
  if (server.saved?.state === 'failed' && server.file && isNarrow()) return notSaved(server.saved.words);
  const isNews = server.saved?.state === 'readonly' && server.file && ui.readOnlyRead !== server.file.path;
  if (isNews) return readOnly(server.saved.words);
  return ui.flat && server.file && !ui.flatRead ? flat() : nothing;
}

/** It pulses during a drag, whose effect shows only once the connection is back. */
function noLine() {
  const pulse = ui.dragging ? 'pulse' : '';
  return html`<div class="row banner lost ${pulse}" role="alert">
    ${icon('warn')}<span>${ui.line === 'ended' ? turnedAwayWords() : lostWords()}</span>
  </div>`;
}

/** The server does not know the browser: cookies were deleted, or Keypose was started with another workspace. */
function turnedAwayWords() {
  const waiting = backlog();
  const why = hasKey()
    ? 'Keypose does not know this browser any more.'
    : 'This browser’s data for Keypose was cleared.';
  const edits = waiting ? ` ${count(waiting, 'edit')} will then be sent from this tab.` : '';
  return html`<b>${why}</b> Open the newest link in the terminal.${edits}`;
}

function lostWords() {
  const advice = ui.line === 'long' ? ' If Keypose has ended, start it again.' : '';
  return html`<b>Connection lost.</b> ${waitingEdits()} will be sent when it is back.${advice}`;
}

/** "3 edits", or "Edits" where there is none yet. */
function waitingEdits() {
  const waiting = backlog();
  return waiting ? count(waiting, 'edit') : 'Edits';
}

/** Edits from before the connection was lost, which cannot simply be sent to this server. */
function notSent({ client, why, file, count: many }) {
  const edits = `${count(many, 'edit')} ${many === 1 ? 'was' : 'were'} not sent.`;
  return html`<div class="row banner check" role="alert">
    ${icon('warn')}<span><b>${edits}</b> ${WHY_NOT_SENT[why](file)}</span>
    ${UNSENT_BUTTON[why]?.(client, file) ?? nothing}
    <button class="btn sm" @click=${() => discard(client)}>Discard</button>
  </div>`;
}

const WHY_NOT_SENT = {
  changed: () => 'This session has been changed since.',
  elsewhere: ({ name }) => `Open ${name} to apply them.`,
  readonly: () => 'This session is read only here.',
};

const UNSENT_BUTTON = {
  changed: (client) => button('Apply', () => (release(client), sendDue())),
  elsewhere: (_, { id, name }) => button(`Open ${name}`, () => send({ do: 'open', kind: 'recent', id })),
};

const button = (label, act) => html`<button class="btn sm" @click=${act}>${label}</button>`;

/** In a narrow window, where the top bar has no room for it. */
function notSaved(words) {
  return html`<div class="row banner lost" role="alert">
    ${icon('lost')}<span><b>Not saved.</b> ${words}</span>
    ${button('Try again', () => send({ do: 'save_again' }))}
  </div>`;
}

function readOnly(words) {
  const what = words || 'Read only: nothing is saved.';
  return dismissible('lock', what, () => setUi('readOnlyRead', server.file.path));
}

/** The browser draws no 3D. */
function flat() {
  const words = html`<b>WebGL is off, so the body is shown in the camera view alone.</b>
    Turn on hardware acceleration in the browser’s settings, or use another browser.`;
  return dismissible('warn', words, () => setUi('flatRead', true));
}

function dismissible(sign, words, dismiss) {
  return html`<div class="row banner check" role="alert">
    ${icon(sign)}<span>${words}</span>
    <button class="ib s" aria-label="Dismiss" title="Dismiss" @click=${dismiss}>${icon('x')}</button>
  </div>`;
}
