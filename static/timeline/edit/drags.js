// What can be dragged: the playhead, a diamond to another frame, a diamond of the curve up or down.

import { server } from '../../store/state.js';
import { send } from '../../store/link.js';
import { Stroke } from '../../controls/stroke.js';
import { clampFrame, frameAt, x } from '../draw/scale.js';
import { glideTo, goTo, hold as stopPlaying, isKey, keyFrames, settle, suggestedFrame } from './head.js';
import { held, hold } from './held.js';
import { draftFrames, nearest } from '../draw/keymarks.js';
import { partMeant } from '../draw/lanes.js';
import { axis, freezeRange, scale, valueAt } from '../draw/curve.js';

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

const SHAKE_MS = 240;

/**
 * Take hold of the key at a frame, with Shift of a copy of it; a click that moves less than 3 px goes
 * there. The edit is sent when the diamond is let go: on its way over other frames it would do nothing
 * but outdate results.
 */
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

const FINE = 0.1;
const STEP_DEG = 5;

/** Take hold of a key on the curve; the whole drag is one stroke, so one step of undo. */
export function grabAngle(at, row, start) {
  const part = server.curve.part;
  const about = axis();
  const from = valueAt(at);
  const degPerPx = scale(row).value(0) - scale(row).value(1);
  const stroke = new Stroke('angle', (value) => (
    { do: 'key_angle', frame: at, part, axis: about, deg: value }
  ));
  let y = start.y;
  let deg = from;
  let begun = false;
  const begin = () => {
    begun = true;
    freezeRange(true);
    goTo(at);
  };
  const over = () => {
    hold(null);
    freezeRange(false);
  };
  stopPlaying();
  return {
    edits: true,
    move(place) {
      if (!begun) begin();
      // Step by step, so that Shift may be pressed midway without a jump.
      deg += (y - place.y) * degPerPx * (place.shift ? FINE : 1);
      y = place.y;
      const value = place.ctrl ? Math.round(deg / STEP_DEG) * STEP_DEG : Math.round(deg * 10) / 10;
      hold({ kind: 'angle', frame: at, axis: about, part, from, deg: value });
      stroke.move(value);
    },
    click: () => goTo(at),
    end() {
      stroke.end();
      over();
    },
    cancel() {
      stroke.cancel();
      over();
    },
  };
}
