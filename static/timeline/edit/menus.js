// The two menus of the timeline: of a key, and of a segment with its verdict in a sentence.

import { html, nothing } from '../../vendor/lit-html/lit-html.js';
import { send } from '../../store/link.js';
import { words as subject } from '../../store/subject.js';
import { lastFrame } from '../draw/scale.js';
import { frame, goTo, isKey, keyFrames } from './head.js';
import { icon } from '../../controls/icons.js';
import { content, openMenuAt } from '../../controls/menu.js';
import { deleteKey } from './keying.js';
import { zoomTo } from './zoom.js';

const SIGNS = {
  good: 'check', check: 'warn', lost: 'lost',
  outdated: 'old', waiting: 'old', tracking: 'run', none: 'track',
};

export function openKeyMenu(at, page) {
  const copyTo = (to) => {
    send({ do: 'duplicate_key', frame: at, to });
    goTo(to);
  };
  openMenuAt(`Keyframe ${at}`, [
    { icon: 'flag', label: `Go to ${at}`, run: () => goTo(at) },
    { icon: 'copy', label: 'Duplicate to', ask: { value: placeForCopy(at), last: lastFrame() }, run: copyTo },
    {
      icon: 'trash', label: 'Delete keyframe', right: at === frame() ? 'Delete' : '',
      run: () => deleteKey(at),
    },
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
  openMenuAt(`Segment ${range}`, [
    content(sentence(state, range, wordsOf(segment))),
    content(notes(segment.notes ?? [])),
    busy
      ? { icon: 'x', label: 'Cancel', right: 'Esc', run: () => send({ do: 'cancel' }) }
      : { icon: 'track', label: `${subject().verb} this`, right: 'Shift T', run: () => trackThis(segment) },
    go === null ? null : { icon: 'flag', label: `Go to ${go}`, run: () => goTo(go) },
    { icon: 'grow', label: 'Zoom to it', right: 'Z', run: () => zoomTo(first, last) },
  ], page);
}

/** What a verdict says, above what can be done about it. */
const sentence = (state, range, words) =>
  html`<div class=${`says ${state}`}>${icon(SIGNS[state])}<span><b>${range}</b> ${words}</span></div>`;

/** What else is to be known of it, in small. */
function notes(list) {
  if (list.length === 0) return nothing;
  return html`<div class="says note"><span>${list.map((words) => html`${upper(words)}<br />`)}</span></div>`;
}

const upper = (words) => words.charAt(0).toUpperCase() + words.slice(1);

function wordsOf({ state, words }) {
  return state === 'tracking' ? `${subject().doing}, ${words}` : words || `Not ${subject().done}`;
}

/** "This" is the segment of the playhead: it goes in first, should it have moved meanwhile. */
function trackThis({ first, last }) {
  if (frame() < first || frame() >= last) goTo(first);
  send({ do: 'track', what: 'this' });
}
