// How much the image tells about each part over the frames, gathered into lanes.

import { server } from '../../store/state.js';
import { remembered } from './layers.js';
import { extent, numbers } from './series.js';

export const HIDDEN_BELOW = 0.35;

/**
 * One value per frame for several parts: half their mean, half the worst of them, since a limb
 * whose hand is hidden is not seen well however well the arm is. NaN where no part has a value.
 */
const together = (sum, count, worst) => (sum / count + worst) / 2;
const worstOf = (sum, count, worst) => worst;

function combined(series, combine) {
  const result = new Float32Array(Math.max(0, ...series.map((values) => values.length)));
  for (let i = 0; i < result.length; i += 1) {
    let sum = 0;
    let count = 0;
    let worst = Infinity;
    for (const values of series) {
      const value = values[i];
      // Missing values are NaN, which equals nothing, itself included.
      if (value !== value) continue;
      sum += value;
      count += 1;
      if (value < worst) worst = value;
    }
    result[i] = count === 0 ? NaN : combine(sum, count, worst);
  }
  return result;
}

const of = (lanes, parts) =>
  parts.filter((part) => lanes[part]).map((part) => numbers(lanes[part]));

/** Whether any part has a value anywhere. */
export const anyLane = remembered((lanes) =>
  Object.values(lanes ?? {}).some((values) => extent(numbers(values)) !== null),
);

/**
 * The lanes from top to bottom: {label, parts, values, kind: "group|part|weakest", open}.
 * `open` names the groups whose parts are listed under them.
 */
export const lanesOf = remembered((lanes, body, folded, open) => {
  if (!body || !anyLane(lanes)) return [];
  const parts = body.parts.map((part) => part.name);
  if (folded) {
    const values = combined(of(lanes, parts), worstOf);
    return [{ label: 'Weakest part', parts, values, kind: 'weakest' }];
  }
  const labels = new Map(body.parts.map((part) => [part.name, part.label]));
  return body.lanes.flatMap((group) => {
    const isOpen = open.has(group.label);
    const values = combined(of(lanes, group.parts), together);
    const head = { ...group, values, kind: 'group', open: isOpen };
    if (!isOpen) return [head];
    const single = (part) => ({
      label: labels.get(part) ?? part, parts: [part], values: lanes[part] ?? [], kind: 'part',
    });
    return [head, ...group.parts.map(single)];
  });
});

/** The part a click on a lane means: the selected one if it is there, else the weakest here. */
export function partMeant(lane, at) {
  if (lane.kind !== 'weakest' && lane.parts.includes(server.view?.selected)) return server.view.selected;
  const value = (part) => server.lanes?.[part]?.[at] ?? Infinity;
  return lane.parts.reduce((best, part) => (value(part) < value(best) ? part : best), lane.parts[0]);
}
