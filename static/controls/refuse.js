// How a control says no: it shakes by two pixels and says why, in one sentence, below itself.

import { belowOrAbove, standAt } from './popup.js';

const STAY_MS = 4000;
let bubble = null;
let timer = 0;

/** Shake, unless the person asked for less motion. */
export function shake(element) {
  if (matchMedia('(prefers-reduced-motion: reduce)').matches) return;
  const moves = [0, -2, 2, -2, 2, 0].map((x) => ({ transform: `translateX(${x}px)` }));
  element.animate(moves, { duration: 240 });
}

/** Say one sentence below an element until the next input, or four seconds. */
export function say(element, words) {
  hush();
  bubble ??= createBubble();
  bubble.textContent = words;
  bubble.showPopover();
  place(element);
  timer = setTimeout(hush, STAY_MS);
}

export function hush() {
  clearTimeout(timer);
  if (bubble?.matches(':popover-open')) bubble.hidePopover();
}

function createBubble() {
  const element = document.createElement('div');
  element.className = 'refusal';
  element.popover = 'manual';
  element.setAttribute('role', 'alert');
  document.body.append(element);
  return element;
}

function place(element) {
  const at = element.getBoundingClientRect();
  const own = bubble.getBoundingClientRect();
  standAt(bubble, at.right - own.width, belowOrAbove(own.height, at.bottom + 4, at.top - 4));
}
