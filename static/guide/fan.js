// What a lens sees, from above, and how far away it puts the person: a panel over the picture that
// follows the choice of the lens.

import { degrees, millimetres } from '../actions/lens.js';
import { shortNumber } from '../controls/arithmetic.js';
import { pendingOr } from '../controls/pending.js';
import { server } from '../store/state.js';
import { html, svg } from '../vendor/lit-html/lit-html.js';
import { view } from '../views/views.js';

const WIDTH = 264;
const HEIGHT = 246;
/** From the view's lower right corner, above its zoom. */
const ROOM = { right: 12, bottom: 56 };
const MIDDLE = 140;
const FOOT = 206;
const RADIUS = 172;
/** Half of what there is room for at the widest. */
const WIDEST = 122;
/** Where the person stands, as a share of the radius. */
const THERE = 0.62;
/** Lenses to compare with, mm. */
const WIDE = 13;
const TELE = 77;
const USUAL = 26;

/** The panel, over the lower right of the picture. */
export function fan() {
  const { right, bottom } = view('main').el.getBoundingClientRect();
  const mm = pendingOr('lens', server.camera.focal_mm);
  const other = Math.abs(mm - TELE) < 8 ? USUAL : TELE;
  const metres = distance() * (mm / server.camera.focal_mm);
  const place = `left:${right - ROOM.right - WIDTH}px;top:${bottom - ROOM.bottom - HEIGHT}px`;
  return html`<div class="glass fan" style=${place} role="img" aria-label=${`${millimetres(mm)} seen from above`}>
    <svg width=${WIDTH} height=${HEIGHT} aria-hidden="true">
      <text class="h" x="12" y="20">Field of view</text><text class="s" x=${WIDTH - 8} y="20" text-anchor="end">from above</text>
      ${slice(WIDE, 'other', 0.87)}${slice(mm, 'here', 1)}${slice(other, 'other', 1)}
      <rect class="camera" x=${MIDDLE - 7} y=${FOOT - 3} width="14" height="10" rx="2" />
      ${person(metres)}
      <text class="here" x=${MIDDLE} y=${FOOT - RADIUS + 18} text-anchor="middle">${millimetres(mm)} · ${Math.round(degrees('across', mm))}°</text>
      <text class="s" x="12" y=${FOOT - 40}>${WIDE} mm</text>
      <text class="o" x=${MIDDLE} y=${FOOT - 52} text-anchor="middle">${other} mm</text>
      <text class="s" x="12" y=${FOOT + 30}>Same picture with ${other} mm: ${shortNumber((metres * other) / mm, 1)} m away.</text>
    </svg>
  </div>`;
}

function slice(mm, kind, share) {
  const half = ((degrees('across', mm) / 2) * Math.PI) / 180;
  const r = Math.min(RADIUS, WIDEST / Math.sin(half)) * share;
  const [x, y] = [Math.sin(half) * r, Math.cos(half) * r];
  return svg`<path class=${kind} d="M${MIDDLE} ${FOOT}l${-x} ${-y}a${r} ${r} 0 0 1 ${2 * x} 0z" />`;
}

function person(metres) {
  const [x, , z] = isPosed() ? server.pose.root : [0, 0, 1];
  const angle = Math.atan2(x, z);
  const [at, up] = [MIDDLE + Math.sin(angle) * THERE * RADIUS, FOOT - Math.cos(angle) * THERE * RADIUS];
  return svg`<ellipse class="shade" cx=${at} cy=${up} rx="9" ry="4.5" /><circle class="person" cx=${at} cy=${up} r="4" />
    <text class="m" x=${at + 14} y=${up + 4}>${shortNumber(metres, 1)} m</text>`;
}

const isPosed = () => Boolean(server.pose && !['opening', 'rest'].includes(server.pose.source));

/** Metres to the body as it is posed; before that, to one that is as tall as the picture. */
function distance() {
  if (isPosed()) return server.pose.root[2];
  return ((server.body.height_cm / 100) * server.camera.fy) / server.camera.height;
}
