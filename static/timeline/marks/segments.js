// The bars between the keys: state as colour, pattern and word.

import { html, nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { menuItem } from '../../actions/buttons.js';
import { contextEntries } from '../../actions/context_menus.js';
import { partKeys } from '../../actions/parts.js';
import { frame, segmentAt, suggestedFrame } from '../../actions/playhead.js';
import { clamp } from '../../controls/arithmetic.js';
import { icon } from '../../controls/icons.js';
import { content, line, openMenuAt } from '../../controls/menu.js';
import { range, VERDICTS } from '../../controls/words.js';
import { clampFrame, lastFrame, words as subject } from '../../store/clip.js';
import { server } from '../../store/state.js';
import { BAR, frameAt, GUTTER, right, seenOf, x } from '../draw/scale.js';
import { singleDrafts } from './drafts.js';
import { elsewhere } from './keyframes.js';
import { clickRow, grabBox } from './keys_row.js';

/** @type {import('../mark.js').Mark} */
export const segment = {
  kind: 'segment',
  row: 'keys',
  layers: [
    {
      group: 'frames',
      z: 80,
      from: () => [server.segments, server.suggest, server.keys],
      draw: ({ rows }) => drawSegments(rows.keys.middle),
    },
  ],
  hit({ x: px, y }, { rows }) {
    if (Math.abs(y - rows.keys.middle) > BAR.half + 3) return null;
    const there = all().find((one) => px >= barOf(one).from - 1 && px <= barOf(one).to + 1);
    return there && { first: there.first };
  },
  cursor: 'pointer',
  grab: grabBox,
  click(what, place) {
    clickRow(what, place);
    openSegmentMenu(startingAt(what.first), place.page);
  },
  menu: ({ first }, { x: px, page }) => openSegmentMenu(startingAt(first), page, clampFrame(frameAt(px))),
  tip({ first }, { keys: { middle } }) {
    const there = startingAt(first);
    if (!there) return nothing;
    const { from, to } = barOf(there);
    return svg`<rect class="hover" x=${from - 1.5} y=${middle - BAR.half - 1.5} rx="4"
      width=${Math.max(1, to - from) + 3} height=${2 * BAR.half + 3} />`;
  },
};

const all = () => server.segments ?? [];
const startingAt = (first) => all().find((one) => one.first === first);

const BESIDE_DIAMOND = 8;
const FILLS = { check: 'url(#tl-check)', lost: 'url(#tl-lost)' };

/** Left and right end of a segment's bar; it keeps clear of the diamonds. */
function barOf({ first, last }) {
  const [from, to] = [x(first), x(last)];
  const beside = Math.min(BESIDE_DIAMOND, (to - from) * 0.32);
  return { from: from + beside, to: to - beside };
}

function drawSegments(middle) {
  const seen = seenOf(all());
  return svg`<path class="s-tick dotted" d=${untouched(middle)} />
    ${seen.map((one) => drawSegment(one, middle))}${seen.map((one) => drawWord(one, middle))}`;
}

/** The dotted line where no segment is: before the first key, after the last, or everywhere. */
function untouched(middle) {
  const segments = all();
  const across = (from, to) => (to - from > 4 ? `M${from} ${middle + 0.5}H${to}` : '');
  if (segments.length === 0) return across(x(0) + 8, x(lastFrame()));
  return across(x(0), x(segments[0].first) - 8) + across(x(segments.at(-1).last) + 8, x(lastFrame()));
}

function drawSegment(one, middle) {
  const { from, to } = barOf(one);
  const wide = Math.max(1, to - from);
  const round = Math.min(3, wide / 2);
  const top = middle - BAR.half;
  const high = 2 * BAR.half;
  const bar = (classes, fill) => svg`<rect class=${classes} x=${from} y=${top} width=${wide}
    height=${high} rx=${round} fill=${fill} />`;
  switch (one.state) {
    case 'none':
      return nothing;
    case 'outdated':
    case 'waiting':
      return wide < 6
        ? bar('f-old faint', nothing)
        : svg`<rect class=${`hollow ${one.state}`} x=${from + 0.5} y=${top + 0.5}
            width=${wide - 1} height=${high - 1} rx=${round} />`;
    case 'tracking':
      return svg`${bar('tracking', nothing)}
        <rect x=${from} y=${top} width=${(wide * clamp((one.percent ?? 0) / 100, 0, 1)).toFixed(1)} height=${high}
          rx=${round} fill="url(#tl-track)" />`;
    case 'good':
      return bar('f-good bar', nothing);
    default:
      return bar('', FILLS[one.state] ?? 'none');
  }
}

/** The word a segment carries; good needs none. */
function wordOf({ state, percent }) {
  if (state === 'tracking') return `${Math.round(percent ?? 0)} %`;
  return state === 'good' ? '' : VERDICTS[state].word;
}

const INKS = { tracking: 'f-track', outdated: 'f-old', waiting: 'f-old' };

function drawWord(one, middle) {
  const word = wordOf(one);
  const { from, to } = barOf(one);
  const wide = word.length * 6 + 14;
  const at = word === '' ? null : freePlace(Math.max(from, GUTTER), Math.min(to, right()), wide);
  if (at === null) return nothing;
  return svg`<rect class="f-panel" x=${at - wide / 2} y=${middle - 8} width=${wide} height="16" rx="8" />
    <text class=${`word ${INKS[one.state] ?? `f-${one.state}`}`} x=${at} y=${middle + 4}
      text-anchor="middle">${word}</text>`;
}

/**
 * The middle, or beside it where a diamond stands there. Null where no place is free: then the
 * pattern alone shows the state.
 */
function freePlace(from, to, wide) {
  if (to - from < wide + 8) return null;
  const suggested = suggestedFrame();
  const diamonds = [
    ...singleDrafts(),
    ...partKeys().map((key) => key.frame),
    ...(suggested === null ? [] : [suggested]),
  ].map(x);
  const isFree = (at) =>
    at - wide / 2 >= from && at + wide / 2 <= to && diamonds.every((there) => Math.abs(there - at) > wide / 2 + 10);
  const places = [0.5, 0.24, 0.76].map((part) => from + (to - from) * part);
  return places.find(isFree) ?? null;
}

/** What its verdict says, and what can be done about it. */
export function openSegmentMenu(one, page, at = frame()) {
  if (!one) return;
  const { state, go = null, notes = [] } = one;
  const frames = range(one.first, one.last);
  const busy = state === 'tracking' || state === 'waiting';
  const isHere = segmentAt(frame())?.first === one.first;
  openMenuAt(
    `Segment ${frames}`,
    [
      content(
        html`<div class=${`says ${state}`}>${icon(
          state === 'none' ? 'track' : VERDICTS[state].sign,
        )}<span><b>${frames}</b> ${sentenceOf(one)}</span></div>`,
      ),
      notes.length
        ? content(html`<div class="says note"><div>${notes.map((words) => html`<div>${words}</div>`)}</div></div>`)
        : null,
      busy ? menuItem('cancel') : menuItem('trackThis', one, { icon: 'track', ...elsewhere(isHere) }),
      go === null ? null : menuItem('goTo', go),
      menuItem('zoomToSegment', one),
      line,
      ...contextEntries('segment', { note: at }),
    ],
    page,
  );
}

function sentenceOf({ state, words }) {
  return state === 'tracking' ? `${subject().doing}, ${words}` : words || `Not ${subject().done}`;
}
