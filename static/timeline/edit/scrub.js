// Clicking or dragging over the frames moves the playhead; it snaps to keys unless Ctrl is held.

import { server } from '../../store/state.js';
import { send } from '../../store/link.js';
import { frameAt } from '../draw/scale.js';
import { glideTo, hold as stopPlaying, settle } from './head.js';
import { hold } from './held.js';
import { draftFrames, nearest } from '../draw/keymarks.js';
import { keyFrames, suggestedFrame } from './moves.js';
import { partMeant } from '../draw/lanevalues.js';

const SNAP_PX = 4;

/** The frame meant at a place: a key within 4 px, else the nearest frame. */
function meant(place) {
  const suggested = suggestedFrame();
  const marks = [...keyFrames(), ...draftFrames()];
  if (suggested !== null) marks.push(suggested);
  const snapped = place.ctrl ? null : nearest(marks, place.x, SNAP_PX);
  return snapped ?? frameAt(place.x);
}

/** Take hold of the playhead; `click` is what else a click without a drag does here. */
export function grabHead(start, click = () => {}) {
  stopPlaying();
  hold({ kind: 'scrub' });
  glideTo(meant(start));
  return {
    move: (place) => glideTo(meant(place)),
    click() {
      letGo();
      click();
    },
    end: letGo,
    cancel: letGo,
  };
}

/** Select the part a lane stands for at this frame. */
export function selectFrom(lane, at) {
  const part = partMeant(lane, at);
  if (part && part !== server.view?.selected) send({ do: 'select', part });
}

function letGo() {
  settle();
  hold(null);
}
