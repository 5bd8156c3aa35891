// Which handles were pulled in this step of the guide: their marks go.

import { U, put, watch } from '../store/state.js';
import { hold } from '../handles/hold.js';

let drag = null; // the drag under way, or the last one
U.pulled = new Set();

/** Whether this handle was pulled already. */
export const isPulled = ({ name }) => U.pulled.has(name);

/** All marks come back. */
export const forgetPulled = () => put('pulled', new Set());

export function mountPulled() {
  watch(['u:dragging', 'pose'], () => {
    if (hold.drag) drag = hold.drag;
    else if (drag) notice();
  });
}

/** What was taken back, or told nothing, pulled nothing. */
function notice() {
  const { target, told, kept } = drag;
  drag = null;
  if (told && kept && target?.handle?.name) put('pulled', new Set(U.pulled).add(target.handle.name));
}
