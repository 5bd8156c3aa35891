// The keyframes: diamonds, drafts hollow, the suggested one dashed with a plus; and along the foot of
// their row, as a low hill, what one keyframe more would mend at each frame.

import { clamp } from '../../controls/arithmetic.js';
import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { singleDrafts } from './drafts.js';
import { GUTTER, right, visible, x } from './scale.js';
import { draftFrames, frame, isKey, keyFrames, suggestedFrame } from '../../actions/playhead.js';
import { isSoft } from '../../actions/pins.js';
import { isReviewing } from '../../actions/review.js';
import { extent, numbers } from './series.js';

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

export function drawKeys(rows, without = null) {
  const middle = rows.keys.middle;
  const { diamonds, ticks } = marksOf(inWindow(keyFrames()));
  const here = (mark) => mark.frame !== without;
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

/** The key under the playhead, in the accent; hollow while it is a draft. */
export function drawCurrent(rows) {
  const at = frame();
  if (isKey(at)) {
    return svg`<path class=${`keymark current${isSoft(at) ? ' soft' : ''}`} d=${diamond(x(at), rows.keys.middle, CURRENT)} />`;
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
