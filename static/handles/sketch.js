// The tools that draw on the picture: the outline of an ignore mask, a line along something upright, the
// horizon, the box around a person, and points that two frames share.

import { nothing } from '../vendor/lit-html/lit-html.js';
import { ui, setUi } from '../store/state.js';
import { view as viewNamed } from '../views/views.js';
import { box } from './box.js';
import { cameraHorizon, horizon } from './horizon.js';
import { interaction, leaveSketch, redrawSoon } from './interaction.js';
import { cameraMatch } from './match.js';
import { outline } from './outline.js';
import { vertical } from './vertical.js';

/** @typedef {import('./drawing_tool.js').Tool} Tool */

/** @type {Record<string, Tool>} */
export const DRAWING = { mask: outline, vertical, horizon, box, cameraHorizon, cameraMatch };

export const isDrawingTool = (tool) => tool in DRAWING;

/** The tool that draws now. @returns {Tool | undefined} */
export const drawingTool = () => DRAWING[interaction.sketch?.tool];

/** The tool changed: forget what was begun, and show the picture large. */
export function prepareSketch() {
  viewNamed('main').el.classList.toggle('boxing', ui.tool === 'box');
  if (ui.tool !== 'box') setUi('box', null);
  if (!isDrawingTool(ui.tool)) {
    interaction.before = ui.tool;
    interaction.sketch = null;
    return;
  }
  if (interaction.sketch?.tool === ui.tool) return;
  DRAWING[ui.tool].forget?.();
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

/** What a pointer does on the main view. @param {'down' | 'move' | 'up' | 'cancel'} what */
export function sketch(what, view = null, x = 0, y = 0) {
  if (what === 'down' || what === 'move') interaction.sketch.pointer = [x, y];
  drawingTool()?.[what]?.(view, x, y);
  redrawSoon();
}

/** Keys of the drawing tools, by name; true when the key was one. */
export function sketchKey(event, key) {
  if (!isDrawingTool(ui.tool)) return false;
  prepareSketch();
  if (key === 'escape') leaveSketch();
  else if (!drawingTool().key?.(event, key)) return false;
  redrawSoon();
  return true;
}

/** What the pointer over a view would do with the tool in hand. */
export const sketchCursor = (view) => (view.name === 'main' ? (drawingTool()?.cursor?.(view) ?? 'crosshair') : '');

export const drawSketch = (view) => (view.name === 'main' ? drawingTool()?.draw(view) : nothing);
export const drawSketchLabel = (view) => (view.name === 'main' ? drawingTool()?.label?.(view) : nothing);
