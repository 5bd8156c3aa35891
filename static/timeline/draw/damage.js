// Damaged frames, hatched through all rows: there is nothing to be tracked by.

import { svg } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { damageWords } from '../../store/damage.js';
import { pxPerFrame, visible, x } from './scale.js';
import { RULER } from './rows.js';

const LEAST_PX = 3;
const STRIP = 4;

export function drawDamage(height) {
  const { first, last } = visible();
  const seen = (server.damage ?? []).filter(([from, to]) => to >= first - 1 && from <= last + 1);
  return seen.map((run) => hatched(run, height));
}

function hatched([first, last], height) {
  const half = pxPerFrame() / 2;
  const wide = Math.max(LEAST_PX, x(last) - x(first) + 2 * half);
  const left = (x(first) + x(last) - wide) / 2;
  return svg`<g class="damaged"><rect x=${left} y=${RULER} width=${wide} height=${height - RULER}
      fill="url(#tl-damaged)" />
    <rect class="f-damaged" x=${left} y=${RULER - STRIP} width=${wide} height=${STRIP} />
    <title>${damageWords(first, last)}</title></g>`;
}
