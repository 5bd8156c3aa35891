// Frames that are damaged in the video's file, or cannot be decoded at all.

import { server } from './state.js';

/** [first, last] of the run of damaged frames that a frame lies in, or null. */
export function damageAt(frame) {
  return (server.damage ?? []).find(([first, last]) => first <= frame && frame <= last) ?? null;
}

/** How many frames are damaged. */
export function damagedFrames() {
  return (server.damage ?? []).reduce((sum, [first, last]) => sum + last - first + 1, 0);
}

export function damageWords(first, last) {
  return first === last
    ? `Frame ${first} is damaged in the file and is not used for tracking.`
    : `Frames ${first}–${last} are damaged in the file and are not used for tracking.`;
}
