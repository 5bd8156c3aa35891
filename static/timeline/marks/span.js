// The in point and the out point: brackets that stand outside their frames, so that the playhead on them can
// still be grabbed.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { menuItem } from '../../actions/buttons.js';
import { keyFrames } from '../../actions/playhead.js';
import { clearEnd, hasSpan, keepSpan, withEndDragged } from '../../actions/playing.js';
import { clamp } from '../../controls/arithmetic.js';
import { openMenuAt } from '../../controls/menu.js';
import { setUi, ui } from '../../store/state.js';
import { GUTTER, right, RULER, snapped, visible, x } from '../draw/scale.js';
import { plate } from '../draw/glyphs.js';

const MARGIN = 26;
const TOP = 3;
const REACH_PX = 9;

const wordOf = (end) => (end === 'first' ? 'In' : 'Out');

/** @type {import('../mark.js').Mark} */
export const span = {
  kind: 'span',
  layers: [{ group: 'frames', z: 180, from: () => [ui.span], draw }],
  hit({ x: px, y }) {
    const isAt = (frame, side) => isSeen(frame) && side * (px - x(frame)) >= -1 && side * (px - x(frame)) <= REACH_PX;
    if (y >= RULER || y < 0) return null;
    if (isAt(ui.span.first, -1)) return { end: 'first' };
    return isAt(ui.span.last, 1) && { end: 'last' };
  },
  cursor: 'ew-resize',
  /** It snaps to keyframes; Alt: it does not. */
  grab({ end }, start) {
    const before = ui.span;
    const offset = x(before[end]) - start.x;
    return {
      move(place) {
        setUi('span', withEndDragged(before, end, snapped(place.x + offset, place.alt ? [] : keyFrames())));
        return { end };
      },
      end: () => keepSpan(ui.span),
      cancel: () => setUi('span', before),
    };
  },
  menu({ end }, { page }) {
    const [word, at] = [wordOf(end), ui.span[end]];
    openMenuAt(
      `${word} point ${at}`,
      [
        menuItem('goTo', at),
        { icon: 'x', label: `Clear the ${word.toLowerCase()} point`, run: () => clearEnd(end) },
        menuItem('clearSpan'),
        menuItem('loop'),
      ],
      page,
    );
  },
  drag: ({ end }) => plate(`${wordOf(end)} ${ui.span[end]}`, x(ui.span[end]), RULER + 12),
};

function isSeen(frame) {
  const seen = visible();
  return frame !== null && frame >= seen.first && frame <= seen.last;
}

function draw({ bottom }) {
  if (!hasSpan()) return nothing;
  const { first, last } = ui.span;
  const end = right() + MARGIN;
  const [from, to] = [
    first === null ? GUTTER : clamp(x(first), GUTTER, end),
    last === null ? end : clamp(x(last), GUTTER, end),
  ];
  const shade = (left, wide) =>
    wide > 0
      ? svg`<rect class="outside ruler" x=${left} y="0" width=${wide} height=${RULER} />
      <rect class="outside" x=${left} y=${RULER} width=${wide} height=${Math.max(0, bottom - RULER)} />`
      : nothing;
  return svg`${first === null ? nothing : shade(GUTTER, from - GUTTER)}${last === null ? nothing : shade(to, end - to)}
    <rect class="within" x=${from} y=${RULER - 3} width=${Math.max(0, to - from)} height="3" />
    ${isSeen(first) ? bracket(from, -1, `In point ${first}`) : nothing}${
      isSeen(last) ? bracket(to, 1, `Out point ${last}`) : nothing
    }`;
}

const bracket = (at, side, title) =>
  svg`<path class="spanend"
    d=${`M${at} ${TOP}h${side * 6}V${RULER}h${-side * 6}v-3h${side * 3}V${TOP + 3}h${-side * 3}z`}><title>${title}</title></path>`;
