// Messages: what the server notes or refuses, and those of the page itself.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop } from './focus.js';
import { icon } from './icons.js';
import { steadily } from './layout_hold.js';
import { isNewest, isPast } from '../store/edits.js';
import { listen, send } from '../store/link.js';
import { server, ui, setUi, watch } from '../store/state.js';

const MOST = 4;
const OPENING_MS = 1500; // what is noted while a file opens may arrive before the file
const STAYS_MS = { good: 4000, info: 6000, check: 9000, lost: 12000 };
const ICONS = { good: 'check', check: 'warn', lost: 'lost', info: 'help' };

let count = 0;
/** @type {HTMLElement | null} */
let place = null;

/**
 * Show a message: {kind, words, detail?, button?: {label, send?: action, run?: fn}, brief?, edit?}. One
 * with a button waits for an answer, unless it is brief. edit: the number of the message that it tells
 * of; once something else is done, or that is undone, it goes.
 */
export function toast(message) {
  const shown = ui.toasts ?? [];
  const same = shown.find(({ words }) => words === message.words);
  const until = performance.now() + (STAYS_MS[message.kind] ?? STAYS_MS.info);
  if (same) same.until = until;
  else setUi('toasts', fewest([...shown, { ...message, until, ...stamp() }]));
}

/** Under a pointer none goes, or the others would move there. */
const isUnderPointer = () => place?.matches(':hover, :focus-within') === true;
const fewest = (shown) => (isUnderPointer() ? shown : shown.slice(-MOST));

const stamp = () => ({ id: ++count, path: server.file?.path ?? null, at: performance.now() });

export function mountToasts() {
  const stack = addOnTop('toasts', 'div');
  place = stack;
  stack.setAttribute('aria-live', 'polite');
  listen('note', toast);
  listen('refused', ({ words }) => toast({ kind: 'check', words }));
  watch(['file'], forgetOthers);
  watch(['revision'], forgetPast);
  // The newest stands farthest from the edge, so that none is pushed away by the next.
  watch(
    ['u:toasts'],
    steadily(() => render((ui.toasts ?? []).map(card), stack)),
  );
  setInterval(sweep, 500);
}

/** Another file is open: what was said of the one before goes. */
function forgetOthers() {
  const here = server.file?.path;
  if (here === undefined) return;
  const now = performance.now();
  const isOurs = ({ path, at }) => path === here || now - at < OPENING_MS;
  const shown = ui.toasts ?? [];
  const left = shown.filter(isOurs);
  if (left.length < shown.length) setUi('toasts', left);
}

/** What tells of an edit that is not the newest any more goes; the server may have done the next one, too,
 * before it answers. */
function forgetPast() {
  const shown = ui.toasts ?? [];
  for (const one of shown) if (one.edit !== undefined && isNewest(one.edit)) one.wasNewest = true;
  const left = shown.filter((one) => !(one.wasNewest || isPast(one.edit)) || isNewest(one.edit));
  if (left.length < shown.length && !isUnderPointer()) setUi('toasts', left);
}

/** What is old goes, unless it is being read or waits for an answer. */
function sweep() {
  if (isUnderPointer()) return;
  const shown = ui.toasts ?? [];
  const left = shown.filter((one) => (one.button && !one.brief) || one.until > performance.now());
  if (left.length < shown.length) setUi('toasts', left);
}

function dismiss(id) {
  setUi(
    'toasts',
    (ui.toasts ?? []).filter((one) => one.id !== id),
  );
}

function card(message) {
  const { kind = 'info', id, button, words = '', detail = '' } = message;
  return html`<div
    class="toast ${kind}"
    data-toast=${id}
    role=${kind === 'lost' ? 'alert' : 'status'}
  >
    <span class="sign">${icon(ICONS[kind] ?? 'help')}</span>
    <span class="words"
      >${detail ? html`<b>${words}</b><br /><span class="mut">${detail}</span>` : words}</span
    >
    ${button ? html`<button class="btn sm" @click=${() => answer(id, button)}>${button.label}</button>` : nothing}
    <button class="ib s" aria-label="Dismiss" title="Dismiss" @click=${() => dismiss(id)}>
      ${icon('x')}
    </button>
  </div>`;
}

function answer(id, button) {
  dismiss(id);
  if (button.run) button.run();
  else send(button.send);
}
