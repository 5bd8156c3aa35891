// The playhead reached with Tab: its keys.

import { lastFrame } from '../../store/clip.js';
import { frame, goTo, stopPlaying } from '../../actions/playhead.js';
import { openMenuAtHead } from './gestures.js';

const STEPS = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 };

/** The playhead reached with Tab: arrows, Page keys, Home and End move it, Enter opens its menu. */
export function headKeys(drawing) {
  drawing.addEventListener('keydown', (event) => {
    if (!event.target.closest?.('.playhead') || event.ctrlKey || event.altKey) return;
    if (!moveByKey(event)) return;
    event.preventDefault();
    event.stopPropagation();
  });
}

function moveByKey(event) {
  const by = STEPS[event.key];
  stopPlaying();
  if (by !== undefined) goTo(frame() + (event.shiftKey ? 10 * by : by));
  else if (event.key === 'Home') goTo(0);
  else if (event.key === 'End') goTo(lastFrame());
  else if (event.key === 'Enter') openMenuAtHead();
  else return false;
  return true;
}
