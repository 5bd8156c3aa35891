// What floats over the pictures gives way to what is under it. Where a handle lies under a bar or a
// message there is a hole, in which it is seen and can be grabbed; messages first look for a place
// without one. Cards that ask for something else than a drag stay whole, and so do all while
// something is drawn: no handle can be grabbed then.

import { peopleHere } from '../actions/people.js';
import { onRedraw, server, ui } from '../store/state.js';
import { ALL_VIEWS, onViews, view as viewNamed } from '../views/views.js';
import { boxCornersIn } from './boxcorners.js';
import { gripsIn } from './grips.js';
import { interaction, onInteraction } from './interaction.js';
import { keypointsIn } from './keypoints.js';
import { largeView } from './scale.js';
import { sizesIn } from './sizes.js';
import { isDrawingTool } from './sketch.js';
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
  return [...gripsIn(pointer.view), ...boxCornersIn(pointer.view)].some(
    ({ at, radius }) => holds(box, at, radius) && distance(at, near) < NEAR,
  );
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
const FLOATING = '.bars > .glass, .films > .glass, .toast, .banner, .coach';
const WHOLE = '.coach.film, .coach.large';
const HOLE = 13; // px about a handle
const ROUND = 12; // px, the radius of its corners
const CLEAR = 20; // px that a message keeps from handles where it can
const EDGE = 16;
const BARS = 60; // px at the top and the bottom of a view, where its bars are
const SHADOW = 40;

/** @typedef {{ left: number, top: number, width: number, height: number }} Box */

export function mountFloating() {
  onRedraw(giveWay);
  onViews(giveWay);
  onInteraction(giveWay);
  // Words that change alone change the size of a message, too.
  new MutationObserver(giveWay).observe(document.getElementById('screens'), {
    childList: true,
    subtree: true,
    characterData: true,
  });
}

function giveWay() {
  const spots = ui.playing || isDrawingTool(ui.tool) ? [] : handlesInWindow();
  placeMessages(spots);
  for (const element of document.querySelectorAll(FLOATING)) {
    cutHoles(/** @type {HTMLElement} */ (element), element.matches(WHOLE) ? [] : spots);
  }
}

/** Where the body is, its feet and its head, or those who may be drafted and the box around one. */
function peopleInWindow() {
  const main = viewNamed('main');
  if (!isReady(main)) return [];
  const boxes = ui.tool === 'box' ? [...peopleHere(), ...(ui.box ? [ui.box] : [])] : [];
  const joints =
    ui.tool === 'box' || !server.pose ? [] : Object.values(server.pose.points).map((point) => main.project(point));
  const { left, top, right, bottom } = main.over.getBoundingClientRect();
  const spots = [...joints, ...boxes.flatMap(gridOf).map((spot) => main.fromView(spot))].map(([x, y]) => [
    left + x,
    top + y,
  ]);
  return spots.filter(([x, y]) => x > left && x < right && y > top && y < bottom);
}

/** Places in a box of the picture, so near each other that no message stands between them. */
function gridOf([left, top, right, bottom]) {
  const at = [0, 1, 2, 3, 4].map((i) => i / 4);
  return at.flatMap((u) => at.map((v) => [left + u * (right - left), top + v * (bottom - top)]));
}

/** Places on the cards of other films. */
function filmsInWindow() {
  return [...document.querySelectorAll('.films > .filmcard')].flatMap((element) => {
    const { left, top, right, bottom } = element.getBoundingClientRect();
    return gridOf([left, top, right, bottom]);
  });
}

/** Every handle that can be grabbed now, in pixels of the window. */
function handlesInWindow() {
  return ALL_VIEWS.map(viewNamed)
    .filter(isReady)
    .flatMap((view) => {
      const { left, top, right, bottom } = view.over.getBoundingClientRect();
      const spots = [...gripsIn(view), ...boxCornersIn(view), ...sizesIn(view), ...keypointsIn(view)].map(
        ({ at: [x, y] }) => [left + x, top + y],
      );
      return spots.filter(([x, y]) => x > left && x < right && y > top && y < bottom);
    });
}

/**
 * @param {HTMLElement} element
 * @param {number[][]} spots
 */
function cutHoles(element, spots) {
  if (!spots.length) return void (element.style.clipPath = '');
  const box = element.getBoundingClientRect();
  const inside = spots.filter((spot) => holds(box, spot, HOLE)).map(([x, y]) => [x - box.left, y - box.top]);
  const holes = apart(inside.map(([x, y]) => [x - HOLE, y - HOLE, x + HOLE, y + HOLE])).map(pathOfHole);
  const [right, bottom] = [box.width + SHADOW, box.height + SHADOW];
  const whole = `M${-SHADOW} ${-SHADOW}H${right}V${bottom}H${-SHADOW}Z`;
  element.style.clipPath = holes.length ? `path(evenodd, "${whole}${holes.join('')}")` : '';
}

/**
 * Holes that touch become one, or their common part would be none.
 * @param {number[][]} holes  Left, top, right, bottom.
 * @returns {number[][]}
 */
function apart(holes) {
  for (const [i, one] of holes.entries()) {
    const at = holes.findIndex((other, j) => j > i && touch(one, other));
    if (at < 0) continue;
    const [left, top, right, bottom] = holes[at];
    const both = [Math.min(one[0], left), Math.min(one[1], top), Math.max(one[2], right), Math.max(one[3], bottom)];
    return apart([both, ...holes.filter((_, j) => j !== i && j !== at)]);
  }
  return holes;
}

const touch = (one, other) => one[0] <= other[2] && other[0] <= one[2] && one[1] <= other[3] && other[1] <= one[3];

/**
 * Round at its corners, but not about the handle itself: at the height of a point of the path the
 * browser may take a press of what is in the hole for one of what is around it.
 * @param {number[]} hole
 */
function pathOfHole([left, top, right, bottom]) {
  const arc = (x, y) => `a${ROUND} ${ROUND} 0 0 1 ${x * ROUND} ${y * ROUND}`;
  return `M${left + ROUND} ${top}H${right - ROUND}${arc(1, 1)}V${bottom - ROUND}${arc(-1, 1)}H${left + ROUND}${arc(-1, -1)}V${top + ROUND}${arc(1, -1)}Z`;
}

/**
 * @param {Box} box
 * @param {number[]} spot
 * @param {number} margin
 */
function holds({ left, top, width, height }, [x, y], margin) {
  return x > left - margin && x < left + width + margin && y > top - margin && y < top + height + margin;
}

// --- messages

/**
 * Where messages may stand in the large view, the usual place first: across and down, 0 to 1.
 * @type {[number, number][]}
 */
const PLACES = [
  [0.5, 1],
  [0, 1],
  [1, 1],
  [0.5, 0],
  [0, 0],
  [1, 0],
];

/** Messages stand where no handle and nobody is, and stay there until one comes to lie under them. */
function placeMessages(handles) {
  const stack = document.getElementById('toasts');
  if (!stack) return;
  if (stack.childElementCount === 0 || !server.file) return leavePlace(stack);
  if (stack.matches(':hover, :focus-within') || document.documentElement.dataset.pressed) return;
  const spots = [...handles, ...peopleInWindow(), ...filmsInWindow()];
  const frame = viewNamed(largeView()).el.getBoundingClientRect();
  stack.style.maxWidth = `${frame.width - 2 * EDGE}px`;
  const now = stack.dataset.place;
  if (now === undefined || covered(stack.getBoundingClientRect(), spots)) {
    const best = bestPlace(frame, stack, spots);
    stack.dataset.place = String(PLACES.indexOf(best));
  }
  stand(stack, boxAt(frame, stack, PLACES[Number(stack.dataset.place)]), PLACES[Number(stack.dataset.place)][1]);
}

function leavePlace(stack) {
  delete stack.dataset.place;
  stack.removeAttribute('style');
  stack.classList.remove('from-top');
}

const covered = (box, spots) => spots.filter((spot) => holds(box, spot, CLEAR)).length;

function bestPlace(frame, stack, spots) {
  const counts = PLACES.map((place) => covered(boxAt(frame, stack, place), spots));
  return PLACES[counts.indexOf(Math.min(...counts))];
}

/** @returns {Box} */
function boxAt(frame, { offsetWidth: width, offsetHeight: height }, [across, down]) {
  const bars = across === 0.5 && down === 1 ? EDGE : BARS;
  const left = frame.left + EDGE + Math.max(0, frame.width - 2 * EDGE - width) * across;
  const top = frame.top + bars + Math.max(0, frame.height - 2 * bars - height) * down;
  return { left, top, width, height };
}

/** From its edge of the view on, so that a message more moves none that is there. */
function stand(stack, { left, top, height, width }, down) {
  stack.classList.toggle('from-top', down === 0);
  stack.style.left = `${left + width / 2}px`;
  stack.style.top = down === 0 ? `${top}px` : 'auto';
  stack.style.bottom = down === 0 ? 'auto' : `${innerHeight - top - height}px`;
}
