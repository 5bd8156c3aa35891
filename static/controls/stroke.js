// One gesture on a control: every move is told from the gesture's beginning, at most once per
// animation frame, the newest wins; the end tells the last value and closes the undo step.

import { newStroke, send } from '../store/link.js';

export class Stroke {
  /** edit(value) → the action that sets the value. */
  constructor(kind, edit) {
    this.name = newStroke(kind);
    this.edit = edit;
    this.asked = 0;
    this.waits = false;
    this.sent = false;
  }

  move(value) {
    this.value = value;
    this.waits = true;
    if (!this.asked) this.asked = requestAnimationFrame(() => this.flush());
  }

  /** Closes the undo step; gives the number of the last message. */
  end() {
    this.flush();
    return this.close('end_stroke');
  }

  /** Takes everything back. */
  cancel() {
    this.waits = false;
    this.flush();
    return this.close('cancel_stroke');
  }

  flush() {
    cancelAnimationFrame(this.asked);
    this.asked = 0;
    if (!this.waits) return;
    this.waits = false;
    this.sent = true;
    send({ ...this.edit(this.value), stroke: this.name });
  }

  close(word) {
    return this.sent ? send({ do: word, stroke: this.name }) : null;
  }
}
