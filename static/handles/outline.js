// Drawing the outline of an ignore mask, a corner a click.

import { nothing, svg } from '../vendor/lit-html/lit-html.js';
import { send } from '../store/link.js';
import { server, setUi } from '../store/state.js';
import { interaction, leaveSketch } from './interaction.js';
import { distance, pathOf } from './space.js';

const CLOSE_PX = 10;
const SAME_PX = 4;

/** @type {import('./drawing_tool.js').Tool} */
export const outline = {
  icon: 'loop',
  hints: [
    ['Click', 'corner'],
    ['Enter', 'close'],
    ['Backspace', 'remove the last corner'],
    ['Esc', 'cancel'],
  ],
  words() {
    const begun = interaction.sketch.points.length;
    if (!begun) {
      return 'Click around what moves but is not the body: it counts neither for tracking nor for the camera’s motion.';
    }
    if (begun < 3) return 'Keep clicking. Backspace removes the last corner, Esc cancels.';
    return 'Press Enter or click the first corner to close. Backspace removes the last corner, Esc cancels.';
  },
  up(view, x, y) {
    const { points } = interaction.sketch;
    const corners = points.map((p) => view.fromView(p));
    const again = corners.length && distance(corners.at(-1), [x, y]) < SAME_PX;
    const home = corners.length > 2 && distance(corners[0], [x, y]) < CLOSE_PX;
    if (again || home) close();
    else points.push(view.toView([x, y]));
  },
  key(_, name) {
    if (name === 'enter') close();
    else if (name === 'backspace' || name === 'delete') interaction.sketch.points.pop();
    else return false;
    return true;
  },
  draw(view) {
    const { points, pointer } = interaction.sketch;
    const corners = points.map((p) => view.fromView(p));
    const line = pointer && corners.length ? [...corners, pointer] : corners;
    const home = corners.length > 2 && pointer && distance(corners[0], pointer) < CLOSE_PX;
    return svg`<g class="sketch">
      ${line.length > 2 ? svg`<path class="area" d=${pathOf(line, true)} />` : nothing}
      <path class="line-edge" d=${pathOf(line)} /><path class="line" d=${pathOf(line)} />
      ${corners.map(([x, y], i) => {
        const first = i === 0 && corners.length > 2;
        return svg`<circle class="corner ${first && home ? 'hot' : ''}" cx=${x} cy=${y} r=${first ? 6 : 4} />`;
      })}
    </g>`;
  },
};

function close() {
  const { points } = interaction.sketch;
  if (points.length < 3) return;
  // The whole film: what covers something for a while only is given its frames in the Camera tab.
  send({ do: 'add_mask', polygon: points, first: 0, last: server.file.frames - 1 });
  setUi('mask', (server.masks ?? []).length);
  leaveSketch();
}
