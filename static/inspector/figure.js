// The person whose parts are clicked, seen from the front: the body's right is on the left, as in
// the picture. Drawn 100 × 148; limbs are capsules (x1, y1, x2, y2, half width 1, half width 2).

import { html, svg } from '../vendor/lit-html/lit-html.js';

const MIDDLE = 56;

const TRUNK = {
  head: 'M49.5 6.5a6.5 6.5 0 0 1 13 0l-1 9a5.5 5.5 0 0 1-11 0z',
  neck: 'M53 19h6v5h-6z',
  chest: 'M45 25h22a3 3 0 0 1 3 3.5l-3 19H45l-3-19A3 3 0 0 1 45 25z',
  waist: 'M45.4 49h21.2l2 13a3 3 0 0 1-3 3H46.4a3 3 0 0 1-3-3z',
};

/** On the shoulders of bodies that have them. */
const GIRDLE = { clavicle: [3, 27.4, 10.5, 27.6, 1.5, 1.7] };

const LIMBS = {
  upper_arm: [15, 29, 25, 50, 4.4, 3.8],
  forearm: [25.5, 52, 31, 72, 3.7, 2.9],
  hand: [31.6, 75, 34, 84, 3.2, 2.6],
  thigh: [7.5, 68, 9, 94, 6.2, 4.6],
  shin: [9.2, 98, 9.6, 121, 4.4, 3.2],
  foot: [9.8, 125, 13, 128, 3.2, 2.6],
};

const OUTLINES = outlines();

/** Whether this body is the person the figure shows. */
export function isPerson(body) {
  const names = new Set(body.parts.map((part) => part.name));
  const shown = Object.keys(OUTLINES).filter((name) => !name.endsWith('_clavicle'));
  return body.parts.every((part) => part.name in OUTLINES) && shown.every((name) => names.has(name));
}

/** face(part) → {selected, hovered, over(), out(), act()}. */
export function figure(body, face) {
  const parts = body.parts.map((part) => ({ part, look: face(part) }));
  const lit = (kind) => parts.filter(({ look }) => look[kind]).map(({ part }) => outline(part, kind));
  return html`<svg class="person" viewBox="6 -7 100 148" role="group" aria-label="Parts">
    ${parts.map(shape)}${lit('hovered')}${lit('selected')}
    <text x="14" y="131">R</text>
    <text x="93" y="131">L</text>
  </svg>`;
}

function shape({ part, look }) {
  return svg`<path d=${OUTLINES[part.name]} class="part ${part.side}" role="button"
    tabindex=${look.first ? 0 : -1} aria-label=${part.label} aria-pressed=${look.selected}
    @pointerenter=${look.over} @pointerleave=${look.out} @click=${look.act}><title>${part.label}</title></path>`;
}

/** What is lit is drawn once more on top, so that its outline hides nowhere. */
function outline(part, kind) {
  return svg`<path d=${OUTLINES[part.name]} class="part ${part.side} ${kind}"></path>`;
}

function outlines() {
  const all = { ...TRUNK };
  for (const [name, numbers] of Object.entries({ ...LIMBS, ...GIRDLE })) {
    all[`left_${name}`] = capsule(numbers, 1);
    all[`right_${name}`] = capsule(numbers, -1);
  }
  return all;
}

/** @param {number[]} numbers */
function capsule([dx1, y1, dx2, y2, w1, w2], side) {
  const x1 = MIDDLE + side * dx1;
  const x2 = MIDDLE + side * dx2;
  const angle = Math.atan2(y2 - y1, x2 - x1);
  const [nx, ny] = [-Math.sin(angle), Math.cos(angle)];
  const at = (x, y, w) => `${(x + nx * w).toFixed(2)} ${(y + ny * w).toFixed(2)}`;
  return (
    `M${at(x1, y1, w1)}A${w1} ${w1} 0 0 1 ${at(x1, y1, -w1)}` +
    `L${at(x2, y2, -w2)}A${w2} ${w2} 0 0 1 ${at(x2, y2, w2)}Z`
  );
}
