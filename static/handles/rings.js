// The three rotation rings about the selected part's joint: where they run, how they look.

import { svg, nothing } from '../vendor/lit-html/lit-html.js';
import { selectedPart } from '../store/parts.js';
import { server, ui } from '../store/state.js';
import { interaction, isHot } from './interaction.js';
import { gripsIn } from './grips.js';
import { isLarge, ringRadius } from './scale.js';
import { add, distance, axesOf, axesOfView, nearestOnPath, pathOf } from './space.js';

const AXES = ['x', 'y', 'z'];
const STEPS = 72;
const CLEAR_PX = 18;
// Where along its front half each ring carries its letter: apart from each other in most poses.
const LETTER_AT = { x: 0.5, y: 0.85, z: 0.2 };
// How far along it may give way where something stands there already.
const WAYS = [0, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3, 0.4, -0.4, 0.5, -0.5];

/** The axes a ring turns about, in the frame the person chose. */
function frameOf(view, part) {
  const own = server.pose.T[part.name];
  if (server.view.axes === 'view') return axesOfView(view.eye.rows);
  if (server.view.axes === 'parent' && part.parent) return axesOf(server.pose.T[part.parent]);
  if (server.view.axes === 'parent') return axesOfView();
  return axesOf(own);
}

/** The rings of the selected part in a view: [{axis, centre, e1, e2, points, front, …}]. */
export function ringsIn(view) {
  const part = selectedPart();
  const centre = part && server.pose.points[part.name];
  if (!centre || ui.tool === 'size') return [];
  const px = view.pxPerMetre(centre);
  if (!(px > 0)) return [];
  const axes = frameOf(view, part);
  const rings = AXES.map((axis, i) => {
    const [e1, e2] = [axes[(i + 1) % 3], axes[(i + 2) % 3]];
    return ringOf(view, { part, axis, centre, e1, e2, radius: ringRadius(view) / px });
  });
  placeLetters(view, rings);
  return rings;
}

const stays = () => {};

/** "Bend", "Twist": what the ring's axis means for this part. */
function labelOf({ part, axis }) {
  const word = part.words?.[axis];
  return word && server.view.axes === 'part' ? `${word}, ${axis.toUpperCase()}` : axis.toUpperCase();
}

function ringOf(view, ring) {
  const middle = view.project(ring.centre);
  const points = [];
  for (let i = 0; i <= STEPS; i++) {
    const [x, y, depth] = view.project(pointOn(ring, (2 * Math.PI * i) / STEPS));
    points.push([x, y, depth - middle[2] <= 0.03 * ring.radius]);
  }
  const key = `ring:${ring.part.name}:${ring.axis}`;
  return {
    ...ring,
    key,
    kind: 'ring',
    label: labelOf(ring),
    middle,
    points,
    front: frontOf(points),
    click: stays,
    clickTwice: stays,
  };
}

/** A point of the ring, at an angle from e1 toward e2. */
function pointOn(ring, angle, share = 1) {
  const r = ring.radius * share;
  return add(add(ring.centre, ring.e1, r * Math.cos(angle)), ring.e2, r * Math.sin(angle));
}

/** The near half as one polyline: it may begin anywhere on the ring. */
function frontOf(points) {
  const ring = points.slice(0, -1);
  const begin = ring.findIndex((p, i) => p[2] && !ring.at(i - 1)[2]);
  if (begin < 0) return ring.every((p) => p[2]) ? points : [];
  const turned = [...ring.slice(begin), ...ring.slice(0, begin)];
  return turned.slice(
    0,
    turned.findIndex((p) => !p[2]),
  );
}

/** Give each ring the place of its letter: clear of handles, of the joint and of one another. */
function placeLetters(view, rings) {
  if (!isLarge(view)) return;
  const taken = [rings[0].middle, ...gripsIn(view).map(({ at }) => at)];
  for (const ring of rings) {
    ring.letter = freePlace(ring, taken);
    if (ring.letter) taken.push(ring.letter);
  }
}

/** The usual place, or the nearest along the ring that is free; where none is, the freest. */
function freePlace({ axis, front }, taken) {
  const room = (p) => Math.min(...taken.map((other) => distance(p, other)));
  const places = WAYS.map((way) => LETTER_AT[axis] + way)
    .filter((share) => share >= 0 && share <= 1)
    .map((share) => front[Math.floor((front.length - 1) * share)])
    .filter(Boolean);
  const free = places.find((p) => room(p) > CLEAR_PX);
  return free ?? places.sort((p, q) => room(q) - room(p))[0] ?? null;
}

/** The angle on the ring nearest to a place on the screen. */
function angleAt(ring, x, y) {
  return (nearestOnPath(ring.points, x, y).place / STEPS) * 2 * Math.PI;
}

export function drawRings(view, rings) {
  if (!rings.length) return nothing;
  const gesture = server.pose.gesture;
  const turning = gesture?.axis && gesture.part === rings[0].part.name ? gesture.axis : null;
  const [x, y] = rings[0].middle;
  return svg`<g class="rings ${turning ? 'turning' : ''}">
    ${rings.map((ring) => drawRing(view, ring, turning))}
    ${
      turning
        ? drawWedge(
            view,
            rings.find((ring) => ring.axis === turning),
            gesture,
          )
        : nothing
    }
    ${hasGrip(rings[0].part) ? nothing : svg`<circle class="joint" cx=${x} cy=${y} r=${isLarge(view) ? 3 : 2.5} />`}
  </g>`;
}

/** Where a grab handle stands on the joint already, a dot more would only hide it. */
const hasGrip = (part) => server.body.handles.some(({ anchor }) => anchor === part.name);

function drawRing(view, ring, turning) {
  const active = turning === ring.axis;
  const state = `${active ? 'active' : turning ? 'faded' : ''} ${isHot(view, ring) ? 'hot' : ''}`;
  const front = pathOf(ring.front);
  const letter = turning && !active ? null : ring.letter;
  return svg`<g class="ring ${ring.axis} ${state}" data-ring=${ring.axis}>
    <path class="back" d=${pathOf(ring.points)} />
    <path class="edge" d=${front} /><path class="front" d=${front} />
    ${letter && !active ? drawLetter(letter, ring.axis) : nothing}
  </g>`;
}

function drawLetter([x, y], axis) {
  return svg`<circle class="knob" cx=${x} cy=${y} r="7" />
    <text class="letter" x=${x} y=${y + 3.5}>${axis.toUpperCase()}</text>`;
}

/** The turn made so far, as a slice of the ring, and its letter at the slice's end. */
function drawWedge(view, ring, gesture) {
  const begun = interaction.drag?.wedge;
  const base = begun?.axis === ring.axis ? { ...ring, e1: begun.e1, e2: begun.e2 } : ring;
  const from = begun?.axis === ring.axis ? begun.angle : 0;
  const steps = Math.max(2, Math.ceil(Math.abs(gesture.angle_rad) / 0.06));
  const arc = Array.from({ length: steps + 1 }, (_, i) =>
    view.project(pointOn(base, from + (gesture.angle_rad * i) / steps)),
  );
  return svg`<g class="ring active ${ring.axis}">
    <path class="wedge" d=${pathOf([ring.middle, ...arc], true)} />
    ${isLarge(view) ? drawLetter(arc.at(-1), ring.axis) : nothing}
  </g>`;
}

/** What a turn is measured from: the ring as it was when it was grabbed, and where. */
export function wedgeOf(ring, x, y) {
  return { axis: ring.axis, e1: ring.e1, e2: ring.e2, angle: angleAt(ring, x, y) };
}
