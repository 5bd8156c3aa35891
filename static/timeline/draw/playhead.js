// The playhead with its flag, and the band of its interval.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { noteAsOneLine, noteAt } from '../../actions/keying.js';
import { partKeyAt } from '../../actions/parts.js';
import { around, draftFrames, frame, isKey, segmentAt } from '../../actions/playhead.js';
import { isSelected, selectedKeys } from '../../actions/selection.js';
import { frameCount, lastFrame } from '../../store/clip.js';
import { server } from '../../store/state.js';
import { HOVERED } from '../marks/notes.js';
import { GUTTER, right, RULER, x } from './scale.js';

/** @type {import('../mark.js').Layer[]} */
export const PLAYHEAD = [
  {
    group: 'frames',
    z: 30,
    from: () => [frame(), server.keys],
    draw: ({ rows, bottom }) => drawBand(rows.top, bottom),
  },
  {
    group: 'top',
    z: 10,
    from: () => [frame(), server.keys, selectedKeys(), server.segments],
    draw: ({ bottom }) => drawPlayhead(bottom),
  },
];

export const flagWidth = () => 16 + 9 * String(frame()).length;

/** The playhead from the ruler down to `bottom`, a slider for those who cannot drag it. */
function drawPlayhead(bottom) {
  if (frameCount() === 0) return nothing;
  const at = Math.round(x(frame()) * 2) / 2;
  if (at < GUTTER - 1 || at > right() + 12) return nothing;
  const half = flagWidth() / 2;
  return svg`<g class="playhead" role="slider" tabindex="0" aria-label="Frame"
      aria-valuemin="0" aria-valuemax=${lastFrame()} aria-valuenow=${frame()}
      aria-valuetext=${spokenFrame()} transform=${`translate(${at} 0)`}>
    <path class="stem" d=${`M0 ${RULER - 4}V${bottom}`} />
    <path class="ring" d=${flag(half + 3, -3, 20)} />
    <path class="flag" d=${flag(half, 0, 17)} />
    <text x="0" y="12.5" text-anchor="middle">${frame()}</text></g>`;
}

function flag(half, top, bottom) {
  return `M${-half} ${top + 3}a3 3 0 0 1 3-3h${2 * half - 6}a3 3 0 0 1 3 3V${bottom - 3}a3 3 0 0 1-3 3
    h${7 - half}l-4 4-4-4h${7 - half}a3 3 0 0 1-3-3z`;
}

function spokenFrame() {
  const at = frame();
  const part = partKeyAt(at) ? `, part keyframe, ${partKeyAt(at).words}` : '';
  const what = isKey(at)
    ? `, keyframe${isSelected(at) ? ', selected' : ''}`
    : draftFrames().includes(at)
      ? ', draft'
      : part;
  const segment = segmentAt(at);
  const note = noteAt(at);
  const noted = note ? `, note: ${noteAsOneLine(note, HOVERED)}` : '';
  return `Frame ${at} of ${lastFrame()}${what}${noted}${segment?.words ? `. ${segment.words}` : ''}`;
}

/** The interval around the playhead; on a key, both intervals it ends. */
function drawBand(top, bottom) {
  const interval = server.keys ? around(frame()) : null;
  if (interval === null || interval[0] === interval[1]) return nothing;
  const [from, to] = interval.map(x);
  return svg`<rect class="band" x=${from} y=${top} width=${to - from}
    height=${Math.max(0, bottom - top)} />`;
}
