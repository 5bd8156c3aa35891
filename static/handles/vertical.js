// Drawing a line along something upright.

import { send } from '../store/link.js';
import { interaction, leaveSketch } from './interaction.js';
import { outline } from './outline.js';
import { distance } from './space.js';

const SHORTEST_PX = 12;

/** @type {import('./sketch.js').Tool} */
export const vertical = {
  icon: 'mid',
  hints: [['Drag', 'along something upright'], ['Esc', 'cancel']],
  words: () => 'Drag along something upright: a wall, a door, a pole. Where the camera looks down, draw the horizon instead.',
  down: (view, x, y) => void (interaction.sketch.points = [view.toView([x, y])]),
  up(view, x, y) {
    const [a] = interaction.sketch.points;
    interaction.sketch.points = [];
    if (!a || distance(view.fromView(a), [x, y]) < SHORTEST_PX) return;
    send({ do: 'vertical', a, b: view.toView([x, y]) });
    leaveSketch();
  },
  cancel: () => void (interaction.sketch.points = []),
  draw: outline.draw,
};
