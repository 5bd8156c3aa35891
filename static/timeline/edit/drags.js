// What can be dragged: the playhead, a diamond to another frame, a diamond of the curve up or down.

import { server } from '../../store/state.js';
import { send } from '../../store/link.js';
import { Stroke } from '../../controls/gesture.js';
import { select } from '../../store/parts.js';
import { clampFrame } from '../../store/clip.js';
import { frameAt, x } from '../draw/scale.js';
import {
  glideTo, goTo, isKey, keyFrames, stopPlaying, settle, suggestedFrame, draftFrames,
} from '../../actions/playhead.js';
import { partKeyAt, partKeys } from '../../actions/parts.js';
import { grabbed, setGrabbed } from './pointer.js';
import { nearest } from '../draw/keymarks.js';
import { partMeant } from '../draw/lanes.js';
import { axis, freezeRange, scale, valueAt } from '../draw/curve.js';

const SNAP_PX = 4;

/** The frame meant at a place: a key within 4 px, else the nearest frame. */
function frameMeant(place) {
  const suggested = suggestedFrame();
  const marks = [...keyFrames(), ...partKeys().map((key) => key.frame), ...draftFrames()];
  if (suggested !== null) marks.push(suggested);
  const snapped = place.ctrl ? null : nearest(marks, place.x, SNAP_PX);
  return snapped ?? frameAt(place.x);
}

/** Grab the playhead; `click` is what else a click without a drag does here. */
export function grabHead(start, click = () => {}) {
  stopPlaying();
  setGrabbed({ kind: 'scrub' });
  glideTo(frameMeant(start));
  return {
    move: (place) => glideTo(frameMeant(place)),
    click() {
      release();
      click();
    },
    end: release,
    cancel: release,
  };
}

/** Select the part a lane stands for at this frame. */
export function selectFrom(lane, at) {
  const part = partMeant(lane, at);
  if (part) select(part);
}

function release() {
  settle();
  setGrabbed(null);
}

const SHAKE_MS = 240;

/**
 * Grab the key at a frame, with Shift or Alt a copy of it; `click` is what a click does that moves
 * less than 3 px. The edit is sent when the diamond is released: on its way over other frames it would do nothing
 * but outdate results.
 */
export function grabKey(from, start, click) {
  const offset = x(from) - start.x;
  stopPlaying();
  return {
    edits: true,
    move(place) {
      const to = clampFrame(frameAt(place.x + offset));
      const taken = to !== from && (isKey(to) || Boolean(partKeyAt(to)));
      setGrabbed({ kind: 'key', from, to, copy: place.shift || place.alt, taken, refused: false });
    },
    click,
    end: () => drop(grabbed()),
    cancel: () => setGrabbed(null),
  };
}

function drop(key) {
  if (key.taken) {
    putBack(key);
    return;
  }
  setGrabbed(null);
  if (key.to === key.from) return;
  send({ do: key.copy ? 'duplicate_key' : 'move_key', frame: key.from, to: key.to });
  goTo(key.to);
}

/** Onto another key: what was dragged shakes and goes back. */
export function putBack(key) {
  const shaking = { ...key, refused: true };
  setGrabbed(shaking);
  setTimeout(() => grabbed() === shaking && setGrabbed(null), SHAKE_MS);
}

const FINE = 0.1;
const STEP_DEG = 5;

/** Grab a key on the curve; the whole drag is one stroke, so one step of undo. */
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
    setGrabbed(null);
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
      setGrabbed({ kind: 'angle', frame: at, axis: about, part, from, deg: value });
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
