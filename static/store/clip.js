// How long the film is, the frames that exist, and those that are damaged in the video's file.

import { server } from './state.js';

export function frameCount() {
  return server.file?.frames ?? 0;
}

export function lastFrame() {
  return Math.max(0, frameCount() - 1);
}

export function clampFrame(frame) {
  return Math.min(lastFrame(), Math.max(0, Math.round(frame)));
}

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
