// Zooming to intervals: once to see it, once more to see everything again.

import { isZoomed, lastFrame, showAll, showFrames, shown } from './scale.js';
import { frame } from './head.js';
import { around, keyFrames } from './moves.js';

const AIR = 0.06;

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
