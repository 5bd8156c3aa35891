// The two menus of the timeline: of a key, and of a segment with its verdict in a sentence.

import { nothing } from '../../vendor/lit-html/lit-html.js';
import { send } from '../../store/link.js';
import { words as subject } from '../../store/subject.js';
import { lastFrame } from '../draw/scale.js';
import { frame, goTo } from './head.js';
import { field, item, notes, open, sentence } from '../../controls/menu.js';
import { deleteKey } from './keying.js';
import { isKey, keyFrames } from './moves.js';
import { zoomTo } from './zoom.js';

const SIGNS = {
  good: 'check', check: 'warn', lost: 'lost',
  outdated: 'old', waiting: 'old', tracking: 'run', none: 'track',
};

export function openKeyMenu(at, page) {
  open(`Keyframe ${at}`, [
    item('flag', `Go to ${at}`, '', () => goTo(at)),
    field('copy', 'Duplicate to', placeForCopy(at), lastFrame(), (to) => {
      send({ do: 'duplicate_key', frame: at, to });
      goTo(to);
    }),
    item('trash', 'Delete keyframe', at === frame() ? 'Delete' : '', () => deleteKey(at)),
  ], page);
}

/** Where a copy most likely goes: under the playhead, or half-way to the next key. */
function placeForCopy(at) {
  if (!isKey(frame())) return frame();
  const next = keyFrames().find((key) => key > at) ?? lastFrame();
  return Math.round((at + next) / 2);
}

export function openSegmentMenu(segment, page) {
  const { first, last, state } = segment;
  const range = `${first}–${last}`;
  const busy = state === 'tracking' || state === 'waiting';
  const go = segment.go ?? null;
  open(`Segment ${range}`, [
    sentence(SIGNS[state], state, range, wordsOf(segment)),
    notes(segment.notes ?? []),
    busy
      ? item('x', 'Cancel', 'Esc', () => send({ do: 'cancel' }))
      : item('track', `${subject().verb} this`, 'Shift T', () => trackThis(segment)),
    go === null ? nothing : item('flag', `Go to ${go}`, '', () => goTo(go)),
    item('grow', 'Zoom to it', 'Z', () => zoomTo(first, last)),
  ], page);
}

function wordsOf({ state, words }) {
  return state === 'tracking' ? `${subject().doing}, ${words}` : words || `Not ${subject().done}`;
}

/** "This" is the segment of the playhead: it goes in first, should it have moved meanwhile. */
function trackThis({ first, last }) {
  if (frame() < first || frame() >= last) goTo(first);
  send({ do: 'track', what: 'this' });
}
