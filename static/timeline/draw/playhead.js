// The playhead with its flag, and the band of the interval it stands in.

import { svg, nothing } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { GUTTER, frameCount, lastFrame, right, x } from './scale.js';
import { RULER } from './rows.js';
import { frame } from '../edit/head.js';
import { around, isKey, segmentAt } from '../edit/moves.js';
import { draftFrames } from './keymarks.js';

export function flagWidth() {
  return 16 + 9 * String(frame()).length;
}

/** The playhead from the ruler down to `bottom`, a slider for those who cannot drag it. */
export function drawPlayhead(bottom) {
  if (frameCount() === 0) return nothing;
  const at = Math.round(x(frame()) * 2) / 2;
  if (at < GUTTER - 1 || at > right() + 12) return nothing;
  const half = flagWidth() / 2;
  return svg`<g class="playhead" role="slider" tabindex="0" aria-label="Frame"
      aria-valuemin="0" aria-valuemax=${lastFrame()} aria-valuenow=${frame()}
      aria-valuetext=${spoken()} transform=${`translate(${at} 0)`}>
    <path class="stem" d=${`M0 ${RULER - 4}V${bottom}`} />
    <path class="ring" d=${flag(half + 3, -3, 20)} />
    <path class="flag" d=${flag(half, 0, 17)} />
    <text x="0" y="12.5" text-anchor="middle">${frame()}</text></g>`;
}

function flag(half, top, bottom) {
  return `M${-half} ${top + 3}a3 3 0 0 1 3-3h${2 * half - 6}a3 3 0 0 1 3 3V${bottom - 3}a3 3 0 0 1-3 3
    h${7 - half}l-4 4-4-4h${7 - half}a3 3 0 0 1-3-3z`;
}

function spoken() {
  const at = frame();
  const what = isKey(at) ? ', keyframe' : draftFrames().includes(at) ? ', draft' : '';
  const segment = segmentAt(at);
  return `Frame ${at} of ${lastFrame()}${what}${segment?.words ? `. ${segment.words}` : ''}`;
}

/** The interval around the playhead; on a key, both intervals it ends. */
export function drawBand(rows, bottom) {
  const interval = server.keys ? around(frame()) : null;
  if (interval === null || interval[0] === interval[1]) return nothing;
  const [from, to] = interval.map(x);
  return svg`<rect class="band" x=${from} y=${rows.top} width=${to - from}
    height=${Math.max(0, bottom - rows.top)} />`;
}
