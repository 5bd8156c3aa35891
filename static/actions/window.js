// Which frames the timeline shows, all or a window of them, and which lanes.

import { clamp } from '../controls/arithmetic.js';
import { lastFrame } from '../store/clip.js';
import { setUi, ui } from '../store/state.js';
import { inBrowser } from '../store/storage.js';
import { around, frame, keyFrames } from './playhead.js';

const LANES = 'keypose.timeline.lanes';
const SMALL = '(max-width: 1359px), (max-height: 819px)';

/** Lanes are folded in small windows, unless all were asked for. */
export function mountFold() {
  matchMedia(SMALL).addEventListener('change', apply);
  apply();
}

export function areFolded() {
  return !ui.lanes;
}

/** Fold the lanes or open them; what was asked for is kept in this browser. */
export function foldLanes() {
  inBrowser.write(LANES, ui.lanes ? 'folded' : 'open');
  apply();
}

function apply() {
  const asked = inBrowser.read(LANES);
  const open = asked === null ? !matchMedia(SMALL).matches : asked === 'open';
  // The sheet gives opened lanes their height in windows that would not have it.
  document.documentElement.dataset.lanes = open ? 'open' : 'folded';
  setUi('lanes', open);
}

const AIR = 0.06;
/** No frame gets wider than this: beyond it nothing new is seen. */
const WIDEST_FRAME_PX = 48;

let room = 0; // pixels that the window is drawn on

/** The window is replaced as a whole whenever it changes, so that layers see it by identity. */
const ALL = { first: 0, last: Infinity };
ui.timeWindow = ALL;

/** How many pixels the window has. */
export function setRoom(px) {
  room = px;
}

/** The fewest frames that a window can show. */
export const leastSpan = () => Math.min(lastFrame(), room / WIDEST_FRAME_PX);

/** The shown frames, {first, last}: fractions of frames while zoomed. */
export function shown() {
  const last = Math.min(ui.timeWindow.last, lastFrame());
  return { first: Math.min(ui.timeWindow.first, last), last };
}

export function isZoomed() {
  return ui.timeWindow !== ALL;
}

export function showAll() {
  setUi('timeWindow', ALL);
}

/** Show these frames; a window as wide as the clip is no zoom at all. */
export function showFrames(first, last) {
  const end = lastFrame();
  const span = Math.max(last - first, leastSpan());
  if (span >= end * 0.999) return showAll();
  const middle = (first + last) / 2;
  const from = clamp(middle - span / 2, 0, end - span);
  setUi('timeWindow', { first: from, last: from + span });
}

/** Scroll by so many frames; stops at both ends. */
export function scrollBy(frames) {
  if (!isZoomed()) return;
  const { first, last } = shown();
  const by = clamp(frames, -first, lastFrame() - last);
  if (by !== 0) setUi('timeWindow', { first: first + by, last: last + by });
}

/** Scroll so far that this frame is seen, and by this share of the window further. */
export function reveal(at, further) {
  if (!isZoomed()) return;
  const { first, last } = shown();
  const more = further * (last - first);
  if (at > last) scrollBy(at - last + more);
  else if (at < first) scrollBy(at - first - more);
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
