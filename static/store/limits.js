// Which joint limits hold: all, none, or all but those lifted in this tab with their locks.

import { S, U } from './state.js';

/** Whether the limits of a part's axis do not count; `part` is its name. */
export function isFree(part, axis) {
  return !S.view.limits || (U.freeAxes?.has(`${part}.${axis}`) ?? false);
}
