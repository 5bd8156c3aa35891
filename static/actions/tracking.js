// Which segments tracking would do, and why something cannot be done now.

import { count, range } from '../controls/words.js';
import { chosenFrames, fewestKeys, isSurface, lastFrame, tooFewWords, words } from '../store/clip.js';
import { bodies } from '../store/bodies.js';
import { send } from '../store/link.js';
import { partNamed, selectedPart } from '../store/parts.js';
import { server } from '../store/state.js';
import { outward } from './parts.js';
import { frame, goTo, keyBeside, segmentAt } from './playhead.js';

/** Whether there is a result that still fits the keyframes. */
export const isTracked = ({ state }) => ['good', 'check', 'lost'].includes(state);

const isChanged = ({ state, unfinished }) => state === 'outdated' || state === 'none' || unfinished;

/** The segments that tracking is for: those that reach between the in and the out point, else all. */
export function chosenSegments() {
  const chosen = chosenFrames();
  const all = server.segments ?? [];
  if (!chosen) return all;
  const [from, to] = chosen;
  return all.filter(({ first, last }) => (from === to ? first <= from && to <= last : first < to && last > from));
}

/** Those of them whose result is missing or does not fit any more. */
export const changedSegments = () => chosenSegments().filter(isChanged);

/** ", 40–159" where there is an in or an out point, else ''. */
export function chosenTail() {
  const chosen = chosenFrames();
  return chosen ? `, ${range(...chosen)}` : '';
}

/** What is sent to track. @param {'changed' | 'all'} what */
export function trackMessage(what) {
  const [first, last] = chosenFrames() ?? [];
  return { do: 'track', what, ...(first === undefined ? {} : { first, last }) };
}

/** Whether nothing was tracked yet. */
export const isFirstTrack = () =>
  !(server.segments ?? []).some((s) => isTracked(s) || s.state === 'outdated' || s.percent);

/** The segment that the server's frame lies in; at a keyframe those on both sides. */
export function segmentsHere() {
  const { frame: here } = server.view;
  return (server.segments ?? []).filter(({ first, last }) => first <= here && here <= last);
}

/** "39–50, 50–61", or how many there are when that would be long. */
export function namesOf(segments) {
  if (segments.length > 3) return count(segments.length, 'segment');
  return segments.map((s) => range(s.first, s.last)).join(', ');
}

const whyNotThisBody = () => ((server.keys?.frames.length ?? 0) < fewestKeys() ? tooFewWords() : '');

/** Whether a body that is not posed has segments to track. */
const hasOthers = () => bodies().some(({ posed, open }) => !posed && open > 0);

export const whyNotTrack = () => (hasOthers() ? '' : whyNotThisBody());

/** The same of the segments between the in and the out point. */
export const whyNotTrackChosen = () =>
  hasOthers()
    ? ''
    : whyNotThisBody() ||
      (chosenSegments().length ? '' : `No segment reaches between the in and the out point${chosenTail()}`);

export function whyNotTrackChanged() {
  const why = whyNotTrackChosen();
  if (why || changedSegments().length || hasOthers()) return why;
  return server.job?.state === 'running'
    ? `${words().doing} already`
    : `All segments${chosenTail().replace(',', ' within')} are up to date`;
}

/**
 * Why the body cannot be followed from the last keyframe on, or back from the first, or ''.
 * @param {'forward' | 'backward'} direction
 */
export function whyNotAhead(direction) {
  if (isSurface()) return 'Surfaces are fitted from one keyframe on';
  const { state, kind } = server.job ?? {};
  if (state === 'running' && kind === 'ahead') return 'Tracking ahead already';
  const keys = server.keys?.frames ?? [];
  if (keys.length === 0) return 'Add a keyframe first';
  const [key, end] = direction === 'forward' ? [keys.at(-1), lastFrame()] : [keys[0], 0];
  return key === end ? `The keyframe at ${key} is the ${end === 0 ? 'first' : 'last'} frame` : '';
}

/**
 * Which way the server's frame lies beyond all keyframes, if it has no motion of its own there.
 * @returns {'forward' | 'backward' | null}
 */
export function beyondKeys() {
  const keys = server.keys?.frames ?? [];
  if (server.pose?.source !== 'held' || keys.length === 0 || isSurface()) return null;
  const { frame: here } = server.view;
  if (here > keys.at(-1)) return 'forward';
  return here < keys[0] ? 'backward' : null;
}

/**
 * "Frames 61–150 have no motion yet": those beyond the keyframes that way.
 * @param {'forward' | 'backward'} direction
 */
export function noMotionYet(direction) {
  const keys = server.keys?.frames ?? [];
  const frames = direction === 'forward' ? range(keys.at(-1) + 1, lastFrame()) : range(0, keys[0] - 1);
  return `Frames ${frames} have no motion yet`;
}

/**
 * Whether what is suggested is being done: its progress is shown instead.
 * @param {{ kind: string }} suggestion
 */
export function isUnderWay({ kind }) {
  const { state, kind: job } = server.job ?? {};
  const answers = kind === 'track' || job === 'ahead' || (kind === 'pose' && job === 'draft');
  return state === 'running' && answers;
}

/** Of a segment, by default the one of the playhead. */
export const whyNotTrackThis = (segment = segmentAt(frame())) =>
  whyNotThisBody() || (segment ? '' : 'This frame lies outside the keyframes');

/** A segment is tracked from within: the playhead goes there first. By default that of the playhead. */
export function trackSegment(segment = null) {
  if (segment && segmentAt(frame())?.first !== segment.first) goTo(segment.first);
  send({ do: 'track', what: 'this' });
}

/** Why there is no tracked pose at the playhead, or ''. */
export function whyNotTracked() {
  const here = frame();
  const hasPose = (s) => s.first <= here && here <= s.last && (isTracked(s) || s.scores?.length);
  if ((server.segments ?? []).some(hasPose)) return '';
  return `Frame ${here} is not ${words().done} yet`;
}

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
