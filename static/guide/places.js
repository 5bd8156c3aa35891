// What the guide points at, and where its card stands: the handles that a step is about, in pixels of
// the window; their marks, drawn over it and never in the pointer's way; and for the card the corner of
// the large view that is out of the way of these handles and otherwise farthest from the body. It stays
// there as long as it covers neither of them.

import { clamp } from '../controls/arithmetic.js';
import { html, nothing, render, svg } from '../vendor/lit-html/lit-html.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { pull } from '../controls/gesture.js';
import { interaction } from '../handles/interaction.js';
import { view } from '../views/views.js';
import { largeView } from '../handles/scale.js';

// Which handles were pulled in this step: their marks go.
let drag = null; // the drag under way, or the last one
ui.pulled = new Set();

/** Whether this handle was pulled already. */
const isPulled = ({ name }) => ui.pulled.has(name);

/** All marks come back. */
export const forgetPulled = () => setUi('pulled', new Set());

export function mountPulled() {
  watch(['u:dragging', 'pose'], () => {
    if (interaction.drag) drag = interaction.drag;
    else if (drag) notice();
  });
}

/** What was cancelled, or sent nothing, pulled nothing. */
function notice() {
  const { target, sent, kept } = drag;
  drag = null;
  if (sent && kept && target?.handle?.name) setUi('pulled', new Set(ui.pulled).add(target.handle.name));
}

/**
 * The handles that are still to be dragged in this step: [{handle, at}, …], those in sight.
 * @param {import('./step.js').Step} [step]
 */
function spotsOf({ takes } = {}) {
  if (!takes) return [];
  return stillToPull(takes.kinds)
    .map((handle) => ({ handle, at: inWindow(takes.view, server.pose?.points?.[handle.anchor]) }))
    .filter(({ at }) => at && isIn(takes.view, at));
}

/** The first of the kinds of which any is left: hands and feet before elbows and knees. */
function stillToPull(kinds) {
  const all = server.body?.handles ?? [];
  for (const wanted of kinds) {
    const found = all.filter(({ kind }) => kind === wanted);
    const left = wanted === 'root' ? found : found.filter((handle) => !isPulled(handle));
    if (left.length) return left;
  }
  return [];
}

/** Every joint of the body, in the view of this name. */
function bodyInWindow(name) {
  const points = Object.values(server.pose?.points ?? {});
  return points.map((point) => inWindow(name, point)).filter(Boolean);
}

/** Corners, edges and the middle of a box on the picture. */
function boxInWindow(name, [x0, y0, x1, y1]) {
  const { left, top } = view(name).el.getBoundingClientRect();
  const spots = [x0, (x0 + x1) / 2, x1].flatMap((x) => [y0, (y0 + y1) / 2, y1].map((y) => [x, y]));
  return spots.map((spot) => view(name).fromView(spot)).map(([x, y]) => [left + x, top + y]);
}

function inWindow(name, point) {
  const shown = view(name);
  const at = point && shown?.eye && shown.project(point);
  if (!at || !Number.isFinite(at[0] + at[1])) return null;
  const { left, top } = shown.el.getBoundingClientRect();
  return [left + at[0], top + at[1]];
}

/**
 * @param {string} name
 * @param {number[]} at
 */
function isIn(name, [x, y]) {
  const { left, right, top, bottom } = view(name).el.getBoundingClientRect();
  return left <= x && x <= right && top <= y && y <= bottom;
}

const MARKS = {
  hips: anywhere,
  height: upAndDown,
  facing: () => null,
  limbs: roundEnds,
  depth: inSide,
  key: onKey,
};

/** Draw the marks of this step, or none. */
export function drawMarks(place, step) {
  const shapes = step?.name && server.pose ? MARKS[step.name](step) : null;
  render(shapes ? html`<svg aria-hidden="true">${shapes}</svg>` : nothing, place);
}

/** A ring round the point at the hips, with arrows: it may go anywhere. */
function anywhere(step) {
  return onHandles(
    step,
    ([x, y]) => svg`<g transform="translate(${x} ${y})">
    ${ring(0, 0, 20)}${[0, 90, 180, 270].map(tip)}
  </g>`,
  );
}

/** A double arrow through the point at the hips. */
function upAndDown(step) {
  return onHandles(
    step,
    ([x, y]) => svg`<g transform="translate(${x} ${y})">
    ${ring(0, 0, 20)}<path class="line" d="M0-28V-46M0 28V46" />
    <g transform="translate(0 -14)">${tip(0)}</g><g transform="translate(0 14)">${tip(180)}</g>
  </g>`,
  );
}

const tip = (turn) => svg`<path class="tip" transform="rotate(${turn})" d="M0-37l7 9H-7z" />`;

function roundEnds(step) {
  return onHandles(step, ([x, y], { kind }) => ring(x, y, kind === 'end' ? 15 : 12));
}

/** A frame round the side view, and rings round what may be pulled there. */
function inSide(step) {
  const side = view('side')?.el?.getBoundingClientRect();
  if (!side) return null;
  return svg`${drawFrame(side, -2)}${onHandles(step, ([x, y]) => ring(x, y, 9))}`;
}

function onKey() {
  const box = document.querySelector('#time [data-action=addKeyframe]')?.getBoundingClientRect();
  return box?.width ? drawFrame(box, 3) : null;
}

/** A mark on each of the step's handles, none of it outside their view. */
function onHandles(step, draw) {
  const { left, top, width, height } = view(step.takes.view).el.getBoundingClientRect();
  return svg`<clipPath id="guide-clip"><rect x=${left} y=${top} width=${width} height=${height} /></clipPath>
    <g clip-path="url(#guide-clip)">${spotsOf(step).map(({ at, handle }) => draw(at, handle))}</g>`;
}

const ring = (x, y, r) => svg`<circle class="halo" cx=${x} cy=${y} r=${r} />
  <circle class="ring" cx=${x} cy=${y} r=${r} />`;

const drawFrame = (box, room) => svg`<rect
  class="frame"
  x=${box.left - room}
  y=${box.top - room}
  width=${box.width + 2 * room}
  height=${box.height + 2 * room}
  rx="6"
/>`;

// Room left for the tools, the heading and the panels at the view's edges, px.
const ROOM = { left: 72, top: 56, right: 12, bottom: 60 };
const GRASP = 48; // px round a handle in which the hand moves, and its mark stands
const FAR = 400; // px; beyond this it makes no difference

/** Put a card into its corner, the one named `keep` as long as it is not in the way; the corner's name. */
export function placeInCorner(card, step, keep) {
  const { name, x, y } = cornerFor(card, step, keep);
  card.style.left = `${x}px`;
  card.style.top = `${y}px`;
  return name;
}

function cornerFor(card, step, keep) {
  const name = largeView();
  const frame = view(name).el.getBoundingClientRect();
  const size = { width: card.offsetWidth, height: card.offsetHeight };
  const body = ui.tool === 'box' && ui.box ? boxInWindow(name, ui.box) : bodyInWindow(name);
  const spots = spotsOf(step).map(({ at }) => at);
  const corners = cornersOf(frame, size).map((corner) => {
    const away = nearest(body, corner, size);
    const clear = Math.min(GRASP, nearest(spots, corner, size));
    return { ...corner, away, clear, bare: overPicture(corner, size) ? 0 : 1 };
  });
  const kept = corners.find((corner) => corner.name === keep);
  if (kept && kept.away > 0 && kept.clear >= GRASP / 2) return kept;
  return corners.reduce((best, one) => (goodness(one) > goodness(best) ? one : best));
}

/** Whether the card, wherever it is, covers a handle that is to be dragged. */
export function covers(card, step) {
  const { left: x, top: y, width, height } = card.getBoundingClientRect();
  return spotsOf(step).some(({ at }) => distance(at, { x, y }, { width, height }) < GRASP / 2);
}

/** Whether the card covers the value of a drag, or the hint of a drawing. */
export function coversWords(card) {
  const box = card.getBoundingClientRect();
  return [...document.querySelectorAll('.hud .flt:not(.name), #mhint')].some((words) => {
    const { left, top, right, bottom } = words.getBoundingClientRect();
    return left < box.right && right > box.left && top < box.bottom && bottom > box.top;
  });
}

/** Carry the card with the pointer that has taken it, within the window. */
export function carry(from) {
  const card = from.currentTarget;
  const { left, top, width, height } = card.getBoundingClientRect();
  const move = (event) => {
    card.style.left = `${clamp(left + event.clientX - from.clientX, 4, innerWidth - width - 4)}px`;
    card.style.top = `${clamp(top + event.clientY - from.clientY, 4, innerHeight - height - 4)}px`;
  };
  pull(card, from, { move });
}

/** To keep clear of the handles counts more than all else, then to leave the picture free. */
const goodness = ({ away, clear, bare }) => (FAR / GRASP) * 4 * clear + 2 * FAR * bare + away;

/** Whether the card would cover any of the film: the person may be there. */
function overPicture({ x, y }, { width, height }) {
  if (largeView() !== 'main' || !server.camera) return false;
  const camera = view('main');
  const { left, top } = camera.el.getBoundingClientRect();
  const [x0, y0] = camera.fromView([-0.5, -0.5]);
  const [x1, y1] = camera.fromView([server.camera.width - 0.5, server.camera.height - 0.5]);
  return x < left + x1 && x + width > left + x0 && y < top + y1 && y + height > top + y0;
}

function cornersOf(frame, { width, height }) {
  const left = frame.left + ROOM.left;
  const right = Math.max(left, frame.right - ROOM.right - width);
  const top = Math.max(frame.top + ROOM.top, belowBars());
  const bottom = Math.max(top, frame.bottom - ROOM.bottom - height - 12);
  return [
    { name: 'bottom-left', x: left, y: bottom },
    { name: 'bottom-right', x: right, y: bottom },
    { name: 'top-left', x: left, y: top },
    { name: 'top-right', x: right, y: top },
  ];
}

/** Where the colours of an observed surface are chosen, and where a draft is described, nothing stands over them. */
function belowBars() {
  const bars = ['mtint', 'mdraft'].map((id) => document.getElementById(id)?.getBoundingClientRect());
  return Math.max(0, ...bars.map((bar) => (bar ? bar.bottom + 8 : 0)));
}

const nearest = (points, corner, size) => Math.min(FAR, ...points.map((point) => distance(point, corner, size)));

/** From a point to the nearest edge of the card; 0 inside. */
/** @param {number[]} at */
function distance([px, py], { x, y }, { width, height }) {
  const dx = Math.max(x - px, 0, px - x - width);
  const dy = Math.max(y - py, 0, py - y - height);
  return Math.hypot(dx, dy);
}
