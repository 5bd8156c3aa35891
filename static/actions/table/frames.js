// Going to frames, and playing.

import { ui } from '../../store/state.js';
import { goTo, middle, next, step, suggestedFrame, toFirst, toKey, toLast } from '../playhead.js';
import {
  clearSpan, playBack, playFaster, playSlower, setIn, setOut, stop, toggleLoop, togglePlaying, whyNotClear, whyNotPlay,
} from '../playing.js';
import { atFirst, atLast, noKeyframe } from '../tracking.js';
import { isZoomed, zoomTo, zoomToInterval } from '../window.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const FRAMES = {
  previousFrame: {
    also: 'step back rewind',
    label: 'Back one frame', icon: 'sb', keys: ['ArrowLeft'], row: 'One frame', repeats: true,
    off: atFirst, run: () => step(-1),
  },
  nextFrame: {
    also: 'step forward advance',
    label: 'Forward one frame', icon: 'sf', keys: ['ArrowRight'], row: 'One frame', repeats: true,
    off: atLast, run: () => step(1),
  },
  tenBack: {
    also: 'jump rewind skip',
    label: 'Back ten frames', keys: ['Shift ArrowLeft'], row: 'Ten frames', repeats: true,
    off: atFirst, run: () => step(-10),
  },
  tenForward: {
    also: 'jump skip advance',
    label: 'Forward ten frames', keys: ['Shift ArrowRight'], row: 'Ten frames', repeats: true,
    off: atLast, run: () => step(10),
  },
  firstFrame: {
    also: 'start beginning rewind home',
    label: 'First frame', icon: 'first', keys: ['Home'], row: 'First, last frame', repeats: true,
    off: atFirst, run: toFirst,
  },
  lastFrame: {
    also: 'end finish',
    label: 'Last frame', icon: 'last', keys: ['End'], row: 'First, last frame', repeats: true,
    off: atLast, run: toLast,
  },
  play: {
    also: 'playback pause stop run preview animate speed slow motion',
    label: () => (ui.playing ? 'Stop' : 'Play'), icon: () => (ui.playing ? 'pause' : 'play'),
    keys: ['Space'], row: 'Play, stop', handledBy: 'release',
    off: whyNotPlay, run: togglePlaying,
  },
  playBack: { label: 'Play backward', keys: ['Shift Space'], off: whyNotPlay, run: playBack },
  playSlower: {
    label: 'Slower, then backward', keys: ['J'], row: 'Shuttle while playing', handledBy: 'playing', run: playSlower,
    also: 'speed rate slow motion reverse shuttle jkl',
  },
  stopPlaying: { label: 'Stop', keys: ['K'], row: 'Shuttle while playing', handledBy: 'playing', run: stop },
  playFaster: {
    label: 'Faster', keys: ['L'], row: 'Shuttle while playing', handledBy: 'playing', run: playFaster,
    also: 'speed rate fast shuttle jkl',
  },
  loop: {
    also: 'repeat cycle again',
    label: 'Loop', icon: 'repeat', title: 'Play again and again', keys: ['Shift L'], on: () => Boolean(ui.loop), run: toggleLoop,
  },
  setIn: {
    label: 'In point here', icon: 'in', keys: ['Shift I'], row: 'In, out point here', title: 'Playing begins at this frame', run: () => setIn(),
    also: 'range trim start mark',
  },
  setOut: {
    label: 'Out point here', icon: 'out', keys: ['Shift O'], row: 'In, out point here', title: 'Playing ends at this frame', run: () => setOut(),
    also: 'range trim end mark',
  },
  clearSpan: { label: 'Clear in and out point', icon: 'x', keys: ['Shift X'], off: whyNotClear, run: clearSpan },
  previousKeyframe: {
    also: 'jump back keyed',
    label: 'Previous keyframe', icon: 'pk', keys: [','], row: 'Previous, next keyframe', repeats: true,
    off: () => noKeyframe(-1), run: () => toKey(-1),
  },
  nextKeyframe: {
    also: 'jump forward keyed',
    label: 'Next keyframe', icon: 'nk', keys: ['.'], row: 'Previous, next keyframe', repeats: true,
    off: () => noKeyframe(1), run: () => toKey(1),
  },
  middle: { also: 'centre center halfway breakdown between', label: 'Middle of this interval', icon: 'mid', keys: ['/'], run: middle },
  suggestedFrame: {
    also: 'recommend next best keyframe where',
    label: 'Go to the suggested frame', keys: ['N'],
    off: () => (suggestedFrame() === null ? 'No frame is suggested' : ''), run: next,
  },
  zoomToInterval: {
    label: 'Zoom to this interval', icon: 'grow', keys: ['Z'], on: isZoomed, run: zoomToInterval,
    also: 'timeline fit range frame',
  },
  zoomToSegment: { also: 'timeline fit range', label: 'Zoom to segment', icon: 'grow', run: ({ first, last }) => zoomTo(first, last) },
  goTo: { label: (to) => `Go to frame ${to}`, icon: 'flag', run: goTo },
};
