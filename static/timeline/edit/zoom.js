// Zooming to intervals: once to see it, once more to see everything again.

import { isZoomed, lastFrame, showAll, showFrames, shown } from '../draw/scale.js';
import { frame } from './head.js';
import { around, keyFrames } from './moves.js';

const AIR = 0.06;
const AIR_OPENED = 0.1;
const LITTLE = 0.25; // of the film: the keyframes stand too close together to be worked with

/** Whether the keyframes take up little of a long film. */
export function isKeyedLittle() {
  const keys = keyFrames();
  return keys.length > 1 && keys.at(-1) - keys[0] < LITTLE * lastFrame();
}

/** A film just opened is shown whole, or where its keyframes are. */
export function showOpened() {
  if (!isKeyedLittle()) return showAll();
  const [first, last] = [keyFrames()[0], keyFrames().at(-1)];
  const air = (last - first) * AIR_OPENED;
  return showFrames(first - air, last + air);
}

/** Show these frames with a little air on both sides. */
export function zoomTo(first, last) {
  const air = (last - first) * AIR;
  showFrames(first - air, last + air);
}

/** Fit the interval of the playhead; when it is fitted already, show the whole clip. */
export function zoomToInterval() {
  const keys = keyFrames();
  const [first, last] = around(frame()) ?? [
    keys.findLast((key) => key <= frame()) ?? 0,
    keys.find((key) => key > frame()) ?? lastFrame(),
  ];
  if (last <= first) return showAll();
  const before = shown();
  const was = isZoomed();
  zoomTo(first, last);
  const now = shown();
  if (was && Math.abs(now.first - before.first) + Math.abs(now.last - before.last) < 0.01) showAll();
}
