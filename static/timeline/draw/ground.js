// What everything stands on: panel, field and lines between the rows, the ruler with its numbers,
// damaged frames, and words where nothing is yet. Every verdict has a pattern beside its colour.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { server, ui } from '../../store/state.js';
import { damageWords, frameCount, isSurface, lastFrame } from '../../store/clip.js';
import { GUTTER, pxPerFrame, right, RULER, rulerStep, visible, x } from './scale.js';
import { hasCurve } from './curve.js';
import { isScore } from '../marks/scores.js';

/** @type {import('../mark.js').Layer[]} */
export const GROUND = [
  { group: 'back', z: 0, from: () => [], draw: ({ rows }) => drawGround(rows) },
  { group: 'frames', z: 10, from: () => [], draw: ({ bottom }) => drawRuler(bottom) },
  { group: 'frames', z: 20, from: () => [server.damage], draw: ({ bottom }) => drawDamage(bottom) },
  {
    group: 'frames',
    z: 190,
    from: () => [server.curve, isScore()],
    draw: ({ rows, empty }) => drawNothingYet(rows, empty),
  },
  { group: 'above', z: 10, from: () => [server.keys], draw: ({ rows }) => [drawClip(), drawKeyLabels(rows)] },
];

const nothingYet = () =>
  `Visibility per part and joint angles appear here after ${isSurface() ? 'fitting' : 'tracking'}.`;

function drawGround(rows) {
  const { width, height } = ui.timeSize;
  const across = (y) => `M0 ${y - 0.5}H${width}`;
  const lines = [across(rows.top), across(rows.keys.y + rows.keys.h)];
  if (rows.camera) lines.push(across(rows.camera.y + rows.camera.h));
  if (rows.pins && !rows.pins.thin) lines.push(across(rows.pins.y));
  if (rows.curve !== null && (rows.lanes.full > 0 || rows.pins)) lines.push(across(rows.curve.y - 2));
  return svg`<rect class="f-panel" width=${width} height=${height} />
    <rect class="f-ground field" x=${GUTTER} width=${Math.max(0, width - GUTTER)} height=${height} />
    <path class="s-line" d=${`M${GUTTER + 0.5} 0V${height}${lines.join('')}`} />`;
}

function drawKeyLabels(rows) {
  if (!server.file) return nothing;
  const y = rows.keys.middle + 4;
  return svg`<text class="lbl" x="12" y=${y}>Keyframes</text>
    <text class="d" x=${GUTTER - 10} y=${y} text-anchor="end">${server.keys?.frames.length ?? 0}</text>`;
}

/** Words in the place of lanes and curve before the first track. */
function drawNothingYet(rows, empty) {
  if (!empty || isScore() || frameCount() === 0) return nothing;
  const { y, h } = rows.camera ?? rows.keys;
  const top = y + h;
  const room = rows.height - top;
  if (hasCurve() || room < 24) return nothing;
  return svg`<text class="d" x=${(GUTTER + right()) / 2} y=${top + room / 2 + 4}
    text-anchor="middle">${nothingYet()}</text>`;
}

const NUMBERS_APART_PX = 80;
const TICKS_APART_PX = 5;

/** Ticks and numbers; thin lines through all rows under each number. */
function drawRuler(height) {
  if (frameCount() === 0) return nothing;
  const step = rulerStep(NUMBERS_APART_PX);
  const numbers = marks(step);
  const small = smallStep(step);
  const half = step % 2 === 0 || step === 5 ? step / 2 : step;
  const ticks = marks(small).filter((frame) => frame % step !== 0);
  const tick = (frame) => `M${x(frame).toFixed(1)} ${RULER - 1}v${frame % half === 0 ? -5 : -3}`;
  const long = (frame) => `M${x(frame).toFixed(1)} ${RULER - 1}v-7`;
  const rule = (frame) => `M${x(frame).toFixed(1)} ${RULER}V${height}`;
  return svg`<path class="s-rule rules" d=${numbers.map(rule).join('')} />
    <path class="s-tick" d=${ticks.map(tick).join('')} />
    <path class="s-quiet" d=${numbers.map(long).join('')} />
    ${numbers.map(
      (frame) => svg`<text class="number" x=${x(frame).toFixed(1)} y="11"
      data-frame=${frame} text-anchor="middle">${frame}</text>`,
    )}`;
}

function marks(step) {
  const { first, last } = visible();
  const end = Math.min(last, lastFrame());
  const frames = [];
  for (let at = Math.ceil(Math.max(0, first) / step) * step; at <= end; at += step) frames.push(at);
  return frames;
}

function smallStep(step) {
  for (const parts of [10, 5, 2]) {
    const small = step / parts;
    if (Number.isInteger(small) && small * pxPerFrame() >= TICKS_APART_PX) return small;
  }
  return step;
}

/** Numbers under the playhead's flag step aside for it. */
export function clearNumbers(drawing, frame, flagWidth) {
  for (const text of drawing.querySelectorAll('.number')) {
    const room = (flagWidth + String(text.dataset.frame).length * 7) / 2 + 3;
    const hidden = Math.abs(x(Number(text.dataset.frame)) - x(frame)) < room;
    text.setAttribute('visibility', hidden ? 'hidden' : 'visible');
  }
}

/** The clip's own figures at the left end of the ruler: "60 fps · 1.67 s". */
function drawClip() {
  if (!server.file) return nothing;
  const fps = Number(server.file.fps.toFixed(2));
  return svg`<text class="d" x="12" y="15">${fps} fps · ${duration(server.file.duration_s)}</text>`;
}

function duration(seconds) {
  if (seconds < 60) return `${seconds.toFixed(2)} s`;
  const whole = Math.round(seconds);
  const minutes = Math.floor(whole / 60);
  const rest = String(whole % 60).padStart(2, '0');
  if (minutes < 60) return `${minutes}:${rest} min`;
  return `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, '0')}:${rest} h`;
}

const LEAST_PX = 3;
const STRIP = 4;

function drawDamage(height) {
  const { first, last } = visible();
  const seen = (server.damage ?? []).filter(([from, to]) => to >= first - 1 && from <= last + 1);
  return seen.map((run) => drawHatched(run, height));
}

function drawHatched([first, last], height) {
  const half = pxPerFrame() / 2;
  const wide = Math.max(LEAST_PX, x(last) - x(first) + 2 * half);
  const left = (x(first) + x(last) - wide) / 2;
  return svg`<g class="damaged"><rect x=${left} y=${RULER} width=${wide} height=${height - RULER}
      fill="url(#tl-damaged)" />
    <rect class="f-damaged" x=${left} y=${RULER - STRIP} width=${wide} height=${STRIP} />
    <title>${damageWords(first, last)}</title></g>`;
}

export const PATTERNS = svg`<defs>
  <pattern id="tl-check" width="8" height="8" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
    <rect class="f-check" width="8" height="8" opacity=".38" />
    <rect class="f-check" width="3.5" height="8" />
  </pattern>
  <pattern id="tl-lost" width="7" height="7" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
    <rect class="f-lost" width="7" height="7" opacity=".28" />
    <path class="s-lost" d="M0 0H7M0 0V7" stroke-width="3.4" />
  </pattern>
  <pattern id="tl-track" width="12" height="12" patternUnits="userSpaceOnUse">
    <rect class="f-track" width="12" height="12" />
    <path class="stripes" d="M-12 12 0 0H5L-7 12zM0 12 12 0h5L5 12z" fill="#fff" opacity=".28" />
  </pattern>
  <pattern id="tl-hidden" width="5" height="5" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
    <rect class="f-quiet" width="1.4" height="5" />
  </pattern>
  <pattern id="tl-damaged" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(-45)">
    <rect class="f-damaged" width="1.5" height="6" opacity=".4" />
  </pattern>
</defs>`;
