// What a press begins once it has moved: a drag of a handle, of a mask or of a part's surface, or a pan.
// Each returns the state of the press from then on.

import { keysLimb } from '../actions/review.js';
import { isFree, partNamed } from '../store/parts.js';
import { server, setUi, ui } from '../store/state.js';
import { beginDrag } from './drag.js';
import { beginPan } from './pan.js';
import { wedgeOf } from './rings.js';
import { select } from './select.js';
import { surfaceTool } from './tools.js';

/** @typedef {'dragging' | 'panning'} Begun */

/**
 * On a handle, a keypoint, a mask or the trail.
 * @returns {Begun}
 */
export function beginOnTarget(view, press, target) {
  const from = view.toView([press.x, press.y]);
  if (target.begin) {
    target.begin(view, press, target, from);
    return 'dragging';
  }
  // What is only clicked lets the view be pulled.
  if (!target.handle && target.kind !== 'ring') return beginPanning(view, press);
  const { handle = { kind: 'ring', part: target.part.name, axis: target.axis } } = target;
  const wedge = target.kind === 'ring' ? wedgeOf(target, press.x, press.y) : null;
  const carries = movesWhole();
  const open = handle.kind === 'ring' && isFree(handle.part, handle.axis);
  const movesAll = ['root', 'corner'].includes(target.kind) || target.isRoot || carries;
  const place = { ...view.inMessage(), ...limbOnly(movesAll) };
  const messageAt = (at, keys) => ({
    do: 'drag',
    ...place,
    handle,
    from,
    at,
    ...keys,
    free: open || keys.free,
    carry: carries || keys.carry,
  });
  const hint = target.kind === 'corner' ? 'corner' : handle.kind;
  const extra = { target, carries, wedge, point: target.point, limb: ui.limb, hint, axis: handle.axis };
  // The selected part stays so while its own limb is pulled.
  if (target.kind !== 'ring' && !target.limb?.includes(server.view.selected)) select(target.part);
  beginDrag(view, press, messageAt, extra);
  if (handle.kind === 'end') setUi('limb', target.limb);
  view.over.style.cursor = 'grabbing';
  return 'dragging';
}

/** In a review a drag keys the limb alone. */
const limbOnly = (movesAll) => (keysLimb() && !movesAll ? { partial: true } : {});

/** With the tool for the whole body, hands and feet go along. */
const movesWhole = () => ui.tool === 'move';

/**
 * On a part its tool decides; on nothing the view is panned.
 * @returns {Begun}
 */
export function beginOnSurface(view, press, part) {
  if (!part || ui.tool === 'size') return beginPanning(view, press);
  const root = partNamed(part)?.parent == null;
  const tool = surfaceTool(ui.tool, root);
  const handle = { kind: 'surface', part, tool };
  const from = view.toView([press.x, press.y]);
  select(part);
  const carries = movesWhole();
  const place = { ...view.inMessage(), ...limbOnly(tool === 'move' || carries) };
  const messageAt = (at, keys) => ({
    do: 'drag',
    ...place,
    handle,
    from,
    at,
    ...keys,
    carry: carries || keys.carry,
  });
  const hint = { rotate: 'turn', move: 'root', ends: 'end' }[tool];
  beginDrag(view, press, messageAt, { target: { key: `part:${part}`, part }, hint, carries });
  view.over.style.cursor = 'grabbing';
  return 'dragging';
}

/** @returns {Begun} */
function beginPanning(view, press) {
  beginPan(view, press.x, press.y);
  view.over.style.cursor = 'grabbing';
  return 'panning';
}
