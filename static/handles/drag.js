// A drag under way. Each message says what it does from where it began, so that only the newest
// counts and a lost one does no harm.

import { setUi, ui } from '../store/state.js';
import { newStroke, send } from '../store/link.js';
import { paced } from '../controls/gesture.js';
import { interaction, redrawSoon } from './interaction.js';
import { keepPreview } from './offline.js';
import { isFine, modifiers, noteModifiers } from './pressed_keys.js';

const PAUSE_MS = 16;
const FINE = 0.1;

/**
 * Begin a drag. `messageAt(at, keys)` gives the action for a pointer at `at` in view coordinates.
 * `extra` is what is drawn of it meanwhile.
 */
export function beginDrag(view, press, messageAt, extra) {
  interaction.drag = {
    ...extra, messageAt, view: view.name, stroke: newStroke('drag'),
    virtual: [press.x, press.y], seen: [press.x, press.y],
    toView: (at) => view.toView(at),
  };
  setUi('playing', false);
  setUi('dragging', true);
  redrawSoon();
}

/** The pointer moved: with Shift the virtual pointer goes a tenth of the way. */
export function moveDrag(event, x, y) {
  const { drag } = interaction;
  noteModifiers(event);
  const share = isFine() ? FINE : 1;
  drag.virtual = drag.virtual.map((v, i) => v + ([x, y][i] - drag.seen[i]) * share);
  drag.seen = [x, y];
  if (!ui.connected) redrawSoon(); // only the page can show where it goes
  sendSoon();
}

/** A key or the pointer changed what the drag does. */
export const sendSoon = paced(() => {
  const { drag } = interaction;
  if (!drag) return;
  send({ ...drag.messageAt(drag.toView(drag.virtual), modifiers()), stroke: drag.stroke });
  drag.sent = true;
}, PAUSE_MS);

export function endDrag() {
  sendSoon.flush();
  finish('end_stroke');
}

/** Everything as it was before. */
export function cancelDrag() {
  sendSoon.drop();
  finish('cancel_stroke');
}

function finish(word) {
  const { drag } = interaction;
  if (!drag) return;
  drag.kept = word === 'end_stroke';
  if (drag.kept) keepPreview(drag);
  if (drag.sent) send({ do: word, stroke: drag.stroke });
  interaction.drag = null;
  if ('limb' in drag) setUi('limb', drag.limb ?? null);
  setUi('dragging', false);
  redrawSoon();
}
