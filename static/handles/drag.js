// A drag under way. What it does is always told from where it began, so that only the newest
// word counts and a lost one does no harm.

import { setUi } from '../store/state.js';
import { newStroke, send } from '../store/link.js';
import { paced } from '../controls/gesture.js';
import { hold, touch } from './hold.js';
import { isFine, modifiers, noteModifiers } from './keysheld.js';

const PAUSE_MS = 16;
const FINE = 0.1;

/**
 * Begin a drag. `tell(at, held)` gives the action for a pointer at `at` in view coordinates.
 * `extra` is what the drawing wants to know about it.
 */
export function beginDrag(view, press, tell, extra) {
  hold.drag = {
    ...extra, tell, view: view.name, stroke: newStroke('drag'),
    virtual: [press.x, press.y], seen: [press.x, press.y],
    toView: (at) => view.toView(at),
  };
  setUi('playing', false);
  setUi('dragging', true);
  touch();
}

/** The pointer moved: with Shift the virtual pointer goes a tenth of the way. */
export function moveDrag(event, x, y) {
  const { drag } = hold;
  noteModifiers(event);
  const share = isFine() ? FINE : 1;
  drag.virtual = drag.virtual.map((v, i) => v + ([x, y][i] - drag.seen[i]) * share);
  drag.seen = [x, y];
  tellSoon();
}

/** A key or the pointer changed what the drag does. */
export const tellSoon = paced(() => {
  const { drag } = hold;
  if (!drag) return;
  send({ ...drag.tell(drag.toView(drag.virtual), modifiers()), stroke: drag.stroke });
  drag.told = true;
}, PAUSE_MS);

export function endDrag() {
  tellSoon.flush();
  finish('end_stroke');
}

/** Everything as it was before. */
export function cancelDrag() {
  tellSoon.drop();
  finish('cancel_stroke');
}

function finish(word) {
  const { drag } = hold;
  if (!drag) return;
  drag.kept = word === 'end_stroke';
  if (drag.told) send({ do: word, stroke: drag.stroke });
  hold.drag = null;
  if ('limb' in drag) setUi('limb', drag.limb ?? null);
  setUi('dragging', false);
  touch();
}
