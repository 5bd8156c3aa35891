// What the guide points at: drawn over the whole window, and never in the pointer's way. What
// belongs to a view ends at its edge.

import { nothing, render, svg, html } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { view } from '../views/views.js';
import { spotsOf } from './guide_spots.js';

const MARKS = {
  hips: anywhere, height: upAndDown, facing: () => null, limbs: roundEnds, depth: inSide, key: onKey,
};

/** Draw the marks of this step, or none. */
export function drawMarks(place, step) {
  const shapes = step && server.pose ? MARKS[step.name](step) : null;
  render(shapes ? html`<svg aria-hidden="true">${shapes}</svg>` : nothing, place);
}

/** A ring round the point at the hips, with arrows: it may go anywhere. */
function anywhere(step) {
  return within(step, ([x, y]) => svg`<g transform="translate(${x} ${y})">
    ${ring(0, 0, 20)}${[0, 90, 180, 270].map(tip)}
  </g>`);
}

/** A double arrow through the point at the hips. */
function upAndDown(step) {
  return within(step, ([x, y]) => svg`<g transform="translate(${x} ${y})">
    ${ring(0, 0, 20)}<path class="line" d="M0-28V-46M0 28V46" />
    <g transform="translate(0 -14)">${tip(0)}</g><g transform="translate(0 14)">${tip(180)}</g>
  </g>`);
}

const tip = (turn) => svg`<path class="tip" transform="rotate(${turn})" d="M0-37l7 9H-7z" />`;

function roundEnds(step) {
  return within(step, ([x, y], { kind }) => ring(x, y, kind === 'end' ? 15 : 12));
}

/** A frame round the side view, and rings round what may be pulled there. */
function inSide(step) {
  const side = view('side')?.el?.getBoundingClientRect();
  if (!side) return null;
  return svg`${frame(side, -2)}${within(step, ([x, y]) => ring(x, y, 9))}`;
}

function onKey() {
  const box = document.querySelector('#time [aria-label^="Add keyframe"]')?.getBoundingClientRect();
  return box?.width ? frame(box, 3) : null;
}

/** A mark on each of the step's handles, none of it outside their view. */
function within(step, draw) {
  const { left, top, width, height } = view(step.takes.view).el.getBoundingClientRect();
  return svg`<clipPath id="guide-clip"><rect x=${left} y=${top} width=${width} height=${height} /></clipPath>
    <g clip-path="url(#guide-clip)">${spotsOf(step).map(({ at, handle }) => draw(at, handle))}</g>`;
}

const ring = (x, y, r) => svg`<circle class="halo" cx=${x} cy=${y} r=${r} />
  <circle class="ring" cx=${x} cy=${y} r=${r} />`;

const frame = (box, room) => svg`<rect
  class="frame"
  x=${box.left - room}
  y=${box.top - room}
  width=${box.width + 2 * room}
  height=${box.height + 2 * room}
  rx="6"
/>`;
