// Several keyframes under the pointer: a box selects them, one of them drags all, the ends of the
// selection stretch it. An edit is sent when the pointer is released.

import { clampFrame, lastFrame } from '../../store/clip.js';
import {
  retime, selectBetween, selectedKeys, selectKeys, shifted, stretched, whyNotAt,
} from '../../actions/selection.js';
import { frame, stopPlaying } from '../../actions/playhead.js';
import { keyOf } from '../../actions/actions.js';
import { reveal } from '../../actions/window.js';
import { nearest } from '../draw/keymarks.js';
import { frameAt, x } from '../draw/scale.js';
import { grabbed, setGrabbed } from './pointer.js';
import { putBack } from './drags.js';

const SNAP_PX = 4;

/** Pull a box over keyframes; with Shift or Ctrl they come beside those selected. `click` is what a click does. */
export function grabBox(start, click) {
  const before = selectedKeys();
  const kept = start.shift || start.ctrl ? before : [];
  const from = frameAt(start.x);
  return {
    move(place) {
      const to = frameAt(place.x);
      reveal(clampFrame(to), 0);
      setGrabbed({ kind: 'box', from, to });
      selectBetween(Math.min(from, to), Math.max(from, to), kept);
    },
    click,
    end: () => setGrabbed(null),
    cancel() {
      setGrabbed(null);
      selectKeys(before);
    },
  };
}

/** Grab all selected keyframes at the one at a frame, with Shift or Alt copies of them. */
export function grabKeys(at, start, click) {
  const frames = selectedKeys();
  const offset = x(at) - start.x;
  stopPlaying();
  return {
    edits: true,
    move(place) {
      reveal(clampFrame(frameAt(place.x)), 0);
      const to = shifted(frames, frameAt(place.x + offset) - at, lastFrame());
      carry({ frames, to, held: at, copy: place.shift || place.alt });
    },
    click,
    end: drop,
    cancel: () => setGrabbed(null),
  };
}

/** Grab the first or the last end of the selection: times scale about the other. It snaps to the
 * playhead; Alt: it does not. */
export function grabSelectionEnd(end, start) {
  const frames = selectedKeys();
  const held = end === 'first' ? frames[0] : frames.at(-1);
  const offset = x(held) - start.x;
  stopPlaying();
  return {
    edits: true,
    move(place) {
      reveal(clampFrame(frameAt(place.x)), 0);
      const at = place.x + offset;
      const snapped = place.alt ? null : nearest([frame()], at, SNAP_PX);
      carry({ frames, to: stretched(frames, end, snapped ?? frameAt(at), lastFrame()), held, end, copy: false });
    },
    click: () => {},
    end: drop,
    cancel: () => setGrabbed(null),
  };
}

function carry(what) {
  const isSame = what.frames.every((at, i) => at === what.to[i]);
  const taken = isSame ? '' : whyNotAt(what.frames, what.to, what.copy);
  setGrabbed({ kind: 'keys', end: null, ...what, taken, refused: false });
}

function drop() {
  const moved = grabbed();
  if (moved.taken) return putBack(moved);
  setGrabbed(null);
  return retime(moved.frames, moved.to, moved.copy);
}

/** Keys and words for the status bar while keyframes are selected or dragged; else null. */
export function rangeHints() {
  const what = grabbed();
  if (what?.kind === 'box') return [['Shift', 'add to the selection'], ['Esc', 'cancel']];
  if (what?.kind === 'keys') return what.end ? [['Esc', 'cancel']] : [['Shift', 'copy'], ['Esc', 'cancel']];
  if (!selectedKeys().length) return null;
  return [
    ['Drag', 'move'], ['Shift drag', 'copy'], ['Drag an end', 'stretch'], [keyOf('later'), 'one frame'], ['Delete', 'delete'], ['Esc', 'select none'],
  ];
}
