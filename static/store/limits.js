// Which joint limits hold: all, none, or all but those lifted in this tab with their locks.

import { server, ui } from './state.js';

/** Whether the limits of a part's axis do not count; `part` is its name. */
export function isFree(part, axis) {
  return !server.view.limits || (ui.freeAxes?.has(`${part}.${axis}`) ?? false);
}
