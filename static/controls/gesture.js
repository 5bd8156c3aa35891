// One gesture of a pointer, from the press until it is released; and the pace at which it acts.

import { newStroke, send } from '../store/link.js';

const RIGHT_DOWN = 2;

/**
 * Follow a pointer until it is released; for what stays where it was pulled, whatever ends it.
 * @param {HTMLElement} element
 * @param {PointerEvent} down
 * @param {{ move: (event: PointerEvent) => void, end?: () => void }} gesture
 */
export function pull(element, down, { move, end = () => {} }) {
  element.setPointerCapture(down.pointerId);
  const abort = new AbortController();
  const { signal } = abort;
  element.addEventListener('pointermove', move, { signal });
  element.addEventListener(
    'lostpointercapture',
    () => {
      abort.abort();
      end();
    },
    { signal },
  );
}

/**
 * Follow a pointer until it is released; Esc, the right button and a lost pointer cancel.
 * `holdsKeys` is whether other keys wait until it is over. Returns how to stop without an end.
 * @param {HTMLElement | SVGElement} element
 * @param {PointerEvent} down
 * @param {{ move: (event: PointerEvent) => void, end: (event: PointerEvent) => void,
 *   cancel: (event: Event) => void, holdsKeys?: () => boolean }} gesture
 */
export function follow(element, down, { move, end, cancel, holdsKeys = () => false }) {
  element.setPointerCapture(down.pointerId);
  const abort = new AbortController();
  const on = (target, kind, fn, more) => target.addEventListener(kind, fn, { signal: abort.signal, ...more });
  const stop = (fn) => (event) => {
    abort.abort();
    fn(event);
  };
  on(element, 'pointermove', (event) => (event.buttons & RIGHT_DOWN ? stop(cancel)(event) : move(event)));
  on(element, 'pointerup', stop(end));
  on(element, 'pointercancel', stop(cancel));
  const key = (event) => {
    const isEscape = event.key === 'Escape';
    if (!isEscape && !holdsKeys()) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (isEscape) stop(cancel)(event);
  };
  on(window, 'keydown', key, { capture: true });
  return () => abort.abort();
}

/**
 * Many calls, of which the newest wins: one per animation frame, or one in so many milliseconds.
 * `flush` makes what waits happen now, `drop` forgets it.
 * @param {(...args: any[]) => void} act
 * @param {number | null} [restMs]
 */
export function paced(act, restMs = null) {
  let waiting = null;
  let asked = false;
  let last = -Infinity;
  const flush = () => {
    if (waiting === null) return;
    const args = waiting;
    waiting = null;
    last = performance.now();
    act(...args);
  };
  const later = (wait) => {
    if (asked) return;
    asked = true;
    const due = () => {
      asked = false;
      flush();
    };
    if (restMs === null) requestAnimationFrame(due);
    else setTimeout(due, wait);
  };
  const call = (...args) => {
    waiting = args;
    const wait = restMs === null ? Infinity : last + restMs - performance.now();
    if (wait <= 0) flush();
    else later(wait);
  };
  return Object.assign(call, { flush, drop: () => void (waiting = null) });
}

export class Stroke {
  /** edit(value) → the action that sets the value. */
  constructor(kind, edit) {
    this.name = newStroke(kind);
    this.sent = false;
    this.move = paced((value) => {
      this.sent = true;
      send({ ...edit(value), stroke: this.name });
    });
  }

  /** Closes the undo step; gives the number of the last message. */
  end() {
    this.move.flush();
    return this.close('end_stroke');
  }

  /** Restores what was before. */
  cancel() {
    this.move.drop();
    return this.close('cancel_stroke');
  }

  close(word) {
    return this.sent ? send({ do: word, stroke: this.name }) : null;
  }
}
