// Notes, pins, and the in and the out point, dragged along the timeline.

import { menuItem } from '../../actions/buttons.js';
import { noteAt } from '../../actions/keying.js';
import { acceptMessage, allPins, showPin, unpin } from '../../actions/pins.js';
import { draftFrames, goTo, keyFrames, stopPlaying } from '../../actions/playhead.js';
import { clearEnd, keepSpan, withEndDragged } from '../../actions/playing.js';
import { clamp } from '../../controls/arithmetic.js';
import { keepsKey } from '../../controls/focus.js';
import { Stroke } from '../../controls/gesture.js';
import { openMenuAt } from '../../controls/menu.js';
import { clampFrame, lastFrame } from '../../store/clip.js';
import { send } from '../../store/link.js';
import { server, setUi, ui } from '../../store/state.js';
import { nearest } from '../draw/keymarks.js';
import { proposalOf } from '../draw/pins.js';
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

const SNAP_PX = 4;

/**
 * The frame meant at a pixel: unless Alt is down a keyframe within 4 px, or where the part begins or
 * ends to stand; else the nearest.
 */
function frameMeant(px, alt, still) {
  const snapped = alt ? null : nearest([...keyFrames(), ...draftFrames(), ...still], px, SNAP_PX);
  return clampFrame(snapped ?? frameAt(px));
}

/** Grab a pin at one of its ends, or whole; the drag is one step of undo. */
export function grabPin({ index, end }, start) {
  const { first, last, part } = allPins()[index];
  const offset = end === 'middle' ? 0 : x(end === 'first' ? first : last) - start.x;
  const still = server.still?.[index] ?? [];
  const stroke = new Stroke('pin', (span) => ({ do: 'change_pin', index, ...span }));
  const over = () => setGrabbed(null);
  stopPlaying();
  return {
    edits: true,
    move(place) {
      setGrabbed({ kind: 'pin', index, end, from: { first, last } });
      if (end === 'middle') stroke.move(shifted({ first, last }, frameAt(place.x) - frameAt(start.x)));
      else stroke.move({ [end]: frameMeant(place.x + offset, place.alt, still) });
    },
    click() {
      setUi('timePin', index);
      showPin({ part }, clamp(clampFrame(frameAt(start.x)), first, last));
    },
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

function shifted({ first, last }, by) {
  const shift = clamp(Math.round(by), -first, lastFrame() - last);
  return { first: first + shift, last: last + shift };
}

/** Press what is proposed: a click goes there. */
export function grabProposal(what, start) {
  const pin = proposalOf(what);
  stopPlaying();
  const nothingMoves = () => {};
  return {
    move: nothingMoves,
    click: () => pin && showPin(pin, clamp(clampFrame(frameAt(start.x)), pin.first, pin.last)),
    end: nothingMoves,
    cancel: nothingMoves,
  };
}

export function acceptAt(what) {
  const pin = proposalOf(what);
  if (pin) send(acceptMessage(pin));
}

/** Keys and words for the status bar while the pointer is at a pin, or pulls it; else null. */
export function pinHints() {
  const isPin = ui.timeGrabbed?.kind === 'pin' || ui.timeHover?.kind === 'pin';
  if (ui.timeGrabbed?.kind === 'pin') return [['Alt', 'free, no snapping'], ['Esc', 'cancel']];
  return isPin ? [['Drag an end', 'trim the pin'], ['Drag', 'move it'], ['Click', 'go there'], ['Delete', 'unpin the one clicked']] : null;
}

/** The chosen pin's keys: Delete unpins it, Esc lets go of it. */
export function listenForPinKeys() {
  addEventListener('pointerdown', () => setUi('timePin', null), true);
  addEventListener('keydown', (event) => {
    if (ui.timePin == null || !allPins()[ui.timePin] || keepsKey(event.key)) return;
    if (event.key === 'Delete' || event.key === 'Backspace') unpin(ui.timePin);
    else if (event.key !== 'Escape') return;
    setUi('timePin', null);
    event.preventDefault();
    event.stopImmediatePropagation();
  }, true);
}

/** The timeline gets its row with the first pin or proposal, once, and never under a pressed pointer. */
export function followPins(hasPins) {
  const { dataset } = document.documentElement;
  const wanted = hasPins && server.file ? 'yes' : 'no';
  if (dataset.pins === wanted) return;
  if (isPointerDown) onRelease = () => followPins(hasPins);
  else dataset.pins = wanted;
}

let isPointerDown = false;
/** @type {() => void} */
let onRelease = () => {};

export function watchPointer() {
  addEventListener('pointerdown', () => (isPointerDown = true), true);
  const up = () => {
    isPointerDown = false;
    onRelease();
    onRelease = () => {};
  };
  for (const kind of ['pointerup', 'pointercancel']) addEventListener(kind, up, true);
}


/** Grab the in point ("first") or the out point ("last"). It snaps to keyframes; Alt: it does not. */
export function grabSpanEnd(end, start) {
  const before = ui.span;
  const offset = x(before[end]) - start.x;
  return {
    move(place) {
      const at = place.x + offset;
      const snapped = place.alt ? null : nearest(keyFrames(), at, SNAP_PX);
      setUi('span', withEndDragged(before, end, snapped ?? frameAt(at)));
      setGrabbed({ kind: 'span', end });
    },
    click: () => {},
    end() {
      setGrabbed(null);
      keepSpan(ui.span);
    },
    cancel() {
      setGrabbed(null);
      setUi('span', before);
    },
  };
}

export function openSpanMenu(end, page) {
  const word = end === 'first' ? 'In' : 'Out';
  openMenuAt(`${word} point ${ui.span[end]}`, [
    menuItem('goTo', ui.span[end]),
    { icon: 'x', label: `Clear the ${word.toLowerCase()} point`, run: () => clearEnd(end) },
    menuItem('clearSpan'),
    menuItem('loop'),
  ], page);
}
