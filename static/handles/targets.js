// Everything that can be grabbed in a view, and which of several at one place a pointer means.

import { server, ui } from '../store/state.js';
import { boxCornersIn, cornerBeside } from './boxcorners.js';
import { gripsIn } from './grips.js';
import { interaction } from './interaction.js';
import { keypointsIn, ringAt } from './keypoints.js';
import { trailKeysIn } from './marks.js';
import { masksIn } from './masks.js';
import { ringsIn } from './rings.js';
import { gripScale, isLarge } from './scale.js';
import { sizesIn } from './sizes.js';
import { isDrawingTool } from './sketch.js';
import { distance, nearestOnPath } from './space.js';

/** As shares of a handle's reach: nearer to each other than this the pointer cannot tell them apart. */
const AS_NEAR = 0.35;

// A target says itself what is done with it: `begin` a drag, `click`, `clickTwice`, `menu`, `cursor`. Without
// them a drag pulls its `handle` or ring, a click selects its part, and a second one the limb.

/** @typedef {{ target: any, miss: number }} Found */
/** @typedef {{ view: string, key: string, order: string[] }} Chosen */

/**
 * Those found, the likeliest first: the nearest, or as near as it the selected part's.
 * @param {Found[]} found  The nearest first.
 * @param {string | null} selected
 */
export function likeliestFirst(found, selected) {
  const targets = found.map(({ target }) => target);
  const own = found.find(({ target, miss }) => target.part === selected && miss - found[0].miss < AS_NEAR);
  return own ? [own.target, ...targets.filter((target) => target !== own.target)] : targets;
}

/**
 * In the order they had when one of them was chosen, as long as they are the same.
 * @param {any[]} stack
 * @param {Chosen | null} chosen
 */
export function asBefore(stack, chosen) {
  if (chosen?.order.length !== stack.length) return stack;
  const before = chosen.order.map((key) => stack.find((target) => target.key === key));
  return before.every(Boolean) ? before : stack;
}

/**
 * The chosen one, as long as it lies there, else the likeliest.
 * @param {any[]} stack
 * @param {Chosen | null} chosen
 */
export const meant = (stack, chosen) => stack.find(({ key }) => key === chosen?.key) ?? stack[0] ?? null;

/**
 * The one after this.
 * @param {any[]} stack
 * @param {any} target
 */
export const after = (stack, target) => stack[(stack.findIndex(({ key }) => key === target.key) + 1) % stack.length];

/** "2 of 3", or nothing where one lies alone. @param {any[]} stack */
export function whichOf(stack, target) {
  const at = stack.findIndex(({ key }) => key === target.key);
  return at < 0 || stack.length < 2 ? '' : `${at + 1} of ${stack.length}`;
}

const REACH = 12;
const RING_REACH = 7;
const LETTER_REACH = 10;
const BORDER_REACH = 6;
const FINGER = 1.7;
const SURE = 0.7;

/** Whether there is a body to take hold of, and an eye that sees it. */
export const isReady = (view) =>
  Boolean(
    server.file &&
    server.pose &&
    server.body &&
    server.view &&
    server.views &&
    view.eye &&
    view.isShown &&
    !view.isEmpty,
  );

/** All targets of a view by kind; empty before a file is open. */
export function targetsIn(view) {
  if (!isReady(view)) return { grips: [], corners: [], rings: [], sizes: [], masks: [], trail: [], keypoints: [] };
  const keypoints = keypointsIn(view);
  // Where a ring lies on a handle of the body the ring is meant, so that handle is not there.
  const grips = gripsIn(view).filter(({ kind, at }) => kind === 'root' || !ringAt(keypoints, ...at, 1));
  return {
    grips,
    corners: boxCornersIn(view),
    rings: ringsIn(view),
    sizes: sizesIn(view),
    masks: masksIn(view),
    trail: trailKeysIn(view),
    keypoints,
  };
}

/** The target a pointer at (x, y) means, or null. */
export function targetAt(view, x, y, touch = false) {
  return meant(stackAt(view, x, y, touch), chosenIn(view));
}

const chosenIn = ({ name }) => (interaction.chosen?.view === name ? interaction.chosen : null);

/** The targets that a pointer at (x, y) may mean, in the order in which further presses lead to them. */
export function stackAt(view, x, y, touch = false) {
  if (ui.tool === 'pan' || isDrawingTool(ui.tool)) return [];
  const { grips, corners, rings, sizes, masks, trail, keypoints } = targetsIn(view);
  const finger = touch ? FINGER : 1;
  const keypoint = ringAt(keypoints, x, y, finger);
  if (keypoint) return [keypoint];
  const found = [...grips, ...corners, ...sizes, ...masks, ...trail, ...rings]
    .map((target) => ({ target, miss: missOf(view, target, x, y) / finger }))
    .filter(({ miss }) => miss <= 1)
    .sort((a, b) => a.miss - b.miss);
  if (!found.length) return cornerBeside(corners, x, y);
  // A ring seen edge-on runs through the handle in its middle, which must stay within reach.
  const sure = found.filter(({ target, miss }) => target.kind !== 'ring' && miss <= SURE);
  const handles = sure.filter(({ target }) => target.handle);
  // A corner of a mask or a key of the trail does what it does at the first press.
  if (!sure[0]?.target.handle) return (sure.length ? sure : found).slice(0, 1).map(({ target }) => target);
  return asBefore(likeliestFirst(handles, server.view.selected), chosenIn(view));
}

/** How far the pointer is from a target, as a share of the target's reach. */
function missOf(view, target, x, y) {
  if (target.kind === 'ring') return ringMiss(view, target, x, y);
  if (target.path) return nearestOnPath(target.path, x, y).distance / BORDER_REACH;
  const reach = target.reach ?? REACH * (isLarge(view) ? 1 : gripScale(view));
  return distance(target.at, [x, y]) / reach;
}

function ringMiss(view, ring, x, y) {
  const reach = isLarge(view) ? RING_REACH : 5;
  const line = nearestOnPath(ring.front, x, y).distance / reach;
  const letter = ring.letter ? distance(ring.letter, [x, y]) / LETTER_REACH : Infinity;
  // On the letter there is no doubt which ring is meant, whatever runs through it.
  return letter < SURE ? letter - 1 : Math.min(line, letter);
}
