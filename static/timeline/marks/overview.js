// While zoomed: the whole clip on six pixels, the shown window on it, to be dragged.

import { svg, nothing } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { isZoomed, scrollBy, showFrames, shown } from '../../actions/window.js';
import { lastFrame } from '../../store/clip.js';
import { left, OVERVIEW, right, RULER } from '../draw/scale.js';
import { frame, keyFrames } from '../../actions/playhead.js';

/** @type {import('../mark.js').Mark} */
export const overview = {
  kind: 'overview',
  layers: [{ group: 'above', z: 110, from: () => [server.segments, server.keys, frame()], draw: drawOverview }],
  hit: ({ y }) => isZoomed() && y > RULER - 2 && y < RULER + OVERVIEW + 2 && {},
  cursor: 'grab',
  grab,
};

const place = (at) => left() + (at * (right() - left())) / Math.max(1, lastFrame());
const frameUnder = (px) => ((px - left()) * lastFrame()) / (right() - left());

function drawOverview() {
  if (!isZoomed()) return nothing;
  const { first, last } = shown();
  const y = RULER;
  const bars = (server.segments ?? []).filter((segment) => segment.state !== 'none');
  const keys = keyFrames()
    .map((key) => `M${place(key).toFixed(1)} ${y}v${OVERVIEW}`)
    .join('');
  return svg`<rect class="f-ground" x=${left()} y=${y} width=${right() - left()} height=${OVERVIEW} />
    ${bars.map(
      (s) => svg`<rect class=${`f-${s.state} faint`} x=${place(s.first)} y=${y + 1}
      width=${Math.max(1, place(s.last) - place(s.first) - 1)} height=${OVERVIEW - 2} />`,
    )}
    <path class="s-ink" d=${keys} />
    <rect class="pane" x=${place(first)} y=${y + 0.5} height=${OVERVIEW - 1} rx="2"
      width=${Math.max(6, place(last) - place(first))} />
    <path class="s-acc" d=${`M${place(frame())} ${y}v${OVERVIEW}`} />`;
}

/** Take hold of the window: beside it, it first jumps under the pointer. */
function grab(_, start) {
  const { first, last } = shown();
  const at = frameUnder(start.x);
  if (at < first || at > last) showFrames(at - (last - first) / 2, at + (last - first) / 2);
  let before = start.x;
  return {
    move({ x }) {
      scrollBy(frameUnder(x) - frameUnder(before));
      before = x;
    },
  };
}
