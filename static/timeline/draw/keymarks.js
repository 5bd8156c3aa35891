// The keyframes as diamonds, those of parts half filled.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { partKeyAt, partKeys } from '../../actions/parts.js';
import { isSoft } from '../../actions/pins.js';
import { draftFrames, frame, isKey, keyFrames, suggestedFrame } from '../../actions/playhead.js';
import { isReviewing } from '../../actions/review.js';
import { clamp } from '../../controls/arithmetic.js';
import { server } from '../../store/state.js';
import { singleDrafts } from './drafts.js';
import { GUTTER, right, visible, x } from './scale.js';
import { extent, numbers } from './series.js';

const PART_RADIUS = 7.5;
const PART_REACH = 11;

/**
 * How a part keyframe is filled: below the middle in its limb's colour, of two limbs left and right in
 * theirs, of more in that of the trunk. [side, path] for each colour, about a point.
 * @param {{ side: string }[]} limbs
 * @returns {['L' | 'R' | 'C', string][]}
 */
export function fillsOf(limbs, cx, cy, r) {
  const side = (limb) => /** @type {'L' | 'R' | 'C'} */ (limb.side);
  if (limbs.length === 2) {
    return [
      [side(limbs[0]), `M${cx} ${cy - r}l${-r} ${r} ${r} ${r}z`],
      [side(limbs[1]), `M${cx} ${cy - r}l${r} ${r}-${r} ${r}z`],
    ];
  }
  return [[limbs.length === 1 ? side(limbs[0]) : 'C', `M${cx - r} ${cy}h${2 * r}l${-r} ${r}z`]];
}

/** The outline in as many colours: whole, or a half for each of two limbs. */
function outlinesOf(fills, cx, cy, r) {
  if (fills.length === 1) return [[fills[0][0], `M${cx} ${cy - r}l${r} ${r}-${r} ${r}-${r}-${r}z`]];
  return [
    [fills[0][0], `M${cx} ${cy - r}l${-r} ${r} ${r} ${r}`],
    [fills[1][0], `M${cx} ${cy - r}l${r} ${r}-${r} ${r}`],
  ];
}

/** One mark about a point. */
function partMark(limbs, cx, cy, kind = '') {
  const fills = fillsOf(limbs, cx, cy, PART_RADIUS);
  return svg`<g class=${`partkey ${kind}`}>
    <path class="ground" d=${`M${cx} ${cy - PART_RADIUS}l${PART_RADIUS} ${PART_RADIUS}-${PART_RADIUS} ${PART_RADIUS}-${PART_RADIUS}-${PART_RADIUS}z`} />
    ${fills.map(([side, d]) => svg`<path class=${`fill ${side}`} d=${d} />`)}
    ${outlinesOf(fills, cx, cy, PART_RADIUS).map(([side, d]) => svg`<path class=${`line ${side}`} d=${d} />`)}</g>`;
}

/** All of them, but for those that are on their way elsewhere. */
export function drawPartKeys(rows, without = []) {
  const { first, last } = visible();
  const seen = partKeys().filter((key) => key.frame >= first - 1 && key.frame <= last + 1);
  return seen.filter((key) => !without.includes(key.frame)).map((key) => partMark(key.limbs, x(key.frame), rows.keys.middle));
}

/** The one under the playhead, ringed in the accent. */
export function drawCurrentPart(rows) {
  const key = partKeyAt(frame());
  return key ? partMark(key.limbs, x(key.frame), rows.keys.middle, 'current') : null;
}

/** The frame of the part keyframe at a pixel, or null. */
export function partNear(px) {
  if (px < GUTTER || px > right() + PART_RADIUS) return null;
  const apart = (key) => Math.abs(x(key.frame) - px);
  const near = partKeys().filter((key) => apart(key) <= PART_REACH).sort((a, b) => apart(a) - apart(b));
  return near[0]?.frame ?? null;
}

const RADIUS = 6.5;
const CURRENT = 8;
const CLOSE_PX = 10;

/** How much room each of some frames has to its nearest neighbour, in pixels. */
function rooms(frames) {
  const at = frames.map(x);
  return at.map((here, i) => Math.min(here - (at[i - 1] ?? -1e9), (at[i + 1] ?? 1e9) - here));
}

/** Keys as diamonds, and as ticks where they stand closer than 10 px: [{frame, room}, ...]. */
function marksOf(frames) {
  const room = rooms(frames);
  const marks = frames.map((at, i) => ({ frame: at, room: room[i] }));
  return {
    diamonds: marks.filter((mark) => mark.room >= CLOSE_PX),
    ticks: marks.filter((mark) => mark.room < CLOSE_PX),
  };
}

/** The frames of those keys that have room for a diamond. */
export function withRoom(frames) {
  return marksOf(frames).diamonds.map((mark) => mark.frame);
}

/** Diamonds shrink, and ticks get thinner, so that the bars between them are still seen. */
function radiusFor(room) {
  return clamp(room * 0.27, 3.5, RADIUS);
}

function tickWidth(room) {
  return clamp(room / 3, 0.5, 3);
}

function inWindow(frames) {
  const { first, last } = visible();
  return frames.filter((at) => at >= first - 1 && at <= last + 1);
}

/** The keyframes, but those at the frames `without`; those chosen look so. */
export function drawKeys(rows, without = [], selected = []) {
  const [gone, chosen] = [new Set(without), new Set(selected)];
  const middle = rows.keys.middle;
  const { diamonds, ticks } = marksOf(inWindow(keyFrames()));
  const here = (mark) => !gone.has(mark.frame);
  const isChosen = (mark) => chosen.has(mark.frame);
  const large = ({ frame: at, room }) => diamond(x(at), middle, radiusFor(room));
  const small = ({ frame: at, room }) => {
    const wide = tickWidth(room);
    return `M${(x(at) - wide / 2).toFixed(1)} ${middle - 8}h${wide}v16h${-wide}z`;
  };
  const isExact = (mark) => !isSoft(mark.frame);
  const soft = diamonds.filter((mark) => here(mark) && !isExact(mark));
  const drafts = inWindow(singleDrafts()).map((at) => diamond(x(at), middle, RADIUS));
  return svg`<path class="keymark" d=${diamonds.filter(here).filter(isExact).map(large).join('')} />
    <path class="keymark soft" d=${soft.map(large).join('')} />
    <path class="keymark tick" d=${ticks.filter(here).map(small).join('')} />
    <path class="keymark chosen" d=${diamonds.filter(here).filter(isChosen).map(large).join('')} />
    <path class="keymark tick chosen" d=${ticks.filter(here).filter(isChosen).map(small).join('')} />
    <path class="draft" d=${drafts.join('')} />`;
}

/** The suggested key: a dashed diamond with a plus, and a dashed line through all rows. */
export function drawSuggestion(rows, height) {
  const at = isReviewing() ? null : suggestedFrame();
  if (at === null || isKey(at) || draftFrames().includes(at)) return nothing;
  const there = x(at);
  const middle = rows.keys.middle;
  // Before the first key the line would say no more than the playhead does.
  const through = keyFrames().length > 0 ? `M${there} ${rows.top}V${height}` : '';
  const plus = `M${there - 3.5} ${middle}h7M${there} ${middle - 3.5}v7`;
  return svg`<path class="s-acc through" d=${through} />
    <path class="suggested" d=${diamond(there, middle, 9)} /><path class="s-acc plus" d=${plus} />`;
}

/** The key under the playhead, in the accent; hollow while it is a draft, outlined while it is chosen. */
export function drawCurrent(rows, chosen = []) {
  const at = frame();
  if (isKey(at)) {
    return svg`<path class=${`keymark current${isSoft(at) ? ' soft' : ''}${chosen.includes(at) ? ' chosen' : ''}`} d=${diamond(x(at), rows.keys.middle, CURRENT)} />`;
  }
  if (!draftFrames().includes(at)) return nothing;
  return svg`<path class="draft current" d=${diamond(x(at), rows.keys.middle, CURRENT - 1)} />`;
}

/** The key at a pixel, or null. Ticks stand close: they are caught within 3 px only. */
export function keyNear(px) {
  if (px < GUTTER || px > right() + CURRENT) return null;
  const { diamonds, ticks } = marksOf(inWindow(keyFrames()));
  const frames = (marks) => marks.map((mark) => mark.frame);
  return nearest(frames(diamonds), px, 11) ?? nearest(frames(ticks), px, 3);
}

/** The nearest of some frames within so many pixels, or null. */
export function nearest(frames, px, reach) {
  let best = null;
  let least = reach;
  for (const at of frames) {
    const apart = Math.abs(x(at) - px);
    if (apart <= least) [best, least] = [at, apart];
  }
  return best;
}

/** A diamond about a point, as path data. */
export function diamond(cx, cy, r) {
  return `M${cx} ${cy - r}l${r} ${r}-${r} ${r}-${r}-${r}z`;
}

const HIGH = 8;

/** The suggested key stands at the top of the hill; without one there is nothing to explain. */
export function drawNeed(rows) {
  const need = numbers(server.need);
  const most = server.suggest?.kind === 'key' ? extent(need)?.high : null;
  if (!(most > 0)) return nothing;
  const foot = rows.keys.y + rows.keys.h - 1;
  // A lost stretch needs it a hundred times more than others, which still have their hill.
  const top = (value) => foot - HIGH * Math.sqrt(value / most);
  return svg`<path class="need" d=${hills(need, foot, top)}>
    <title>Expected improvement from a keyframe here</title></path>`;
}

function hills(need, foot, top) {
  const { first, last } = visible();
  const from = Math.max(0, Math.floor(first) - 1);
  const to = Math.min(need.length - 1, Math.ceil(last) + 1);
  let path = '';
  let open = false;
  for (let at = from; at <= to; at += 1) {
    const known = !Number.isNaN(need[at]);
    if (known) path += `${open ? 'L' : `M${x(at).toFixed(1)} ${foot}L`}${x(at).toFixed(1)} ${top(need[at]).toFixed(1)}`;
    else if (open) path += `V${foot}Z`;
    open = known;
  }
  return open ? `${path}V${foot}Z` : path;
}
