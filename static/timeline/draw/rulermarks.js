// Marks along the ruler: notes, places to review, a reduction's keyframes, in and out points.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { allNotes } from '../../actions/keying.js';
import { isKey } from '../../actions/playhead.js';
import { hasSpan } from '../../actions/playing.js';
import { isReviewing, place, places } from '../../actions/review.js';
import { answerOf } from '../../actions/review_list.js';
import { clamp } from '../../controls/arithmetic.js';
import { server, ui } from '../../store/state.js';
import { diamond, nearest } from './keymarks.js';
import { GUTTER, right, RULER, visible, x } from './scale.js';

const NOTE_HALF = 3.5;
const HIGH = 8;
const REACH_PX = 7;

/** Standing on the line below the ruler, its point down. */
export const noteMark = (at, half = NOTE_HALF, high = HIGH) => {
  const foot = RULER - 1;
  return `M${(at - half).toFixed(1)} ${foot - high}h${2 * half}v${high - half}l${-half} ${half}l${-half} ${-half}z`;
};

export function drawNotes(without = null) {
  const { first, last } = visible();
  const seen = allNotes().filter((note) => note.frame >= first - 1 && note.frame <= last + 1 && note.frame !== without);
  if (!seen.length) return nothing;
  const marks = (notes) => notes.map((note) => noteMark(x(note.frame))).join('');
  return svg`<path class="note" d=${marks(seen.filter(({ text }) => text))} />
    <path class="note bare" d=${marks(seen.filter(({ text }) => !text))} />`;
}

/** The frame of the note at a place, or null. */
export function noteMarkAt({ x: px, y }) {
  if (y < RULER - HIGH - 3 || y > RULER + 1) return null;
  return nearest(allNotes().map((note) => note.frame), px, REACH_PX);
}

const PLACE_HALF = 4;
const PLACE_REACH = 7;

/** Those that wait for an answer, while they are reviewed or the review was left. */
function open() {
  if (!isReviewing()) return ui.reviewLeft ? places() : [];
  return places().filter(({ id }) => !answerOf(ui.review, id));
}

export function drawReviewPlaces() {
  const { first, last } = visible();
  const seen = open().filter(({ frame }) => frame >= first && frame <= last);
  return seen.map(({ id, frame }) => {
    const at = x(frame);
    return svg`<path class="review-place ${id === place()?.id ? 'on' : ''}"
      d=${`M${at - PLACE_HALF} ${RULER + 1}h${2 * PLACE_HALF}l${-PLACE_HALF} ${PLACE_HALF + 2}z`} />`;
  });
}

/** The place whose triangle is at a pixel, or null. */
export function reviewPlaceNear(px, py) {
  if (py < RULER - 2 || py > RULER + 2 * PLACE_HALF + 2) return null;
  const near = open().filter(({ frame }) => Math.abs(x(frame) - px) <= PLACE_REACH);
  return near.sort((a, b) => Math.abs(x(a.frame) - px) - Math.abs(x(b.frame) - px))[0] ?? null;
}

const RADIUS = 6;
const LEAST_RADIUS = 2.5;

export function drawReduced(rows) {
  if (!server.reduction) return nothing;
  const { first, last } = visible();
  const frames = server.reduction.frames.filter((at) => first - 1 <= at && at <= last + 1 && !isKey(at));
  const marks = frames.map((at, i) => diamond(x(at), rows.keys.middle, radiusAt(frames, i)));
  return svg`<path class="reduced" d=${marks.join('')}><title>Keyframes of the reduction</title></path>`;
}

/** As large as its neighbours leave room for. */
function radiusAt(frames, i) {
  const room = Math.min(...[frames[i - 1], frames[i + 1]].filter((one) => one !== undefined).map((one) => Math.abs(x(one) - x(frames[i]))));
  return Math.min(RADIUS, Math.max(LEAST_RADIUS, room * 0.45));
}

const MARGIN = 26;
const TOP = 3;
const SPAN_REACH = 9;

export function drawSpan(height) {
  if (!hasSpan()) return nothing;
  const { first, last } = ui.span;
  const end = right() + MARGIN;
  const [from, to] = [first === null ? GUTTER : clamp(x(first), GUTTER, end), last === null ? end : clamp(x(last), GUTTER, end)];
  const shade = (left, wide) => (wide > 0
    ? svg`<rect class="outside ruler" x=${left} y="0" width=${wide} height=${RULER} />
      <rect class="outside" x=${left} y=${RULER} width=${wide} height=${Math.max(0, height - RULER)} />`
    : nothing);
  return svg`${first === null ? nothing : shade(GUTTER, from - GUTTER)}${last === null ? nothing : shade(to, end - to)}
    <rect class="within" x=${from} y=${RULER - 3} width=${Math.max(0, to - from)} height="3" />
    ${isSeen(first) ? bracket(from, -1, `In point ${first}`) : nothing}${isSeen(last) ? bracket(to, 1, `Out point ${last}`) : nothing}`;
}

function isSeen(frame) {
  const seen = visible();
  return frame !== null && frame >= seen.first && frame <= seen.last;
}

/** A bracket that stands outside its frame, so that the playhead on it can still be grabbed. */
const bracket = (at, side, title) => svg`<path class="spanend" d=${`M${at} ${TOP}h${side * 6}V${RULER}h${-side * 6}v-3h${side * 3}V${TOP + 3}h${-side * 3}z`}><title>${title}</title></path>`;

/** "first" or "last": the end of the span at a place of the ruler; null beside both. */
export function spanEndAt({ x: px, y }) {
  if (y >= RULER || y < 0) return null;
  const { first, last } = ui.span;
  const isAt = (frame, side) => {
    if (!isSeen(frame)) return false;
    const apart = side * (px - x(frame));
    return apart >= -1 && apart <= SPAN_REACH;
  };
  if (isAt(first, -1)) return 'first';
  return isAt(last, 1) ? 'last' : null;
}
