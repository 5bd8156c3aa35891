// The pose at a frame: fitted, copied, kept, mirrored, reset; and the parts of the body.

import { selectedPart } from '../../store/parts.js';
import { server } from '../../store/state.js';
import { words } from '../../store/clip.js';
import { count } from '../../controls/words.js';
import {
  copy,
  copyWords,
  insertTitle,
  keepMessage,
  nothingCopied,
  pasteWith,
  whyNotCopy,
  whyNotInsert,
  whyNotKeep,
} from '../copying.js';
import { copyKey, whyNotCopyHere } from '../keying.js';
import { fitsFocal } from '../lens.js';
import { frame, keyBeside } from '../playhead.js';
import { addPart, carrier, deleteTitle, whyNotDeletePart } from '../parts.js';
import { noKeyframe, whyNotFitPose, whyNotFitSizes, whyNotSwap, whyNotTracked } from '../tracking.js';
import { keysLimb } from '../review.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const POSE = {
  fitPose: {
    also: 'refine align snap auto optimise optimize solve improve match',
    label: 'Fit pose',
    icon: 'wand',
    keys: ['F'],
    off: whyNotFitPose,
    title: () => `Refine the pose to match the ${words().image}`,
    message: () => ({ do: 'fit_here' }),
  },
  fitSizes: {
    also: 'scale proportions calibrate body measurements bone lengths height',
    label: 'Fit sizes',
    icon: 'wand',
    off: whyNotFitSizes,
    title: () => `Estimate the body’s sizes from all ${count(server.keys?.frames.length ?? 0, 'keyframe')}`,
    message: () => ({ do: 'fit_sizes', focal: fitsFocal() }),
  },
  useTracked: {
    also: 'take apply accept solved motion',
    label: () => `Use ${words().done} pose`,
    icon: 'take',
    off: whyNotTracked,
    title: () => `Replace this frame’s pose with the ${words().done} one`,
    message: () => ({ do: 'take_tracked' }),
  },
  copyPose: {
    also: 'clipboard duplicate',
    label: copyWords,
    icon: 'copy',
    keys: ['Ctrl C'],
    row: 'Copy, paste',
    off: whyNotCopy,
    title: 'Copy the selected keyframes, else the pose at this frame',
    run: copy,
  },
  pastePose: {
    also: 'clipboard insert apply',
    label: 'Paste',
    icon: 'paste',
    keys: ['Ctrl V'],
    row: 'Copy, paste',
    handledBy: 'paste',
    off: nothingCopied,
    title: 'Paste the copied pose here, or the copied keyframes from this frame on',
    run: () => pasteWith({}),
  },
  pasteMirrored: {
    also: 'flip symmetric opposite mirror clipboard',
    label: 'Paste mirrored',
    icon: 'mirror',
    keys: ['Ctrl Shift V'],
    handledBy: 'paste',
    off: nothingCopied,
    title: 'Paste with left and right swapped',
    run: () => pasteWith({ mirrored: true }),
  },
  pasteOnto: {
    label: 'Paste onto the body here',
    icon: 'paste',
    keys: ['Shift V'],
    off: nothingCopied,
    title: 'Paste where the body stands at this frame, not where it was copied',
    run: () => pasteWith({ onto_body: true }),
  },
  keepPose: {
    label: 'Keep in the pose library',
    icon: 'plus',
    title: 'Keep the pose of this frame for every session',
    off: whyNotKeep,
    message: keepMessage,
  },
  insertPose: {
    label: (pose) => `Insert ${pose?.name ?? 'a kept pose'}`,
    title: insertTitle,
    off: whyNotInsert,
    message: ({ id }) => ({ do: 'insert_pose', id }),
  },
  insertMirrored: {
    label: (pose) => `Insert ${pose?.name ?? 'a kept pose'} mirrored`,
    icon: 'mirror',
    off: whyNotInsert,
    message: ({ id }) => ({ do: 'insert_pose', id, mirrored: true }),
  },
  copyPrevious: {
    also: 'hold repeat same last pose',
    label: () => copyLabel(-1),
    icon: 'prev',
    keys: ['P'],
    row: 'Copy from previous keyframe',
    title: 'Copy the previous keyframe’s pose to this frame',
    off: () => noKeyframe(-1),
    message: () => copyKey(-1),
  },
  copyNext: {
    also: 'same following pose',
    label: () => copyLabel(1),
    icon: 'prev',
    title: 'Copy the next keyframe’s pose to this frame',
    off: () => noKeyframe(1),
    message: () => copyKey(1),
  },
  copyKeyHere: {
    label: () => `Copy its pose to frame ${frame()}`,
    icon: 'take',
    off: whyNotCopyHere,
    message: (from = frame()) => ({ do: 'copy_key', from_frame: from }),
  },
  swapSides: {
    also: 'flip mirror exchange left right leg arm',
    label: 'Swap left and right',
    icon: 'loop',
    off: whyNotSwap,
    title: 'Move the left limbs to where the right ones are seen, and the other way round',
    message: () => ({ do: 'exchange' }),
  },
  turnInDepth: {
    also: 'flip depth ambiguity toward away behind front leg arm limb bend',
    label: 'Turn in depth',
    icon: 'depth',
    title: () =>
      `${selectedPart()?.label ?? 'The whole body'} points away from the camera instead of toward it, seen where it is`,
    message: (part) => turnInDepth(part ?? selectedPart()),
  },
  addPart: {
    also: 'bone limb prop racket tool new',
    label: 'Add part',
    icon: 'plus',
    run: addPart,
    title: (part) => `Add a part at the far end of ${(part ?? carrier())?.label.toLowerCase() ?? 'the body'}`,
  },
  deletePart: {
    also: 'remove bone limb',
    label: 'Delete part',
    icon: 'trash',
    off: whyNotDeletePart,
    title: deleteTitle,
    message: (part) => ({ do: 'delete_part', part: part?.name ?? server.view.selected }),
  },
  resetPart: {
    also: 'rest default clear rotation zero',
    label: 'Reset part',
    icon: 'reset',
    keys: ['Backspace'],
    row: 'Reset part, pose',
    off: (part) => ((part ?? server.view?.selected) ? '' : 'Select a part first'),
    message: (part) => ({ do: 'reset_part', part: part?.name ?? server.view.selected }),
  },
  resetPose: {
    also: 'rest default t-pose tpose clear zero',
    label: 'Reset pose',
    icon: 'reset',
    keys: ['Shift Backspace'],
    row: 'Reset part, pose',
    message: () => ({ do: 'reset_pose' }),
  },
};

/** In a review the limb alone is keyed, as by a drag. */
function turnInDepth(part) {
  const alone = keysLimb() && part?.parent != null;
  return { do: 'turn_in_depth', part: part?.name ?? null, ...(alone ? { partial: true } : {}) };
}

function copyLabel(way) {
  const key = keyBeside(way);
  if (key === undefined) return `Copy from ${way < 0 ? 'previous' : 'next'}`;
  return `Copy from key ${key}`;
}
