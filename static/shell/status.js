// The status bar: keys of the tool in hand, tabs, connection; and whether the work is saved.

import { pinHints } from '../timeline/marks/pins.js';
import { rangeHints } from '../timeline/marks/selection.js';
import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { keyOf } from '../actions/actions.js';
import { isEnd } from '../actions/pins.js';
import { reviewHints } from '../actions/review.js';
import { icon } from '../controls/icons.js';
import { count, shortAgo } from '../controls/words.js';
import { guideHints } from '../guide/guide.js';
import * as tools from '../handles/tools.js';
import { backlog } from '../store/edits.js';
import { send } from '../store/link.js';
import { selectedPart } from '../store/parts.js';
import { server, ui, watch } from '../store/state.js';
import { isNarrow } from './more.js';

/** The saved state of the top bar. */
export function savedState() {
  const saved = server.saved;
  if (!saved) return nothing;
  /** @type {Record<string, (saved: import('../store/shapes.js').Saved) => unknown>} */
  const shown = { saved: isSaved, saving: isSaving, failed: hasFailed, readonly: isReadOnly };
  return html`<span class="savedbox" role="status">${shown[saved.state]?.(saved) ?? nothing}</span>`;
}

/** Whether the words change with the clock. */
export const savedTicks = () => server.saved?.state === 'saved' && Boolean(server.saved.at);

function isSaved({ at }) {
  if (!ui.connected) return nothing; // the status bar says that edits wait
  const words = `Saved${at ? ` ${shortAgo(at)}` : ''}`;
  return html`<span class="row saved" title=${words}>${icon('check')}<span class="say">${words}</span></span>`;
}

function isSaving() {
  return html`<span class="row saved saving" title="Saving…">${icon('run')}<span class="say">Saving…</span></span>`;
}

function hasFailed({ words }) {
  const text = words ? `Not saved: ${words}` : 'Not saved';
  // Where the bar has no room for it a banner says it.
  if (isNarrow()) return html`<span class="row saved failed" title=${text}>${icon('lost')}</span>`;
  return html`<span class="chip lost notsaved" title=${text}>
    ${icon('lost')}<button class="btn sm" @click=${() => send({ do: 'save_again' })}>Try again</button>
    <span class="cut">${text}</span>
  </span>`;
}

function isReadOnly({ words }) {
  const text = words || 'Read only';
  return html`<span class="row saved readonly" title=${text}>
    ${icon('lock')}<span class="cut say">${text}</span>
  </span>`;
}

export function mountStatus() {
  const element = document.getElementById('status');
  const draw = () => render(bar(), element);
  watch(
    [
      'file',
      'tabs',
      'view',
      'body',
      'u:timeHover',
      'u:timeGrabbed',
      'u:timeKeys',
      'keys',
      'u:tool',
      'u:layout',
      'u:dragging',
      'u:connected',
      'u:line',
      'u:guideStep',
      'u:guidePath',
      'u:box',
      'u:review',
    ],
    draw,
  );
  // How many edits wait is known to the link alone.
  setInterval(() => ui.connected || draw(), 500);
  addEventListener('beforeunload', keepWaiting);
}

/** Edits that wait would be lost with the tab: the browser asks first. */
function keepWaiting(event) {
  if ((!ui.connected && backlog() > 0) || ui.unsent.length) event.preventDefault();
}

function bar() {
  return html`<span class="hints">${hintsNow().map(([keys, words]) => hint(keys, words))}</span>
    <span class="sp"></span>${tabs()}${connection()}`;
}

function hintsNow() {
  if (!server.file) return [['?', 'keys and help']];
  const guided = ui.dragging ? null : (guideHints() ?? reviewHints());
  const inHand = guided ?? pinHints() ?? (ui.dragging ? null : rangeHints());
  if (inHand) return inHand;
  const hints = tools.hintsFor?.(ui.tool, ui.dragging, ui.layout) ?? [];
  const canPin = !ui.dragging && isEnd(selectedPart());
  return canPin ? [...hints, [keyOf('pin'), `pin or unpin the ${selectedPart().short.toLowerCase()}`]] : hints;
}

const hint = (keys, words) => html`<span class="row h"><kbd>${keys}</kbd>${words}</span>`;

function tabs() {
  if (!server.tabs) return nothing;
  return html`<span class="row h">${icon('tabs')}${count(server.tabs, 'tab')} open</span>`;
}

function connection() {
  if (ui.connected) {
    return html`<span class="row h"
      ><i class="dot" style="background:var(--good)"></i>Connected
      <span class="dim num">${location.host}</span></span
    >`;
  }
  const waiting = backlog() ? ` ${count(backlog(), 'edit')} waiting` : '';
  const words = `${ui.line === 'ended' ? 'Not connected.' : 'Reconnecting…'}${waiting}`;
  return html`<span class="row h lostlink" role="status">${icon('warn')}${words}</span>`;
}
