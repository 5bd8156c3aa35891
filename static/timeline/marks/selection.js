// The selected keyframes: a band behind them with a grip at either end, which stretches them; one of them
// drags them all. An edit is sent when the pointer is released.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { keyOf } from '../../actions/actions.js';
import { menuItem } from '../../actions/buttons.js';
import { frame, stopPlaying } from '../../actions/playhead.js';
import { retime, selectedKeys, shifted, stretched, whyNotAt } from '../../actions/selection.js';
import { reveal } from '../../actions/window.js';
import { clamp } from '../../controls/arithmetic.js';
import { heading, line, openMenuAt } from '../../controls/menu.js';
import { count, range } from '../../controls/words.js';
import { clampFrame, lastFrame } from '../../store/clip.js';
import { frameAt, GUTTER, snapped, x } from '../draw/scale.js';
import { diamond, named, plate } from '../draw/glyphs.js';
import { held, putBack } from '../pointer.js';

const AIR = 10;
const REACH_PX = 6;
const GRIP = { wide: 4, high: 16 };
const NONE = [];

/** Those that are shown as selected: none while they are on their way. */
export const chosenKeys = () => (held('keys') ? NONE : selectedKeys());

/** @type {import('../mark.js').Mark} */
export const selection = {
  kind: 'keys',
  row: 'keys',
  layers: [
    { group: 'frames', z: 60, from: () => [chosenKeys()], draw: ({ rows }) => drawBand(rows, chosenKeys()) },
    { group: 'frames', z: 120, from: () => [chosenKeys()], draw: ({ rows }) => drawGrips(rows, chosenKeys()) },
  ],
  hit({ x: px }) {
    const frames = selectedKeys();
    const at = edges(frames);
    const isNearer = (end, one) =>
      x(one) > GUTTER && Math.abs(px - at[end]) <= REACH_PX && Math.abs(px - at[end]) < Math.abs(px - x(one));
    if (at === null) return null;
    if (isNearer('first', frames[0])) return { end: 'first' };
    return isNearer('last', frames.at(-1)) && { end: 'last' };
  },
  cursor: 'ew-resize',
  edits: true,
  /** Times scale about the other end. It snaps to the playhead; Alt: it does not. */
  grab({ end }, start) {
    const frames = selectedKeys();
    const one = end === 'first' ? frames[0] : frames.at(-1);
    const offset = x(one) - start.x;
    return carry(frames, { end, held: one }, (place) =>
      stretched(frames, end, snapped(place.x + offset, place.alt ? [] : [frame()]), lastFrame()),
    );
  },
  menu: (_, { page }) => openSelectionMenu(page),
  tip({ end }, rows) {
    const at = end === 'first' ? selectedKeys()[0] : selectedKeys().at(-1);
    return at === undefined ? nothing : named('Drag to stretch', x(at), rows);
  },
  /** Where they would go; homes stay visible unless copies are made. */
  drag(what, rows) {
    const { frames, to, copy, taken, refused } = what;
    const middle = rows.keys.middle;
    const marks = (list, r) => list.map((at) => diamond(x(at), middle, r)).join('');
    return svg`${drawBand(rows, to)}${drawGrips(rows, to)}${
      copy
        ? nothing
        : svg`<path class="home"
      d=${marks(frames, 4.5)} />`
    }
      <path class=${`moving chosen${taken ? ' taken' : ''}${refused ? ' shake' : ''}`} d=${marks(to, 7)} />
      ${plate(taken || wordsOf(what), clamp(x(to[frames.indexOf(what.held)]), GUTTER, Infinity), middle + 22)}`;
  },
};

/** Grab all selected keyframes at the one at a frame, with Shift or Alt copies of them. */
export function grabKeys(at, start) {
  const frames = selectedKeys();
  const offset = x(at) - start.x;
  return carry(frames, { end: null, held: at }, (place) =>
    shifted(frames, frameAt(place.x + offset) - at, lastFrame()),
  );
}

/** @returns {import('../mark.js').Gesture} */
function carry(frames, what, moved) {
  stopPlaying();
  return {
    move(place) {
      reveal(clampFrame(frameAt(place.x)), 0);
      const to = moved(place);
      const copy = what.end === null && Boolean(place.shift || place.alt);
      const isSame = frames.every((at, i) => at === to[i]);
      return {
        kind: 'keys',
        frames,
        to,
        ...what,
        copy,
        taken: isSame ? '' : whyNotAt(frames, to, copy),
        refused: false,
      };
    },
    end: (there) => (there.taken ? putBack(there) : retime(frames, there.to, there.copy)),
  };
}

/** What is done to all selected keyframes. */
export function openSelectionMenu(page) {
  const title = count(selectedKeys().length, 'keyframe');
  openMenuAt(
    title,
    [
      heading(`${title} selected`),
      menuItem('copyPose'),
      menuItem('deleteKeyframe', undefined, { icon: 'trash' }),
      line,
      menuItem('selectAllKeyframes'),
    ],
    page,
  );
}

/** Left and right edge of the band; null where fewer than two keyframes are selected. At the first
 * frame it keeps clear of the names of the rows. */
function edges(frames) {
  if (frames.length < 2) return null;
  const first = x(frames[0]);
  return { first: first < GUTTER ? first - AIR : Math.max(first - AIR, GUTTER + 2), last: x(frames.at(-1)) + AIR };
}

/** The band lies under the segments: their colours stay as they are. */
function drawBand({ keys }, frames) {
  const at = edges(frames);
  return (
    at &&
    svg`<rect class="selband" x=${at.first} y=${keys.y + 1.5} width=${at.last - at.first} height=${keys.h - 4} rx="4"
      />`
  );
}

function drawGrips({ keys: { y, h } }, frames) {
  const at = edges(frames);
  const grip = (px) =>
    svg`<rect class="selgrip" x=${px - GRIP.wide / 2} y=${y + (h - GRIP.high) / 2} width=${GRIP.wide}
      height=${GRIP.high} rx="2" />`;
  return at && [grip(at.first), grip(at.last)];
}

function wordsOf({ frames, to, end, copy, held: at }) {
  if (end === null) {
    const by = to[0] - frames[0];
    return `${count(frames.length, 'keyframe')} ${by < 0 ? '−' : '+'}${Math.abs(by)}${copy ? ', copied' : ` · ${at} → ${at + by}`}`;
  }
  const percent = Math.round((100 * (to.at(-1) - to[0])) / (frames.at(-1) - frames[0]));
  return `${range(frames[0], frames.at(-1))} → ${range(to[0], to.at(-1))} · ${percent} %`;
}

/** Keys and words for the status bar while keyframes are selected or dragged; else null. */
export function rangeHints() {
  if (held('box')) {
    return [
      ['Shift', 'add to the selection'],
      ['Esc', 'cancel'],
    ];
  }
  if (held('keys')) {
    return held('keys').end
      ? [['Esc', 'cancel']]
      : [
          ['Shift', 'copy'],
          ['Esc', 'cancel'],
        ];
  }
  if (!selectedKeys().length) return null;
  return [
    ['Drag', 'move'],
    ['Shift drag', 'copy'],
    ['Drag an end', 'stretch'],
    [keyOf('later'), 'one frame'],
    ['Delete', 'delete'],
    ['Esc', 'select none'],
  ];
}
