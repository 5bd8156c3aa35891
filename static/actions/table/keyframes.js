// Keyframes added, deleted, selected and moved.

import { addKey, duplicateKey } from '../keying.js';
import { keyLimb, unkeyMessage, whyNotKeyLimb } from '../limbs.js';
import { frame } from '../playhead.js';
import {
  deleteAny, deleteLabel, nudge, selectAll, selectHere, whyNotDeleteAny, whyNotNudge, whyNotSelect, whyNotSelectAll,
} from '../selection.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const KEYFRAMES = {
  addKeyframe: { also: 'key set insert record pose i', label: 'Add keyframe', icon: 'key', keys: ['K'], run: addKey },
  keyLimb: {
    also: 'partial keyframe part only correct arm leg',
    label: 'Key this limb only', icon: 'part', keys: ['Shift K'], off: whyNotKeyLimb,
    title: 'The limb is exact at this frame, the rest of the body stays with the tracker', run: keyLimb,
  },
  keyWhole: {
    label: 'Key the whole pose', icon: 'key', message: (at = frame()) => ({ do: 'add_key', frame: at }),
    also: 'full keyframe all parts',
  },
  unkeyLimb: {
    label: (about) => `Leave the ${about?.label?.toLowerCase() ?? 'limb'} to the tracker`, icon: 'x', message: unkeyMessage,
    also: 'remove partial keyframe release limb',
  },
  deleteKeyframe: {
    label: deleteLabel, icon: 'key', keys: ['Delete'], row: 'Delete keyframes', off: whyNotDeleteAny, run: deleteAny,
    also: 'remove key clear unkey discard draft',
  },
  duplicateKeyframe: { label: 'Duplicate to frame', icon: 'copy', run: duplicateKey },
  selectAllKeyframes: { label: 'Select all keyframes', keys: ['Ctrl A'], off: whyNotSelectAll, run: selectAll },
  selectKeyframe: {
    label: 'Select this keyframe', title: 'One more or one less', keys: ['Shift S'], off: whyNotSelect, run: selectHere,
  },
  selectRange: { label: 'Range, one more', keys: ['Shift Click', 'Ctrl Click'], handledBy: 'pointer' },
  earlier: nudging(-1, 'ArrowLeft'),
  later: nudging(1, 'ArrowRight'),
  tenEarlier: nudging(-10, 'Shift ArrowLeft'),
  tenLater: nudging(10, 'Shift ArrowRight'),
};

function nudging(by, chord) {
  const label = `Move selected keyframes ${Math.abs(by) === 1 ? 'one frame' : 'ten frames'} ${by < 0 ? 'earlier' : 'later'}`;
  return {
    label, keys: [`Ctrl ${chord}`], row: Math.abs(by) === 1 ? 'Move selected ones' : 'By ten frames', repeats: true,
    off: () => whyNotNudge(by), run: () => nudge(by),
  };
}
