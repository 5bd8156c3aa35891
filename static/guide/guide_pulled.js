// Which handles were pulled in this step of the guide: their marks go.

import { ui, setUi, watch } from '../store/state.js';
import { hold } from '../handles/hold.js';

let drag = null; // the drag under way, or the last one
ui.pulled = new Set();

/** Whether this handle was pulled already. */
export const isPulled = ({ name }) => ui.pulled.has(name);

/** All marks come back. */
export const forgetPulled = () => setUi('pulled', new Set());

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
  if (told && kept && target?.handle?.name) setUi('pulled', new Set(ui.pulled).add(target.handle.name));
}
