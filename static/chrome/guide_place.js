// Where the guide's card stands: in the corner of the large view that is farthest from the body.

import { S } from '../state.js';
import { view } from '../views.js';

// Room left for the tools, the heading and the panels at the view's edges, px.
const ROOM = { left: 72, top: 56, right: 12, bottom: 60 };
const NEAR = 16; // px; nearer than this the card is in the way

/** {name, x, y} for a card of this size; the corner `keep` as long as it is not in the way. */
export function cornerFor(card, keep) {
  const frame = document.getElementById('main').getBoundingClientRect();
  const size = { width: card.offsetWidth, height: card.offsetHeight };
  const points = bodyInWindow();
  const corners = cornersOf(frame, size).map((corner) => ({
    ...corner,
    away: Math.min(400, ...points.map((point) => distance(point, corner, size))),
  }));
  const kept = corners.find(({ name }) => name === keep);
  if (kept && kept.away > NEAR) return kept;
  return corners.reduce((best, one) => (one.away > best.away ? one : best));
}

/** Carry the card with the pointer that has taken it, within the window. */
export function carry({ currentTarget: card, pointerId, clientX, clientY }) {
  const { left, top, width, height } = card.getBoundingClientRect();
  const within = (value, most) => Math.min(Math.max(value, 4), most - 4);
  card.setPointerCapture(pointerId);
  card.onpointermove = (event) => {
    card.style.left = `${within(left + event.clientX - clientX, innerWidth - width)}px`;
    card.style.top = `${within(top + event.clientY - clientY, innerHeight - height)}px`;
  };
  card.onlostpointercapture = () => (card.onpointermove = null);
}

function cornersOf(frame, { width, height }) {
  const left = frame.left + ROOM.left;
  const right = frame.right - ROOM.right - width;
  const top = frame.top + ROOM.top;
  const bottom = Math.max(top, frame.bottom - ROOM.bottom - height - 12);
  return [
    { name: 'bottom-left', x: left, y: bottom },
    { name: 'bottom-right', x: right, y: bottom },
    { name: 'top-left', x: left, y: top },
    { name: 'top-right', x: right, y: top },
  ];
}

/** Every joint of the body in window pixels, in the view that shows the camera's picture. */
function bodyInWindow() {
  const camera = view('main');
  const points = Object.values(S.pose?.points ?? {});
  if (!camera?.eye || !points.length) return [];
  const { left, top } = camera.el.getBoundingClientRect();
  return points
    .map((point) => camera.project(point))
    .filter((at) => at && Number.isFinite(at[0]))
    .map(([x, y]) => [left + x, top + y]);
}

/** From a point to the nearest edge of the card; 0 inside. */
function distance([px, py], { x, y }, { width, height }) {
  const dx = Math.max(x - px, 0, px - x - width);
  const dy = Math.max(y - py, 0, py - y - height);
  return Math.hypot(dx, dy);
}
