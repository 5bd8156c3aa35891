// What the guide points at: drawn over the whole window, and never in the pointer's way.

import { nothing, render, svg, html } from '../vendor/lit-html/lit-html.js';
import { S } from '../state.js';
import { view } from '../views.js';

const MARKS = { hips: roundRoot, height: besideBody, limbs: roundEnds, depth: inSide, key: onKey };

/** Draw the marks of this step, or none. */
export function drawMarks(place, step) {
  const shapes = step && S.pose ? MARKS[step]() : null;
  render(shapes ? html`<svg aria-hidden="true">${shapes}</svg>` : nothing, place);
}

/** A ring round the diamond, with arrows: it may go anywhere. */
function roundRoot() {
  const at = handlePoint('main', S.body?.handles?.find(({ kind }) => kind === 'root'));
  if (!at) return null;
  return svg`<g transform="translate(${at[0]} ${at[1]})">
    ${ring(0, 0, 20)}
    ${[0, 90, 180, 270].map((turn) => svg`<path class="tip" transform="rotate(${turn})" d="M0-37l7 9H-7z" />`)}
  </g>`;
}

/** A measure from head to feet beside the body, and a frame round the field. */
function besideBody() {
  const box = boxOf('main');
  const field = frameRound('#insp [aria-label^="Height"]');
  if (!box) return field;
  const x = box.right + 28;
  return svg`${field}<g>
    <path class="dash" d="M${x} ${box.top}V${box.bottom}" />
    <path class="line" d="M${x - 8} ${box.top}h16M${x - 8} ${box.bottom}h16" />
  </g>`;
}

function roundEnds() {
  const ends = (S.body?.handles ?? []).filter(({ kind }) => kind === 'end');
  return ends
    .map((handle) => handlePoint('main', handle))
    .filter(Boolean)
    .map(([x, y]) => ring(x, y, 15));
}

/** A frame round the side view, and arrows along the depth. */
function inSide() {
  const side = view('side')?.el?.getBoundingClientRect();
  if (!side) return null;
  const at = handlePoint('side', S.body?.handles?.find(({ kind }) => kind === 'root'));
  const arrows = at
    ? svg`<g transform="translate(${at[0]} ${at[1]})">
        <path class="dash" d="M-34 0H34" />
        <path class="tip" d="M-44 0l9-6v12zM44 0l-9-6v12z" />
      </g>`
    : nothing;
  return svg`${frame(side, -2)}${arrows}`;
}

function onKey() {
  return frameRound('#time [aria-label^="Add keyframe"]');
}

function frameRound(selector) {
  const element = document.querySelector(selector);
  const box = element?.getBoundingClientRect();
  return box?.width ? frame(box, 3) : null;
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

/** A handle's place in window pixels. */
function handlePoint(name, handle) {
  const point = handle && S.pose.points?.[handle.anchor];
  return point ? inWindow(name, point) : null;
}

function inWindow(name, point) {
  const shown = view(name);
  const at = shown?.eye && shown.project(point);
  if (!at || !Number.isFinite(at[0])) return null;
  const { left, top } = shown.el.getBoundingClientRect();
  return [left + at[0], top + at[1]];
}

function boxOf(name) {
  const points = Object.values(S.pose.points ?? {})
    .map((point) => inWindow(name, point))
    .filter(Boolean);
  if (!points.length) return null;
  const xs = points.map(([x]) => x);
  const ys = points.map(([, y]) => y);
  return { right: Math.max(...xs), top: Math.min(...ys), bottom: Math.max(...ys) };
}
