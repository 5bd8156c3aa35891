// All frames: where nothing else is, the playhead goes where one presses, and follows the pointer.

import { contextEntries } from '../../actions/context_menus.js';
import { partKeys } from '../../actions/parts.js';
import { draftFrames, glideTo, keyFrames, settle, stopPlaying, suggestedFrame } from '../../actions/playhead.js';
import { heading, openMenuAt } from '../../controls/menu.js';
import { clampFrame } from '../../store/clip.js';
import { frameAt, snapped } from '../draw/scale.js';
import { setGrabbed } from '../pointer.js';

/** The frames that the playhead snaps to, unless Ctrl is held. */
function marked() {
  const suggested = suggestedFrame();
  return [
    ...keyFrames(),
    ...partKeys().map((key) => key.frame),
    ...draftFrames(),
    ...(suggested === null ? [] : [suggested]),
  ];
}

/** Grab the playhead; what then is clicked settles it. @returns {import('../mark.js').Gesture} */
export function scrub(start) {
  const follow = (place) => glideTo(snapped(place.x, place.ctrl ? [] : marked()));
  stopPlaying();
  setGrabbed({ kind: 'frames' });
  follow(start);
  return { move: follow, end: settle, cancel: settle };
}

/** Of an empty place: what can be done at its frame. */
export function openFramesMenu(at, page) {
  openMenuAt(`Frame ${at}`, [heading(`Frame ${at}`), ...contextEntries('frames', { goTo: at, note: at })], page);
}

/** @type {import('../mark.js').Mark} */
export const frames = {
  kind: 'frames',
  hit: () => ({}),
  grab: (_, place) => scrub(place),
  click: settle,
  menu: (_, place) => openFramesMenu(clampFrame(frameAt(place.x)), place.page),
};
