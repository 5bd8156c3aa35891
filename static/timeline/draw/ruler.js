// The ruler: numbers at sensible steps for any number of frames.

import { svg, nothing } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { frameCount, lastFrame, pxPerFrame, rulerStep, visible, x } from './scale.js';
import { RULER } from './rows.js';

const NUMBERS_APART_PX = 80;
const TICKS_APART_PX = 5;

/** Ticks and numbers; thin lines through all rows under each number. */
export function drawRuler(height) {
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
    ${numbers.map((frame) => svg`<text class="number" x=${x(frame).toFixed(1)} y="11"
      data-frame=${frame} text-anchor="middle">${frame}</text>`)}`;
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
export function drawClip() {
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
