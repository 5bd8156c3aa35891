// The points of the background over the picture, by which the camera's motion was found: dots that agree
// with it, crosses that do not. Two paths, however many there are; none while the film plays.

import { nothing, svg } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';

const CROSS = 2.5;

export function drawBackground(view) {
  if (view.name !== 'main' || !server.background || ui.playing) return nothing;
  const { uv, good } = server.background;
  const [agree, refused] = [[], []];
  uv.forEach((spot, i) => (good[i] ? agree : refused).push(view.fromView(spot)));
  const dots = pathOf(agree, ([x, y]) => `M${x.toFixed(1)} ${y.toFixed(1)}h0`);
  const crosses = pathOf(refused, ([x, y]) => {
    const [left, top] = [(x - CROSS).toFixed(1), (y - CROSS).toFixed(1)];
    return `M${left} ${top}l${2 * CROSS} ${2 * CROSS}m${-2 * CROSS} 0l${2 * CROSS} ${-2 * CROSS}`;
  });
  return svg`<g class="background" aria-hidden="true"><path class="edge" d=${dots} /><path class="edge" d=${crosses} />
    <path class="agrees" d=${dots} /><path class="refused" d=${crosses} /></g>`;
}

const pathOf = (spots, mark) => spots.map(mark).join('');
