// Where the handles stand that a step of the guide is about, in pixels of the window.

import { server } from '../store/state.js';
import { view } from '../views/views.js';
import { isPulled } from './guide_pulled.js';

/**
 * The handles that are still to be dragged in this step: [{handle, at}, …], those in sight.
 * @param {import('./guide_steps.js').Step} [step]
 */
export function spotsOf({ takes } = {}) {
  if (!takes) return [];
  return stillToPull(takes.kinds)
    .map((handle) => ({ handle, at: inWindow(takes.view, server.pose?.points?.[handle.anchor]) }))
    .filter(({ at }) => at && isIn(takes.view, at));
}

/** The first of the kinds of which any is left: hands and feet before elbows and knees. */
function stillToPull(kinds) {
  const all = server.body?.handles ?? [];
  for (const wanted of kinds) {
    const found = all.filter(({ kind }) => kind === wanted);
    const left = wanted === 'root' ? found : found.filter((handle) => !isPulled(handle));
    if (left.length) return left;
  }
  return [];
}

/** Every joint of the body, in the view of this name. */
export function bodyInWindow(name) {
  const points = Object.values(server.pose?.points ?? {});
  return points.map((point) => inWindow(name, point)).filter(Boolean);
}

function inWindow(name, point) {
  const shown = view(name);
  const at = point && shown?.eye && shown.project(point);
  if (!at || !Number.isFinite(at[0] + at[1])) return null;
  const { left, top } = shown.el.getBoundingClientRect();
  return [left + at[0], top + at[1]];
}

/**
 * @param {string} name
 * @param {number[]} at
 */
function isIn(name, [x, y]) {
  const { left, right, top, bottom } = view(name).el.getBoundingClientRect();
  return left <= x && x <= right && top <= y && y <= bottom;
}
