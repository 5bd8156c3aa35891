// Values a person's hand is on. A value that is held is shown as it was set, in every control of
// the same key, until the server has answered its last edit: the echo never jumps into a drag.

import { server, ui } from '../store/state.js';
import { listen } from '../store/link.js';

const values = new Map();
const awaited = new Map();
const shownBy = new Set();
const PATIENCE_MS = 10_000;

/** Call fn(key) whenever a held value changes or is let go; returns how to stop. */
export function onHeld(fn) {
  shownBy.add(fn);
  return () => shownBy.delete(fn);
}

/** What to show for this key: what is held, or else the server's value. */
export function shown(key, value) {
  return values.has(key) ? values.get(key) : value;
}

export function hold(key, value) {
  values.set(key, value);
  awaited.delete(key);
  tell(key);
}

/** Let go once the server has answered edit n. */
export function letGoAfter(key, n) {
  if (!values.has(key)) return;
  awaited.set(key, n);
  setTimeout(() => giveUp(key, n), PATIENCE_MS);
}

export function letGo(key) {
  awaited.delete(key);
  if (values.delete(key)) tell(key);
}

/** An answer that got lost must not leave a wrong number standing; offline edits keep waiting. */
function giveUp(key, n) {
  if (awaited.get(key) !== n) return;
  if (ui.connected) letGo(key);
  else setTimeout(() => giveUp(key, n), PATIENCE_MS);
}

function answered(upTo) {
  for (const [key, n] of awaited) if (n <= upTo) letGo(key);
}

function tell(key) {
  for (const fn of shownBy) fn(key);
}

listen('state', () => answered(server.done ?? 0));
listen('refused', (message) => answered(message.n));
