// Drawing on the picture: the outline of an ignore mask, a line along something upright, the horizon,
// or the box around a person.

import { svg, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { perform, whyNot } from '../actions/actions.js';
import { runToDraft, setDraftRange } from '../actions/drafting.js';
import { goTo, stopPlaying } from '../actions/playhead.js';
import { keepsKey } from '../controls/focus.js';
import { view as viewNamed } from '../views/views.js';
import { boxCancel, boxCursor, boxDown, boxHint, boxKey, boxMove, boxUp, drawBox } from './box.js';
import {
  drawHorizon, horizonCancel, horizonCursor, horizonDown, horizonHint, horizonKey, horizonMove, horizonUp,
} from './horizon.js';
import { interaction, redrawSoon } from './interaction.js';
import { distance, pathOf } from './space.js';

const CLOSE_PX = 10;
const SAME_PX = 4;
const SHORTEST_PX = 12;

/** The tool that was in hand before the drawing began, and is taken up again after it. */
let before = 'select';

const TOOLS = ['mask', 'vertical', 'horizon', 'box'];

export const isDrawingTool = (tool) => TOOLS.includes(tool);

/** Tools whose shape is pulled and stays while they are in hand. */
const SHAPES = {
  box: { down: boxDown, move: boxMove, up: boxUp, cancel: boxCancel, key: boxKey, hint: boxHint, cursor: boxCursor, draw: drawBox },
  horizon: {
    down: horizonDown, move: horizonMove, up: horizonUp, cancel: horizonCancel, key: horizonKey,
    hint: horizonHint, cursor: horizonCursor, draw: drawHorizon,
  },
};

/** The tool changed: forget what was begun, and show the picture large. */
export function prepareSketch() {
  viewNamed('main').el.classList.toggle('boxing', ui.tool === 'box');
  if (ui.tool !== 'box') setUi('box', null);
  if (!isDrawingTool(ui.tool)) {
    before = ui.tool;
    interaction.sketch = null;
    return;
  }
  if (interaction.sketch?.tool === ui.tool) return;
  interaction.sketch = { tool: ui.tool, points: [], pointer: null, hold: null };
  setUi('mask', null);
  if (ui.layout !== 'main' && ui.layout !== 'quad') setUi('layout', 'main');
}

/** Whether a pointer on this view draws. */
export function drawsOn(view) {
  if (!isDrawingTool(ui.tool) || view.name !== 'main') return false;
  // The tool may have been taken up since the last animation frame.
  prepareSketch();
  return true;
}

/** A press on the main view with a drawing tool. */
export function sketchDown(view, x, y) {
  const { sketch } = interaction;
  if (sketch.tool === 'vertical') sketch.points = [view.toView([x, y])];
  SHAPES[sketch.tool]?.down(view, x, y);
  sketch.pointer = [x, y];
  redrawSoon();
}

export function sketchMove(view, x, y) {
  interaction.sketch.pointer = [x, y];
  SHAPES[interaction.sketch.tool]?.move(view, x, y);
  redrawSoon();
}

/** A release: a mask gets a corner or is closed, a vertical line is done, a shape is let go. */
export function sketchUp(view, x, y) {
  const { sketch } = interaction;
  if (sketch.tool === 'vertical') return finishVertical(view, x, y);
  if (SHAPES[sketch.tool]) {
    SHAPES[sketch.tool].up(view, x, y);
    return redrawSoon();
  }
  const corners = sketch.points.map((p) => view.fromView(p));
  const again = corners.length && distance(corners.at(-1), [x, y]) < SAME_PX;
  const home = corners.length > 2 && distance(corners[0], [x, y]) < CLOSE_PX;
  if (again || home) closeMask();
  else sketch.points.push(view.toView([x, y]));
  redrawSoon();
}

/** The press that draws is cancelled. */
export function sketchCancel() {
  SHAPES[interaction.sketch?.tool]?.cancel();
  if (interaction.sketch?.tool === 'vertical') interaction.sketch.points = [];
  redrawSoon();
}

/** Keys of the drawing tools, by name; true when the key was one. */
export function sketchKey(event, key) {
  if (!isDrawingTool(ui.tool)) return false;
  prepareSketch();
  const { sketch } = interaction;
  if (key === 'escape') leaveSketch();
  else if (SHAPES[sketch.tool]) return SHAPES[sketch.tool].key(event, key) || (sketch.tool === 'box' && key === 'enter' && enterBox());
  else if (sketch.tool === 'mask' && key === 'enter') closeMask();
  else if (sketch.tool === 'mask' && (key === 'backspace' || key === 'delete')) sketch.points.pop();
  else return false;
  redrawSoon();
  return true;
}

function closeMask() {
  const { points } = interaction.sketch;
  if (points.length < 3) return;
  // The whole film: what covers something for a while only is given its frames in the Camera tab.
  send({ do: 'add_mask', polygon: points, first: 0, last: server.file.frames - 1 });
  setUi('mask', (server.masks ?? []).length);
  leaveSketch();
}

/** Enter on a control that was reached with Tab is that control's. */
function enterBox() {
  if (!ui.box || keepsKey('Enter')) return false;
  draftFromBox();
  return true;
}

/** Draft from the box, which is done with. */
export function draftFromBox() {
  const why = whyNot('draft');
  perform('draft');
  if (why) return;
  setUi('draftRange', null);
  leaveSketch();
}

/** Draw a box at a frame, for the frames there that have no draft. */
export function drawBoxAt(frame) {
  setDraftRange(...runToDraft(server.draft.missing));
  stopPlaying();
  goTo(frame);
  setUi('tool', 'box');
}

/** Put the drawing tool away. */
export function leaveSketch() {
  setUi('tool', before);
}

function finishVertical(view, x, y) {
  const [a] = interaction.sketch.points;
  interaction.sketch.points = [];
  if (!a || distance(view.fromView(a), [x, y]) < SHORTEST_PX) return redrawSoon();
  send({ do: 'vertical', a, b: view.toView([x, y]) });
  leaveSketch();
  redrawSoon();
}

/** What to do now, in one line. */
export function sketchHint() {
  const { sketch } = interaction;
  if (!sketch) return null;
  if (SHAPES[sketch.tool]) return SHAPES[sketch.tool].hint();
  if (sketch.tool === 'vertical') return 'Drag along something upright: a wall, a door, a pole. Where the camera looks down, draw the horizon instead.';
  const begun = sketch.points.length;
  if (!begun) return 'Click around anything that moves but is not the body.';
  if (begun < 3) return 'Keep clicking. Backspace removes the last corner, Esc cancels.';
  return 'Press Enter or click the first corner to close. Backspace removes the last corner, Esc cancels.';
}

/** What the pointer over a view would do with the tool in hand. */
export function sketchCursor(view) {
  if (view.name !== 'main') return '';
  return SHAPES[interaction.sketch?.tool]?.cursor(view) ?? 'crosshair';
}

export function drawSketch(view) {
  const { sketch } = interaction;
  if (!sketch || view.name !== 'main') return nothing;
  if (SHAPES[sketch.tool]) return SHAPES[sketch.tool].draw(view);
  const corners = sketch.points.map((p) => viewNamed('main').fromView(p));
  const line = sketch.pointer && corners.length ? [...corners, sketch.pointer] : corners;
  const home = corners.length > 2 && sketch.pointer && distance(corners[0], sketch.pointer) < CLOSE_PX;
  return svg`<g class="sketch">
    ${sketch.tool === 'mask' && line.length > 2
      ? svg`<path class="area" d=${pathOf(line, true)} />`
      : nothing}
    <path class="line-edge" d=${pathOf(line)} /><path class="line" d=${pathOf(line)} />
    ${corners.map(([x, y], i) => {
      const first = i === 0 && corners.length > 2;
      return svg`<circle class="corner ${first && home ? 'hot' : ''}" cx=${x} cy=${y} r=${first ? 6 : 4} />`;
    })}
  </g>`;
}
