// One gesture on a control: every move is sent as measured from the gesture's beginning, at most once
// per animation frame, the newest wins; the end sends the last value and closes the undo step.

import { newStroke, send } from '../store/link.js';
import { paced } from './gesture.js';

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
