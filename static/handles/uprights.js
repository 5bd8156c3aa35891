// The upright lines over the picture by which the up direction was found; none while the film plays.

import { nothing, svg } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { pathOf } from './space.js';

export function drawUprights(view) {
  if (view.name !== 'main' || !server.up || ui.playing || !isSeenHere(server.up)) return nothing;
  const d = server.up.lines.map((ends) => pathOf(ends.map((spot) => view.fromView(spot)))).join('');
  return svg`<g class="uprights" aria-hidden="true"><path class="edge" d=${d} /><path d=${d} /></g>`;
}

/** @param {import('../store/shapes.js').FoundUp} found */
const isSeenHere = ({ frame }) => frame === null || frame === server.view.frame;
