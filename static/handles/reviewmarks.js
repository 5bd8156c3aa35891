// The place that is reviewed, on the views: a dashed circle as large as the error that is expected.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { place } from '../actions/review.js';
import { server } from '../store/state.js';

const LEAST_PX = 9;

/** The place, on its own frame. */
function placeHere() {
  const row = place();
  return row && row.frame === server.view?.frame ? row : undefined;
}

/** Whether a handle is of the limb that is looked at; the others step back. */
export const isOfPlace = ({ limb, part }) => {
  const name = placeHere()?.part;
  return !name || (limb ?? [part]).includes(name);
};

export function drawPlace(view) {
  const row = placeHere();
  if (!row || row.px === null) return nothing;
  const [x, y] = view.project(row.end);
  if (!Number.isFinite(x + y)) return nothing;
  const r = Math.max(LEAST_PX, row.radius_m * view.pxPerMetre(row.end));
  return svg`<circle class="doubt" cx=${x} cy=${y} r=${r} />`;
}

/** "Right wrist ≈ 9 px · 4 cm" above the circle in the large view. */
export function drawPlaceName(view) {
  const row = placeHere();
  if (!row || view.name !== 'main' || row.px === null) return nothing;
  const [x, y] = view.project(row.end);
  if (!Number.isFinite(x + y)) return nothing;
  const r = Math.max(LEAST_PX, row.radius_m * view.pxPerMetre(row.end));
  return html`<div class="flt doubted num" style="left:${x + r + 10}px;top:${y - r - 12}px">
    <b>${row.label}</b> <span class="warned">${row.size}</span></div>`;
}
