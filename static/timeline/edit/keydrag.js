// Dragging a diamond moves its key to another frame, with Shift a copy of it. The edit is sent when
// the diamond is let go: on its way over other frames it would do nothing but outdate results.

import { send } from '../../store/link.js';
import { clampFrame, frameAt, x } from '../draw/scale.js';
import { goTo, hold as stopPlaying } from './head.js';
import { held, hold } from './held.js';
import { isKey } from './moves.js';

const SHAKE_MS = 240;

/** Take hold of the key at a frame; a click that moves less than 3 px goes there. */
export function grabKey(from, start) {
  const offset = x(from) - start.x;
  stopPlaying();
  return {
    edits: true,
    move(place) {
      const to = clampFrame(frameAt(place.x + offset));
      const taken = to !== from && isKey(to);
      hold({ kind: 'key', from, to, copy: place.shift, taken, refused: false });
    },
    click: () => goTo(from),
    end: () => drop(held()),
    cancel: () => hold(null),
  };
}

function drop(key) {
  if (key.taken) {
    refuse(key);
    return;
  }
  hold(null);
  if (key.to === key.from) return;
  send({ do: key.copy ? 'duplicate_key' : 'move_key', frame: key.from, to: key.to });
  goTo(key.to);
}

/** Onto another key: the diamond shakes and goes back. */
function refuse(key) {
  const shaking = { ...key, refused: true };
  hold(shaking);
  setTimeout(() => held() === shaking && hold(null), SHAKE_MS);
}
