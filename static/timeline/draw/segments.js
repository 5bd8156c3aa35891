// The bars between the keys: state as colour, pattern and word.

import { clamp } from '../../controls/arithmetic.js';
import { svg, nothing } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { suggestedFrame } from '../../actions/playhead.js';
import { partKeys } from '../../actions/parts.js';
import { singleDrafts } from './drafts.js';
import { BAR, GUTTER, right, visible, x } from './scale.js';
import { lastFrame } from '../../store/clip.js';
import { VERDICTS } from '../../controls/words.js';

const BESIDE_DIAMOND = 8;
const FILLS = { check: 'url(#tl-check)', lost: 'url(#tl-lost)' };

/** Left and right end of a segment's bar; it keeps clear of the diamonds. */
export function barOf(segment) {
  const from = x(segment.first);
  const to = x(segment.last);
  const beside = Math.min(BESIDE_DIAMOND, (to - from) * 0.32);
  return { from: from + beside, to: to - beside };
}

export function drawSegments(rows) {
  const { first, last } = visible();
  const seen = (server.segments ?? []).filter((s) => s.last >= first && s.first <= last);
  return svg`<path class="s-tick dotted" d=${untouched(rows)} />
    ${seen.map((segment) => drawSegment(segment, rows.keys.middle))}
    ${seen.map((segment) => drawWord(segment, rows.keys.middle))}`;
}

/** The dotted line where no segment is: before the first key, after the last, or everywhere. */
function untouched(rows) {
  const segments = server.segments ?? [];
  const line = (from, to) => (to - from > 4 ? `M${from} ${rows.keys.middle + 0.5}H${to}` : '');
  if (segments.length === 0) return line(x(0) + 8, x(lastFrame()));
  const before = line(x(0), x(segments[0].first) - 8);
  return before + line(x(segments.at(-1).last) + 8, x(lastFrame()));
}

function drawSegment(segment, middle) {
  const { from, to } = barOf(segment);
  const wide = Math.max(1, to - from);
  const round = Math.min(3, wide / 2);
  const top = middle - BAR.half;
  const high = 2 * BAR.half;
  const bar = (classes, fill) => svg`<rect class=${classes} x=${from} y=${top} width=${wide}
    height=${high} rx=${round} fill=${fill} />`;
  switch (segment.state) {
    case 'none':
      return nothing;
    case 'outdated':
    case 'waiting':
      return wide < 6
        ? bar('f-old faint', nothing)
        : svg`<rect class=${`hollow ${segment.state}`} x=${from + 0.5} y=${top + 0.5}
            width=${wide - 1} height=${high - 1} rx=${round} />`;
    case 'tracking':
      return svg`${bar('tracking', nothing)}
        <rect x=${from} y=${top} width=${(wide * share(segment)).toFixed(1)} height=${high}
          rx=${round} fill="url(#tl-track)" />`;
    case 'good':
      return bar('f-good bar', nothing);
    default:
      return bar('', FILLS[segment.state] ?? 'none');
  }
}

function share(segment) {
  return clamp((segment.percent ?? 0) / 100, 0, 1);
}

/** The word a segment carries; good needs none. */
function wordOf(segment) {
  if (segment.state === 'tracking') return `${Math.round(segment.percent ?? 0)} %`;
  return segment.state === 'good' ? '' : VERDICTS[segment.state].word;
}

const INKS = { tracking: 'f-track', outdated: 'f-old', waiting: 'f-old' };

function drawWord(segment, middle) {
  const word = wordOf(segment);
  const { from, to } = clip(barOf(segment));
  const wide = word.length * 6 + 14;
  const at = word === '' ? null : freePlace(from, to, wide);
  if (at === null) return nothing;
  const ink = INKS[segment.state] ?? `f-${segment.state}`;
  return svg`<rect class="f-panel" x=${at - wide / 2} y=${middle - 8} width=${wide} height="16" rx="8" />
    <text class=${`word ${ink}`} x=${at} y=${middle + 4} text-anchor="middle">${word}</text>`;
}

function clip({ from, to }) {
  return { from: Math.max(from, GUTTER), to: Math.min(to, right()) };
}

/**
 * The middle, or beside it where a diamond stands there. Null where no place is free: then the
 * pattern alone shows the state.
 */
function freePlace(from, to, wide) {
  if (to - from < wide + 8) return null;
  const suggested = suggestedFrame();
  const diamonds = [...singleDrafts(), ...partKeys().map((key) => key.frame), ...(suggested === null ? [] : [suggested])].map(x);
  const isFree = (at) =>
    at - wide / 2 >= from && at + wide / 2 <= to &&
    diamonds.every((there) => Math.abs(there - at) > wide / 2 + 10);
  const places = [0.5, 0.24, 0.76].map((part) => from + (to - from) * part);
  return places.find(isFree) ?? null;
}
