// The playhead reached with Tab: arrows, Page keys, Home and End move it, Enter opens its menu.

import { frame, goTo, hold } from './head.js';
import { lastFrame } from '../draw/scale.js';
import { openMenuAtHead } from './gestures.js';

const STEPS = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 };

export function headKeys(drawing) {
  drawing.addEventListener('keydown', (event) => {
    if (!event.target.closest?.('.playhead') || event.ctrlKey || event.altKey) return;
    if (!pressed(event)) return;
    event.preventDefault();
    event.stopPropagation();
  });
}

function pressed(event) {
  const by = STEPS[event.key];
  hold();
  if (by !== undefined) goTo(frame() + (event.shiftKey ? 10 * by : by));
  else if (event.key === 'Home') goTo(0);
  else if (event.key === 'End') goTo(lastFrame());
  else if (event.key === 'Enter') openMenu(event.target);
  else return false;
  return true;
}

function openMenu(head) {
  const box = head.querySelector('.flag').getBoundingClientRect();
  openMenuAtHead([box.left, box.bottom]);
}
