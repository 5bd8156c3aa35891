// What this tab's pointer is about: what it hovers over, what it drags. One small record that the
// gestures write and the drawing reads.

import { setUi } from '../store/state.js';

export const interaction = {
  /** View and key of the handle under the pointer. */
  hot: null,
  /** Of handles that lie over each other the one that was chosen: {view, key, order}. */
  chosen: null,
  /** The part under the pointer: {view, part, outline, named, at}. */
  over: null,
  /** The drag under way: {view, target, stroke, from, wedge, …}. */
  drag: null,
  /** Where the pointer was last seen: {view, x, y}. */
  pointer: null,
  /** The view that is being panned. */
  panning: null,
  /** A drawing begun with the mask, the vertical, the horizon or the box tool: {tool, points, pointer, hold}. */
  sketch: null,
  /** The tool that was in hand before the drawing began, and is taken up again after it. */
  before: 'select',
};

/** Put the drawing tool away. */
export const leaveSketch = () => setUi('tool', interaction.before);

const listeners = new Set();
let asked = false;

/** Call fn once per animation frame after something dragged or hovered changed. */
export function onInteraction(fn) {
  listeners.add(fn);
}

/** Something changed: draw with the next animation frame. */
export function redrawSoon() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    for (const fn of listeners) fn();
  });
}

/** Of handles that lie over each other this one is meant, until the pointer leaves it. */
export function choose(view, stack, target) {
  const order = stack.map(({ key }) => key);
  interaction.chosen = order.length > 1 ? { view: view.name, key: target.key, order } : null;
}

/** Whether this target of this view is under the pointer. */
export function isHot(view, target) {
  return interaction.hot?.view === view.name && interaction.hot.key === target.key;
}

/** Whether this target is the one being dragged, in whichever view. */
export function isDragged(target) {
  return interaction.drag?.target?.key === target.key;
}
