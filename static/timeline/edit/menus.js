// The two menus of the timeline: of a key, and of a segment with its verdict in a sentence.

import { html, nothing } from '../../vendor/lit-html/lit-html.js';
import { menuItem } from '../../actions/buttons.js';
import { contextEntries } from '../../actions/context_menus.js';
import { noteAt, noteAsOneLine, placeForCopy } from '../../actions/keying.js';
import { partKeyAt } from '../../actions/parts.js';
import { frame, segmentAt } from '../../actions/playhead.js';
import { selectedKeys } from '../../actions/selection.js';
import { allPins, framesOf } from '../../actions/pins.js';
import { icon } from '../../controls/icons.js';
import { content, heading, line, openMenuAt } from '../../controls/menu.js';
import { count, range, VERDICTS } from '../../controls/words.js';
import { lastFrame, words as subject } from '../../store/clip.js';

export function openKeyMenu(at, page) {
  if (partKeyAt(at)) {
    openPartKeyMenu(partKeyAt(at), page);
    return;
  }
  openMenuAt(`Keyframe ${at}`, [
    menuItem('goTo', at),
    menuItem('duplicateKeyframe', at, { ask: { value: placeForCopy(at), last: lastFrame(), answer: 'Duplicate' } }),
    menuItem('softKey', at),
    ...contextEntries('keyframe', { copyKeyHere: at, note: at }), line,
    menuItem('deleteKeyframe', at, { icon: 'trash', ...elsewhere(at === frame()) }),
  ], page);
}

function openPartKeyMenu({ frame: at, limbs, words }, page) {
  const several = limbs.length > 1 ? limbs : [];
  openMenuAt(`Part keyframe ${at}`, [
    heading(`Part keyframe ${at} · ${words}`),
    menuItem('goTo', at),
    menuItem('keyWhole', at),
    ...several.map((limb) => menuItem('unkeyLimb', { frame: at, ...limb })),
    menuItem('duplicateKeyframe', at, { ask: { value: placeForCopy(at), last: lastFrame(), answer: 'Duplicate' } }),
    ...contextEntries('partKeyframe', { note: at }), line,
    menuItem('deleteKeyframe', at, { icon: 'trash', ...elsewhere(at === frame()) }),
  ], page);
}

/** What is done to all selected keyframes. */
export function openSelectionMenu(page) {
  const title = count(selectedKeys().length, 'keyframe');
  openMenuAt(title, [
    heading(`${title} selected`), menuItem('copyPose'), menuItem('deleteKeyframe', undefined, { icon: 'trash' }), line, menuItem('selectAllKeyframes'),
  ], page);
}

export function openPinMenu(index, page) {
  const pin = allPins()[index];
  const { keyframe } = pin;
  openMenuAt(`${pin.label} ${framesOf(pin)}`, [
    heading(`${pin.label} · pinned ${framesOf(pin)}`),
    pin.problem ? content(html`<div class="says check">${icon('warn')}<span>${pin.problem}</span></div>`) : null,
    ...(keyframe === null ? [] : [menuItem('softKey', keyframe), menuItem('splitPin', { index, frame: keyframe }), menuItem('goTo', keyframe)]),
    menuItem('unpin', index, { right: framesOf(pin) }),
  ], page);
}

export function openProposalMenu(pin, page) {
  openMenuAt(`${pin.label} ${framesOf(pin)}`, [
    heading(`${pin.label} · proposed ${framesOf(pin)}`), menuItem('acceptPins', pin), menuItem('dismissPins', pin), line,
    menuItem('acceptPins'),
  ], page);
}

export function openSegmentMenu(segment, page, at = frame()) {
  const { first, last, state } = segment;
  const frames = range(first, last);
  const busy = state === 'tracking' || state === 'waiting';
  const go = segment.go ?? null;
  const isHere = segmentAt(frame())?.first === first;
  openMenuAt(`Segment ${frames}`, [
    content(sentence(state, frames, wordsOf(segment))),
    content(notes(segment.notes ?? [])),
    busy ? menuItem('cancel') : menuItem('trackThis', segment, { icon: 'track', ...elsewhere(isHere) }),
    go === null ? null : menuItem('goTo', go),
    menuItem('zoomToSegment', segment), line,
    ...contextEntries('segment', { note: at }),
  ], page);
}

/** Of an empty place: what can be done at its frame. */
export function openFramesMenu(at, page) {
  openMenuAt(`Frame ${at}`, [heading(`Frame ${at}`), ...contextEntries('frames', { goTo: at, note: at })], page);
}

export function openNoteMenu(at, page) {
  const note = noteAt(at);
  if (!note) return;
  openMenuAt(`Note at ${at}`, [heading(`Frame ${at} · ${noteAsOneLine(note)}`), ...contextEntries('note', { goTo: at, note: at, deleteNote: at })], page);
}

/** A key acts at the playhead: for what lies elsewhere none is shown. */
const elsewhere = (isHere) => (isHere ? {} : { right: '' });

/** What a verdict says, above what can be done about it. */
const sentence = (state, frames, words) =>
  html`<div class=${`says ${state}`}>${icon(state === 'none' ? 'track' : VERDICTS[state].sign)}<span><b>${frames}</b> ${words}</span></div>`;

/** What else is to be known of it, in small. */
function notes(list) {
  if (list.length === 0) return nothing;
  return html`<div class="says note"><div>${list.map((words) => html`<div>${words}</div>`)}</div></div>`;
}

function wordsOf({ state, words }) {
  return state === 'tracking' ? `${subject().doing}, ${words}` : words || `Not ${subject().done}`;
}
