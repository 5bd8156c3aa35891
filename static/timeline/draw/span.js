// The in and the out point on the ruler: what lies outside is darkened, a bracket at either end is
// dragged.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { clamp } from '../../controls/arithmetic.js';
import { ui } from '../../store/state.js';
import { hasSpan } from '../../actions/playing.js';
import { GUTTER, right, RULER, visible, x } from './scale.js';

const MARGIN = 26;
const TOP = 3;
const REACH = 9;

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
    return apart >= -1 && apart <= REACH;
  };
  if (isAt(first, -1)) return 'first';
  return isAt(last, 1) ? 'last' : null;
}
