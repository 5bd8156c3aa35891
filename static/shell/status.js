// The status bar: the keys of the tool in hand, the tabs open, the connection.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { keyOf } from '../actions/actions.js';
import { isEnd } from '../actions/pins.js';
import { icon } from '../controls/icons.js';
import { backlog } from '../store/edits.js';
import { server, ui, watch } from '../store/state.js';
import { selectedPart } from '../store/parts.js';
import { pinHints } from '../timeline/edit/mark_drags.js';
import { reviewHints } from '../actions/review.js';
import { rangeHints } from '../timeline/edit/range_drags.js';
import { guideHints } from '../guide/guide.js';
import * as tools from '../handles/tools.js';
import { count } from '../controls/words.js';

export function mountStatus() {
  const element = document.getElementById('status');
  const draw = () => render(bar(), element);
  watch(['file', 'tabs', 'view', 'body', 'u:timeHover', 'u:timeGrabbed', 'u:timeKeys', 'keys', 'u:tool', 'u:layout', 'u:dragging', 'u:connected', 'u:line', 'u:guideStep', 'u:guidePath', 'u:box', 'u:review'], draw);
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
  const guided = ui.dragging ? null : guideHints() ?? reviewHints();
  const inHand = guided ?? pinHints() ?? (ui.dragging ? null : rangeHints());
  if (inHand) return inHand;
  const hints = tools.hintsFor?.(ui.tool, ui.dragging, ui.layout) ?? [];
  const canPin = !ui.dragging && isEnd(selectedPart());
  return canPin ? [...hints, [keyOf('pin'), `pin or unpin the ${selectedPart().short.toLowerCase()}`]] : hints;
}

const hint = (keys, words) => html`<span class="h"><kbd>${keys}</kbd>${words}</span>`;

function tabs() {
  if (!server.tabs) return nothing;
  return html`<span class="h">${icon('tabs')}${count(server.tabs, 'tab')} open</span>`;
}

function connection() {
  if (ui.connected) {
    return html`<span class="h"
      ><i class="dot" style="background:var(--good)"></i>Connected
      <span class="dim num">${location.host}</span></span
    >`;
  }
  const waiting = backlog() ? ` ${count(backlog(), 'edit')} waiting` : '';
  const words = `${ui.line === 'ended' ? 'Not connected.' : 'Reconnecting…'}${waiting}`;
  return html`<span class="h lostlink" role="status">${icon('warn')}${words}</span>`;
}
