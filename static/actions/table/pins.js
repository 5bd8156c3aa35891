// Pins, and keyframes that give way to them.

import {
  acceptMessage, allPins, beginPin, contradicted, dismissMessage, endPin, framesOf, isSoft, noProposals, pinHere, pinToFloor, proposedPins, togglePin, unpin, whyNoPinHere, whyNotPin,
} from '../pins.js';
import { frame, isKey } from '../playhead.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const PINS = {
  pin: {
    also: 'lock contact plant foot fix hold constraint ik stick sliding skating',
    label: (part) => (pinHere(part) === undefined ? 'Pin here from this frame' : 'Unpin'), icon: 'anchor', keys: ['Shift P'],
    row: 'Pin, unpin hand or foot', off: whyNotPin, run: togglePin,
    title: 'The part stays in its place as long as it stands still around this frame',
  },
  pinCorner: {
    label: 'Pin this corner', icon: 'anchor', title: 'The corner stays in its place around this frame',
    message: ({ part, at }) => ({ do: 'set_pin', part, frame: frame(), corner: at }),
  },
  pinToFloor: { also: 'ground plant contact foot', label: 'Pin to floor', icon: 'down', off: whyNotPin, run: pinToFloor },
  beginPin: { also: 'start contact trim', label: 'Begin the pin at this frame', icon: 'mid', off: whyNoPinHere, run: beginPin },
  endPin: { also: 'release contact trim stop', label: 'End the pin at this frame', icon: 'mid', off: whyNoPinHere, run: endPin },
  unpin: {
    also: 'unlock release free remove contact',
    label: 'Unpin', icon: 'x', off: (index) => (allPins()[index ?? pinHere()] ? '' : whyNoPinHere()),
    title: (index) => unpinTitle(allPins()[index ?? pinHere()]), run: unpin,
  },
  acceptPins: {
    also: 'contacts proposals feet', alone: 'Accept all proposed pins',
    label: (pin) => (pin || proposedPins().length === 1 ? 'Accept' : `Accept all ${proposedPins().length}`), icon: 'check', off: noProposals,
    message: acceptMessage,
  },
  dismissPins: {
    also: 'reject proposals contacts', alone: 'Dismiss all proposed pins',
    label: 'Dismiss', icon: 'x', title: 'They come back after the next tracking', off: noProposals, message: dismissMessage,
  },
  softKey: {
    also: 'soft exact hard keyframe weight loose',
    label: (at) => (isSoft(at) ? 'Make the keyframe exact' : 'Soften the keyframe'), icon: 'key',
    title: 'A soft keyframe gives way in depth to pins and smoothness',
    off: (at = frame()) => (isKey(at) ? '' : `Frame ${at} is not a keyframe`),
    message: (at = frame()) => ({ do: isSoft(at) ? 'exact_key' : 'soften_key', frame: at }),
  },
  softKeys: {
    also: 'soft contradict pin jerk keyframes',
    label: (keyframes = contradicted()) => `Soften ${keyframes.length === 1 ? 'the keyframe' : `${keyframes.length} keyframes`}`, icon: 'key',
    title: 'Keyframes that pins contradict give way in depth to pins and smoothness',
    off: (keyframes = contradicted()) => (keyframes.length ? '' : 'No pin contradicts a keyframe'),
    message: (keyframes = contradicted()) => ({ do: 'soften_keys', frames: keyframes }),
  },
  splitPin: {
    label: 'Split the pin', icon: 'mid', title: 'Two places instead of one, the second from this keyframe on',
    message: ({ index, frame: at } = { index: 0, frame: frame() }) => ({ do: 'split_pin', index, frame: at }),
  },
  partMenu: { label: 'Menu of a part', keys: ['Right-click', 'Menu'], handledBy: 'pointer' },
};

const unpinTitle = (pin) => (pin ? `Unpin ${pin.label.toLowerCase()}, frames ${framesOf(pin)}` : 'Unpin');
