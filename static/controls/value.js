// A value that is dragged, nudged or set, and shown as it was set until it is answered. Such a value
// is shown as it was set, in every control of its key, until the server has answered its last edit:
// the echo never jumps into a drag. spec: { key         what is edited: controls of one key show one
// value label, value, unit, decimals, edit(value) → action step        one nudge; coarse: one step of
// a drag with Ctrl min, max    what makes sense at all limit       [low, high] that hold, or null off
// why it cannot be changed now, or '' }

import { listen, send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';
import { clamp } from './arithmetic.js';
import { follow, Stroke } from './gesture.js';

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

const NUDGES_END_MS = 300;

export class ValueElement extends HTMLElement {
  connectedCallback() {
    if (!this.built) this.build();
    this.built = true;
    this.forget = onPending((key) => key === this.spec.key && this.draw());
    this.draw();
  }

  disconnectedCallback() {
    this.finish();
    this.forget?.();
  }

  set spec(next) {
    if (this.known && this.known.key !== next.key) {
      this.finish();
      this.leave();
    }
    this.known = next;
    if (this.built) this.draw();
  }

  /** @returns {any} as above; controls are not shown before they have it */
  get spec() {
    return this.known;
  }

  /** The value as shown: as set by hand until the server has answered, else the server's. */
  get value() {
    return pendingOr(this.spec.key, this.spec.value);
  }

  get steps() {
    return this.spec.step ?? 1;
  }

  /** Between which values anything makes sense. */
  get ends() {
    return [this.spec.min ?? -Infinity, this.spec.max ?? Infinity];
  }

  /** The value brought within what makes sense and what limits allow. */
  within(value) {
    const [min, max] = this.ends;
    const [low, high] = this.spec.limit ?? [-Infinity, Infinity];
    // Where the pose already lies beyond a limit it may come back but not go further.
    const now = this.spec.value ?? 0;
    const down = Math.max(min, Math.min(low, now));
    const up = Math.min(max, Math.max(high, now));
    return clamp(value, down, up);
  }

  get isAtLimit() {
    const { limit, decimals = 1 } = this.spec;
    if (!limit) return false;
    const margin = 0.5 * 10 ** -decimals;
    // An elbow at rest stands at its limit: that is worth a word only while it is in the hand.
    if (Math.abs(this.value) < margin && !this.isInHand) return false;
    return this.value <= limit[0] + margin || this.value >= limit[1] - margin;
  }

  get isInHand() {
    return this.stroke != null;
  }

  moveTo(value) {
    this.stroke ??= new Stroke('field', this.spec.edit);
    this.wanted = this.within(value);
    setPending(this.spec.key, this.wanted);
    this.stroke.move(this.wanted);
  }

  /** One nudge; those that follow within 300 ms belong to the same undo step. */
  nudge(amount) {
    if (this.spec.off) return;
    clearTimeout(this.pause);
    this.moveTo(this.value + amount);
    this.pause = setTimeout(() => this.finish(), NUDGES_END_MS);
  }

  /** A value all at once: one undo step. */
  setTo(value) {
    this.finish();
    setPending(this.spec.key, this.within(value));
    clearAfter(this.spec.key, send(this.spec.edit(this.within(value))));
  }

  finish() {
    clearTimeout(this.pause);
    if (!this.stroke) return;
    const last = this.stroke.end();
    this.stroke = null;
    if (last === null) clearPending(this.spec.key);
    else clearAfter(this.spec.key, last);
  }

  cancelStroke() {
    clearTimeout(this.pause);
    if (!this.stroke) return false;
    this.stroke.cancel();
    this.stroke = null;
    clearPending(this.spec.key);
    return true;
  }

  /** How far one arrow key goes. */
  stride(event) {
    return this.steps * (event.shiftKey ? 10 : 1) * (event.ctrlKey || event.metaKey ? 0.1 : 1);
  }

  /** Wheel notches since the last one; the small deltas of a touch pad add up to one. */
  notches(event) {
    const delta = event.deltaY || event.deltaX;
    if (Math.abs(delta) >= 40 || event.deltaMode !== 0) return -Math.sign(delta);
    this.rolled = (this.rolled ?? 0) + delta;
    if (Math.abs(this.rolled) < 40) return 0;
    const way = -Math.sign(this.rolled);
    this.rolled = 0;
    return way;
  }

  /** What a control drops when it comes to stand for something else. */
  leave() {}

  /** What it is made of, once. */
  build() {}

  /** The present value, shown. */
  draw() {}
}

/** Follow a pointer that drags a value: nothing else happens on the page meanwhile. */
export function followValue(element, down, { move, end, cancel }) {
  const noMenu = (event) => event.preventDefault();
  const over = (fn) => () => {
    removeEventListener('contextmenu', noMenu);
    setUi('dragging', false);
    fn();
  };
  setUi('dragging', true);
  addEventListener('contextmenu', noMenu);
  follow(element, down, { move, end: over(end), cancel: over(cancel) });
}
