// Where the guide's card stands: in the corner of the large view that is out of the way of the
// handles to be dragged in this step, and otherwise farthest from the body. It stays there as long
// as it covers neither of them.

import { pull } from '../controls/gesture.js';
import { server } from '../store/state.js';
import { view } from '../views/views.js';
import { largeView } from '../handles/scale.js';
import { bodyInWindow, spotsOf } from './guide_spots.js';

// Room left for the tools, the heading and the panels at the view's edges, px.
const ROOM = { left: 72, top: 56, right: 12, bottom: 60 };
const GRASP = 48; // px round a handle in which the hand moves, and its mark stands
const FAR = 400; // px; beyond this it makes no difference

/** {name, x, y} for a card of this size; the corner `keep` as long as it is not in the way. */
export function cornerFor(card, step, keep) {
  const name = largeView();
  const frame = view(name).el.getBoundingClientRect();
  const size = { width: card.offsetWidth, height: card.offsetHeight };
  const body = bodyInWindow(name);
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
  const within = (value, most) => Math.min(Math.max(value, 4), most - 4);
  const move = (event) => {
    card.style.left = `${within(left + event.clientX - from.clientX, innerWidth - width)}px`;
    card.style.top = `${within(top + event.clientY - from.clientY, innerHeight - height)}px`;
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
  const top = Math.max(frame.top + ROOM.top, belowTints());
  const bottom = Math.max(top, frame.bottom - ROOM.bottom - height - 12);
  return [
    { name: 'bottom-left', x: left, y: bottom },
    { name: 'bottom-right', x: right, y: bottom },
    { name: 'top-left', x: left, y: top },
    { name: 'top-right', x: right, y: top },
  ];
}

/** Where the colours of an observed surface are chosen, nothing stands over them. */
function belowTints() {
  const bar = document.getElementById('mtint');
  return bar ? bar.getBoundingClientRect().bottom + 8 : 0;
}

const nearest = (points, corner, size) =>
  Math.min(FAR, ...points.map((point) => distance(point, corner, size)));

/** From a point to the nearest edge of the card; 0 inside. */
/** @param {number[]} at */
function distance([px, py], { x, y }, { width, height }) {
  const dx = Math.max(x - px, 0, px - x - width);
  const dy = Math.max(y - py, 0, py - y - height);
  return Math.hypot(dx, dy);
}
