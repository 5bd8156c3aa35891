// Where something stands that opens over the page: beside what it belongs to, and in the window.

import { clamp } from './arithmetic.js';

const MARGIN = 8;

/**
 * The top of something so high: below, or above where the window has no room below.
 * @param {number} height
 * @param {number} below
 * @param {number} above
 * @param {number} [margin]
 */
export function belowOrAbove(height, below, above, margin = MARGIN) {
  return below + height > innerHeight - margin ? above - height : below;
}

/**
 * Put an element of `position: fixed` at this place, as far as the window is wide enough for it.
 * @param {HTMLElement} element
 * @param {number} left
 * @param {number} top
 */
export function standAt(element, left, top) {
  const { width } = element.getBoundingClientRect();
  element.style.left = `${clamp(left, MARGIN, innerWidth - width - MARGIN)}px`;
  element.style.top = `${top}px`;
}
