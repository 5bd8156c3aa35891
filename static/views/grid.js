// The squared paper under the three small views, and their scale bar.

import { svg, nothing } from '../vendor/lit-html/lit-html.js';

const STEPS_M = [0.1, 0.5, 1, 5, 10, 50, 100];
const CLOSEST_PX = 14;
const BARS_M = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const LONGEST_BAR_PX = 96;

/** Lines for what a window shows: fine, coarse, and the two through the camera. */
export function gridLines(window) {
  const fine = STEPS_M.findIndex((step) => step * window.scale >= CLOSEST_PX);
  if (fine < 0) return nothing;
  const [step, coarse] = [STEPS_M[fine], STEPS_M[fine + 1] ?? Infinity];
  const paths = { fine: '', coarse: '', axis: '' };
  const [left, top] = window.toPlane([0, 0]);
  const [right, bottom] = window.toPlane([window.width, window.height]);
  const kindOf = (metres) => {
    if (Math.abs(metres) < step / 2) return 'axis';
    return Math.abs(metres / coarse - Math.round(metres / coarse)) < 1e-6 ? 'coarse' : 'fine';
  };
  for (let k = Math.ceil(left / step); k * step <= right; k++) {
    const x = onWholePixel(window.fromPlane([k * step, 0])[0]);
    paths[kindOf(k * step)] += `M${x} 0V${window.height}`;
  }
  for (let k = Math.ceil(top / step); k * step <= bottom; k++) {
    const y = onWholePixel(window.fromPlane([0, k * step])[1]);
    paths[kindOf(k * step)] += `M0 ${y}H${window.width}`;
  }
  return svg`<path class="fine" d=${paths.fine} /><path class="coarse" d=${paths.coarse} />
    <path class="axis" d=${paths.axis} />`;
}

/** A round length and the pixels it takes. */
export function scaleBar(window) {
  const metres = BARS_M.findLast((length) => length * window.scale <= LONGEST_BAR_PX) ?? BARS_M[0];
  const words = metres < 1 ? `${Math.round(metres * 100)} cm` : `${metres} m`;
  return { pixels: Math.round(metres * window.scale), words };
}

/** One pixel wide lines lie on whole pixels. */
function onWholePixel(x) {
  return Math.floor(x) + 0.5;
}
