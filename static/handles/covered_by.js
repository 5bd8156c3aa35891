// What lies over a picture gives way to what is under it: a drag that passes there, and a handle
// that the pointer comes near.

import { view as viewNamed } from '../views/views.js';
import { boxCornersIn } from './boxcorners.js';
import { gripsIn } from './grips.js';
import { interaction } from './interaction.js';
import { distance } from './space.js';
import { isReady } from './targets.js';

const MARGIN = 24;
const NEAR = 90;

/** Whether the drag under way, the pointer or the handle it pulls, is at this element. */
export function isDragCoveredBy(element) {
  const { drag } = interaction;
  if (!drag) return false;
  const view = viewNamed(drag.view);
  const grip = [...gripsIn(view), ...boxCornersIn(view)].find(({ key }) => key === drag.target?.key);
  const box = boxIn(view, element);
  return [drag.seen, ...(grip ? [grip.at] : [])].some((at) => holds(box, at, MARGIN));
}

/** Whether the resting pointer is near a handle that lies under this element. */
export function isHandleCoveredBy(element) {
  const { pointer } = interaction;
  if (!pointer || !isReady(pointer.view)) return false;
  const box = boxIn(pointer.view, element);
  const near = [pointer.x, pointer.y];
  return [...gripsIn(pointer.view), ...boxCornersIn(pointer.view)].some(({ at, radius }) => holds(box, at, radius) && distance(at, near) < NEAR);
}

/** An element's box in pixels of a view. */
function boxIn(view, element) {
  const own = view.over.getBoundingClientRect();
  const { left, top, width, height } = element.getBoundingClientRect();
  return { left: left - own.left, top: top - own.top, width, height };
}

/**
 * @param {{ left: number, top: number, width: number, height: number }} box
 * @param {number[]} at
 * @param {number} margin
 */
function holds({ left, top, width, height }, [x, y], margin) {
  return (
    x > left - margin && x < left + width + margin && y > top - margin && y < top + height + margin
  );
}
