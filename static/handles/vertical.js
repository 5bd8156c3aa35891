// Drawing a line along something upright.

import { nothing, svg } from '../vendor/lit-html/lit-html.js';
import { send } from '../store/link.js';
import { interaction, leaveSketch } from './interaction.js';
import { outline } from './outline.js';
import { distance, pathOf } from './space.js';

const SHORTEST_PX = 12;

/** The line drawn before, for as long as the tool is in hand: with a second one it shows the tilt. */
let before = null;

/** The first line, while the second is asked for. */
const drawn = (view) => svg`<g class="sketch"><path d=${pathOf(before.map((spot) => view.fromView(spot)))} /></g>`;

/** @type {import('./drawing_tool.js').Tool} */
export const vertical = {
  icon: 'mid',
  hints: [
    ['Drag', 'along something upright, then along a second'],
    ['Esc', 'done'],
  ],
  words: () =>
    before
      ? 'Now along a second one, far from the first: both show how the camera tilts.'
      : 'Drag along something upright: a wall, a door, a pole.',
  down: (view, x, y) => void (interaction.sketch.points = [view.toView([x, y])]),
  up(view, x, y) {
    const [a] = interaction.sketch.points;
    interaction.sketch.points = [];
    if (!a || distance(view.fromView(a), [x, y]) < SHORTEST_PX) return;
    const line = [a, view.toView([x, y])];
    send({ do: 'vertical', a: line[0], b: line[1], ...(before ? { other: before } : {}) });
    if (before) leaveSketch();
    before = before ? null : line;
  },
  cancel: () => void (interaction.sketch.points = []),
  forget: () => void (before = null),
  draw: (view) => svg`${before ? drawn(view) : nothing}${outline.draw(view)}`,
};
