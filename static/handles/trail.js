// Frame numbers on the motion trail: a diamond where a keyframe lies, which is also where its
// ghost stands. The line itself belongs to the scene.

import { svg, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { isHot } from './interaction.js';
import { isLarge } from './scale.js';

/** The trail's keyframes in a view, the present one left out. */
export function trailKeysIn(view) {
  if (view.trailKeys) return view.trailKeys().map(keyOfWay);
  const trail = server.trail;
  if (!trail) return [];
  const keys = new Set(trail.keys);
  return trail.points
    .filter(([frame]) => keys.has(frame) && frame !== server.view.frame)
    .map(([frame, ...point]) => {
      const [x, y] = view.project(point);
      return { key: `trail:${frame}`, kind: 'trail', frame, at: [x, y], label: `Frame ${frame}` };
    });
}

/** In the free view they lie on the ways of the feet. */
function keyOfWay({ part, frame, at, label }) {
  return { key: `trail:${part}:${frame}`, kind: 'trail', frame, at: at.slice(0, 2), label };
}

export function drawTrail(view, keys) {
  if (view.trailKeys) return svg`<g class="trail">${keys.map((target) => drawWayKey(view, target))}</g>`;
  if (!server.trail || !(server.view.trail || server.view.ghosts)) return nothing;
  return svg`<g class="trail">
    ${isLarge(view) ? drawFrames(view) : nothing}
    ${keys.map((target) => drawKey(view, target))}
  </g>`;
}

/** A dot for every second frame: close together where the motion is slow. */
function drawFrames(view) {
  if (!server.view.trail) return nothing;
  return server.trail.points
    .filter(([frame]) => frame % 2 && frame !== server.view.frame)
    .map(([, ...point]) => {
      const [x, y] = view.project(point);
      return svg`<circle class="dot" cx=${x} cy=${y} r="1.5" />`;
    });
}

function drawWayKey(view, target) {
  const r = isHot(view, target) ? 6 : 4;
  const [x, y] = target.at;
  const state = target.frame === server.view.frame ? 'present' : '';
  return svg`<path class="key ${state}" d="M${x} ${y - r}l${r} ${r}-${r} ${r}-${r}-${r}z" />`;
}

function drawKey(view, target) {
  const large = isLarge(view);
  const r = (large ? 5 : 3.5) * (isHot(view, target) ? 1.3 : 1);
  const [x, y] = target.at;
  const before = target.frame < server.view.frame;
  const left = leftOf(view, target, before);
  return svg`<path class="key" d="M${x} ${y - r}l${r} ${r}-${r} ${r}-${r}-${r}z" />
    ${large
      ? svg`<text class=${left ? 'left' : ''} x=${x + (left ? -9 : 9)} y=${y + 4}>${target.frame}</text>`
      : nothing}`;
}

/** The number stands on the side away from where the motion goes on. */
function leftOf(view, target, before) {
  const points = server.trail.points;
  const at = points.findIndex(([frame]) => frame === target.frame);
  const next = points[at + (before ? 1 : -1)];
  if (!next) return !before;
  return view.project(next.slice(1))[0] > target.at[0];
}
