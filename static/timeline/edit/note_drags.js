// A note on the ruler, dragged to another frame; a click goes to its frame.

import { goTo, stopPlaying } from '../../actions/playhead.js';
import { noteAt } from '../../actions/notes.js';
import { clampFrame } from '../../store/clip.js';
import { send } from '../../store/link.js';
import { frameAt, x } from '../draw/scale.js';
import { grabbed, setGrabbed } from './pointer.js';

/** Grab the note at a frame; it is sent where it is let go, unless another one is there. */
export function grabNote(from, start) {
  const offset = x(from) - start.x;
  stopPlaying();
  return {
    edits: true,
    move(place) {
      const to = clampFrame(frameAt(place.x + offset));
      setGrabbed({ kind: 'note', from, to, taken: to !== from && Boolean(noteAt(to)) });
    },
    click: () => goTo(from),
    end() {
      const { to, taken } = grabbed();
      setGrabbed(null);
      if (!taken && to !== from) send({ do: 'move_note', frame: from, to });
    },
    cancel: () => setGrabbed(null),
  };
}
