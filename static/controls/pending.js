// Values that were set and not answered yet. Such a value is shown as it was set, in every control
// of its key, until the server has answered its last edit: the echo never jumps into a drag.

import { server, ui } from '../store/state.js';
import { listen } from '../store/link.js';

const values = new Map();
const awaited = new Map();
const shownBy = new Set();
const PATIENCE_MS = 10_000;

/** Call fn(key) whenever a pending value changes or is cleared; returns how to stop. */
export function onPending(fn) {
  shownBy.add(fn);
  return () => shownBy.delete(fn);
}

/** What to show for this key: the pending one, or else the server's value. */
export function pendingOr(key, value) {
  return values.has(key) ? values.get(key) : value;
}

export function setPending(key, value) {
  values.set(key, value);
  awaited.delete(key);
  notify(key);
}

/** Clear it once the server has answered edit n. */
export function clearAfter(key, n) {
  if (!values.has(key)) return;
  awaited.set(key, n);
  setTimeout(() => clearLate(key, n), PATIENCE_MS);
}

export function clearPending(key) {
  awaited.delete(key);
  if (values.delete(key)) notify(key);
}

/** An answer that got lost must not leave a wrong number standing; offline edits keep waiting. */
function clearLate(key, n) {
  if (awaited.get(key) !== n) return;
  if (ui.connected) clearPending(key);
  else setTimeout(() => clearLate(key, n), PATIENCE_MS);
}

function clearAnswered(upTo) {
  for (const [key, n] of awaited) if (n <= upTo) clearPending(key);
}

function notify(key) {
  for (const fn of shownBy) fn(key);
}

listen('state', () => clearAnswered(server.done ?? 0));
listen('refused', (message) => clearAnswered(message.n));
