// Why something cannot be done now, in words without a full stop; '' where it can.

import { lastFrame } from '../store/clip.js';
import { partNamed, selectedPart } from '../store/parts.js';
import { server } from '../store/state.js';
import { isSurface } from '../store/subject.js';
import { outward } from './chain.js';
import { frame, keyBeside } from './playhead.js';

export function atFirst() {
  return frame() === 0 ? 'This is the first frame' : '';
}

export function atLast() {
  return frame() === lastFrame() ? 'This is the last frame' : '';
}

export function noKeyframe(way) {
  if (keyBeside(way) !== undefined) return '';
  return `There is no keyframe ${way < 0 ? 'before' : 'after'} frame ${frame()}`;
}

/** A surface is fitted to from any pose, also from the one the body first has. */
export function whyNotFitPose() {
  if (isSurface()) return '';
  const { frames = [], drafts = [] } = server.keys ?? {};
  return frames.length + drafts.length ? '' : 'Pose the body roughly first';
}

export function whyNotFitSizes() {
  return (server.keys?.frames.length ?? 0) < 2 ? 'Needs 2 keyframes that show the body from different sides' : '';
}

export function whyNotSwap() {
  return server.body?.parts.some((part) => part.mirror) ? '' : 'This body has no left and right';
}

export function noOtherSide(part = selectedPart()) {
  if (!part) return 'Select a part first';
  return part.mirror ? '' : `${part.label} has no other side`;
}

export function isRoot() {
  const part = selectedPart();
  return part && !partNamed(part.parent) ? `${part.label} is the root part` : '';
}

export function hasNoChild() {
  const part = selectedPart();
  return part && !outward(part) ? `${part.label} has no child part` : '';
}
