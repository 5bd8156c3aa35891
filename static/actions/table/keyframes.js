// Keyframes, notes, flags and pins: added, deleted, selected and moved.

import { toggleSearch } from '../../controls/dialogs.js';
import { server } from '../../store/state.js';
import { addKey, duplicateKey, noNote, noteAt, toNote, whyNoNote, writeNote } from '../keying.js';
import { keyLimb, unkeyMessage, whyNotKeyLimb } from '../parts.js';
import {
  acceptMessage,
  allPins,
  beginPin,
  contradicted,
  dismissMessage,
  endPin,
  framesOf,
  isSoft,
  noProposals,
  pinHere,
  pinToFloor,
  proposedPins,
  togglePin,
  unpin,
  showOwnPose,
  whyNoPinHere,
  whyNotPin,
} from '../pins.js';
import { frame, isKey } from '../playhead.js';
import {
  deleteAny,
  deleteLabel,
  nudge,
  selectAll,
  selectHere,
  whyNotDeleteAny,
  whyNotNudge,
  whyNotSelect,
  whyNotSelectAll,
} from '../selection.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const KEYFRAMES = {
  addKeyframe: { also: 'key set insert record pose i', label: 'Add keyframe', icon: 'key', keys: ['K'], run: addKey },
  keyLimb: {
    also: 'partial keyframe part only correct arm leg',
    label: 'Key this limb only',
    icon: 'part',
    keys: ['Shift K'],
    off: whyNotKeyLimb,
    title: 'The limb is exact at this frame, the rest of the body stays with the tracker',
    run: keyLimb,
  },
  keyWhole: {
    label: 'Key the whole pose',
    icon: 'key',
    message: (at = frame()) => ({ do: 'add_key', frame: at }),
    also: 'full keyframe all parts',
  },
  unkeyLimb: {
    label: (about) => `Leave the ${about?.label?.toLowerCase() ?? 'limb'} to the tracker`,
    icon: 'x',
    message: unkeyMessage,
    also: 'remove partial keyframe release limb',
  },
  deleteKeyframe: {
    label: deleteLabel,
    icon: 'key',
    keys: ['Delete'],
    row: 'Delete keyframes',
    off: whyNotDeleteAny,
    run: deleteAny,
    also: 'remove key clear unkey discard draft',
  },
  duplicateKeyframe: { label: 'Duplicate to frame', icon: 'copy', run: duplicateKey },
  selectAllKeyframes: { label: 'Select all keyframes', keys: ['Ctrl A'], off: whyNotSelectAll, run: selectAll },
  selectKeyframe: {
    label: 'Select this keyframe',
    title: 'One more or one less',
    keys: ['Shift S'],
    off: whyNotSelect,
    run: selectHere,
  },
  selectRange: { label: 'Range, one more', keys: ['Shift Click', 'Ctrl Click'], handledBy: 'pointer' },
  earlier: nudging(-1, 'ArrowLeft'),
  later: nudging(1, 'ArrowRight'),
  tenEarlier: nudging(-10, 'Shift ArrowLeft'),
  tenLater: nudging(10, 'Shift ArrowRight'),
};

function nudging(by, chord) {
  const label = `Move selected keyframes ${
    Math.abs(by) === 1 ? 'one frame' : 'ten frames'
  } ${by < 0 ? 'earlier' : 'later'}`;
  return {
    label,
    keys: [`Ctrl ${chord}`],
    row: Math.abs(by) === 1 ? 'Move selected ones' : 'By ten frames',
    repeats: true,
    off: () => whyNotNudge(by),
    run: () => nudge(by),
  };
}

/** @satisfies {Record<string, Action>} */
export const NOTES = {
  note: {
    also: 'comment annotate annotation marker bookmark label flag remark todo',
    label: (at) => (noteAt(at) ? 'Edit note' : 'Add note'),
    icon: 'note',
    keys: ['Shift M'],
    row: 'Note at this frame',
    run: writeNote,
    title: (at) => (noteAt(at) ? 'Edit the note at this frame' : 'Write a note at this frame, or leave a flag'),
  },
  deleteNote: {
    also: 'remove comment marker flag',
    label: 'Delete note',
    icon: 'trash',
    off: whyNoNote,
    message: (at = frame()) => ({ do: 'delete_note', frame: at }),
  },
  notes: {
    label: 'All notes',
    icon: 'note',
    off: () => (server.notes?.length ? '' : 'There are no notes'),
    run: () => toggleSearch('Note'),
  },
  previousNote: {
    also: 'comment marker bookmark flag back',
    label: 'Previous note',
    icon: 'flag',
    keys: ['Shift H'],
    row: 'Previous, next note',
    repeats: true,
    off: () => noNote(-1),
    run: () => toNote(-1),
  },
  nextNote: {
    also: 'comment marker bookmark flag forward',
    label: 'Next note',
    icon: 'flag',
    keys: ['H'],
    row: 'Previous, next note',
    repeats: true,
    off: () => noNote(1),
    run: () => toNote(1),
  },
};

/** @satisfies {Record<string, Action>} */
export const PINS = {
  pin: {
    also: 'lock contact plant foot fix hold constraint ik stick sliding skating',
    label: (part) => (pinHere(part) === undefined ? 'Pin here from this frame' : 'Unpin'),
    icon: 'anchor',
    keys: ['Shift P'],
    row: 'Pin, unpin hand or foot',
    off: whyNotPin,
    run: togglePin,
    title: 'The part stays in its place as long as it stands still around this frame',
  },
  pinCorner: {
    label: 'Pin this corner',
    icon: 'anchor',
    title: 'The corner stays in its place around this frame',
    message: ({ part, at }) => ({ do: 'set_pin', part, frame: frame(), corner: at }),
  },
  pinToFloor: {
    also: 'ground plant contact foot',
    label: 'Pin to floor',
    icon: 'down',
    off: whyNotPin,
    run: pinToFloor,
  },
  beginPin: {
    also: 'start contact trim',
    label: 'Begin the pin at this frame',
    icon: 'mid',
    off: whyNoPinHere,
    run: beginPin,
  },
  endPin: {
    also: 'release contact trim stop',
    label: 'End the pin at this frame',
    icon: 'mid',
    off: whyNoPinHere,
    run: endPin,
  },
  unpin: {
    also: 'unlock release free remove contact',
    label: 'Unpin',
    icon: 'x',
    off: (index) => (allPins()[index ?? pinHere()] ? '' : whyNoPinHere()),
    title: (index) => unpinTitle(allPins()[index ?? pinHere()]),
    run: unpin,
  },
  acceptPins: {
    also: 'contacts proposals feet',
    alone: 'Accept all proposed pins',
    label: (pin) => (pin || proposedPins().length === 1 ? 'Accept' : `Accept all ${proposedPins().length}`),
    icon: 'check',
    off: noProposals,
    message: acceptMessage,
  },
  dismissPins: {
    also: 'reject proposals contacts',
    alone: 'Dismiss all proposed pins',
    label: 'Dismiss',
    icon: 'x',
    title: 'They come back after the next tracking',
    off: noProposals,
    message: dismissMessage,
  },
  softKey: {
    also: 'soft soften exact hard keyframe weight loose',
    label: (at) => (isSoft(at) ? 'Make the keyframe exact' : 'Make the keyframe approximate'),
    icon: 'key',
    title: 'An approximate keyframe gives way in depth to pins and smoothness',
    off: (at = frame()) => (isKey(at) ? '' : `Frame ${at} is not a keyframe`),
    message: (at = frame()) => ({ do: isSoft(at) ? 'exact_key' : 'soften_key', frame: at }),
  },
  ownPose: {
    also: 'ghost posed original soft',
    label: 'Go to the keyframe’s own pose',
    icon: 'ghost',
    off: (at = frame()) => (isSoft(at) ? '' : 'The motion passes exact keyframes as they were posed'),
    title: 'A ghost shows how it was posed: the motion passes an approximate keyframe nearby',
    run: showOwnPose,
  },
  softKeys: {
    also: 'soft soften contradict pin jerk keyframes',
    label: (keyframes = contradicted()) =>
      `Relax ${keyframes.length === 1 ? 'the keyframe' : `${keyframes.length} keyframes`}`,
    icon: 'key',
    title: 'Keyframes that pins contradict give way in depth to pins and smoothness',
    off: (keyframes = contradicted()) => (keyframes.length ? '' : 'No pin contradicts a keyframe'),
    message: (keyframes = contradicted()) => ({ do: 'soften_keys', frames: keyframes }),
  },
  splitPin: {
    label: 'Split the pin',
    icon: 'mid',
    title: 'Two places instead of one, the second from this keyframe on',
    message: ({ index, frame: at } = { index: 0, frame: frame() }) => ({ do: 'split_pin', index, frame: at }),
  },
  partMenu: { label: 'Menu of a part', keys: ['Right-click', 'Menu'], handledBy: 'pointer' },
};

const unpinTitle = (pin) => (pin ? `Unpin ${pin.label.toLowerCase()}, frames ${framesOf(pin)}` : 'Unpin');
