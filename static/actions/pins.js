// Pins: which is where, setting and removing one, and why it cannot be done.

import { select, selectedPart } from '../store/parts.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { toast } from '../controls/toasts.js';
import { range } from '../controls/words.js';
import { frame, goTo, stopPlaying } from './playhead.js';

/** @typedef {import('../store/shapes.js').Pin} Pin */

/** @returns {Pin[]} */
export const allPins = () => server.pins ?? [];

export const proposedPins = () => server.proposed_pins ?? [];

const JERK_CM = 8; // less is not seen as the motion plays

/** Pins that hold a part far from where exact keyframes have it, the worst first. */
export const contradictions = () => (server.space ?? []).filter(({ kind, cm }) => kind === 'pin' && cm >= JERK_CM);

/** The keyframes that they contradict. */
export const contradicted = () =>
  [...new Set(contradictions().flatMap(({ keyframes }) => keyframes))].sort((a, b) => a - b);

export const framesOf = ({ first, last }) => range(first, last);

/** Whether a part is a hand or a foot, or whatever ends a limb. */
export const isEnd = (part) =>
  (server.body?.handles ?? []).some((handle) => handle.kind === 'end' && handle.part === part?.name);

/** Whether a part has a sole to be put down. */
export const isFoot = (part) => wholeFoot(part).length === 2;

/** The landmarks of a whole foot: heel and toe. */
export const wholeFoot = (part) =>
  ['heel', 'toe'].map((end) => part?.landmarks?.find((name) => name.endsWith(end))).filter(Boolean);

export const isPinAt = ({ first, last }, at) => first <= at && at <= last;

/** The numbers of a part's pins. */
export const pinsOf = (part) => allPins().flatMap((pin, index) => (pin.part === part?.name ? [index] : []));

/** The number of the part's pin at the playhead, or undefined. */
export const pinHere = (part = selectedPart()) => pinsOf(part).find((index) => isPinAt(allPins()[index], frame()));

/** The part's pin that one means at the playhead: the one here, else the nearest. */
export function pinMeant(part) {
  const away = (index) => {
    const { first, last } = allPins()[index];
    return Math.max(first - frame(), frame() - last, 0);
  };
  const [nearest] = pinsOf(part).sort((a, b) => away(a) - away(b));
  return nearest;
}

/** Of a part, by default the selected one: why it cannot be pinned from anywhere. */
export function whyNotPin(part = selectedPart()) {
  return isEnd(part) || pinHere(part) !== undefined ? '' : 'Select a foot or a hand to pin it';
}

export const whyNoPinHere = (part = selectedPart()) =>
  pinHere(part) === undefined ? `Nothing is pinned at frame ${frame()}` : '';

/** Pin a hand or a foot around the playhead; where it is pinned, unpin it. */
export function togglePin(part = selectedPart()) {
  const here = pinHere(part);
  stopPlaying();
  if (here === undefined) pinPart(part);
  else unpin(here);
}

/** Pin a part around the playhead. */
export function pinPart(part) {
  send({ do: 'set_pin', part: part.name, frame: frame() });
}

export function unpin(index = pinHere()) {
  send({ do: 'delete_pin', index });
}

/**
 * Take the pin away that holds a part over these frames.
 * @param {string} part
 * @param {number} first
 * @param {number} last
 */
export function unpinOver(part, first, last) {
  const index = allPins().findIndex((pin) => pin.part === part && pin.first <= last && pin.last >= first);
  if (index >= 0) unpin(index);
}

/** The pin here begins at the playhead. */
export function beginPin(part = selectedPart()) {
  send({ do: 'change_pin', index: pinHere(part), first: frame() });
}

/** The pin here ends at the playhead. */
export function endPin(part = selectedPart()) {
  send({ do: 'change_pin', index: pinHere(part), last: frame() });
}

/** Put a hand or a foot on the floor; where nobody knows how high that is, ask first. */
export function pinToFloor(part = selectedPart()) {
  const here = pinHere(part);
  const message =
    here === undefined
      ? { do: 'set_pin', part: part.name, frame: frame(), floor: true }
      : { do: 'change_pin', index: here, floor: true };
  onFloor(message, part);
}

/** Send what puts something on the floor, once it is known where that is. */
export function onFloor(message, part) {
  if (server.floor?.height_m != null) return void send(message);
  const word = isFoot(part) ? 'foot' : part.short.toLowerCase();
  const button = { label: `Use this ${word}’s height`, send: message };
  return toast({ kind: 'info', words: 'Where is the floor?', button });
}

export const acceptMessage = (pin) => ({ do: 'accept_pins', ...nameOf(pin) });

export const dismissMessage = (pin) => ({ do: 'dismiss_pins', ...nameOf(pin) });

const nameOf = (pin) => (pin ? { part: pin.part, first: pin.first } : {});

export const noProposals = () => (proposedPins().length ? '' : 'No pins are proposed');

/** To a pin's part, at a frame of it. */
export function showPin(pin, at) {
  stopPlaying();
  select(pin.part);
  goTo(at);
}

/** What its menu is called: "Left foot · pinned 0–66". */
export function pinTitle(part) {
  const here = pinHere(part);
  return here === undefined ? part.label : `${part.label} · pinned ${framesOf(allPins()[here])}`;
}

export const isSoft = (at = frame()) => Boolean(server.keys?.soft?.includes(at));

/** Exact keyframes within a pin. @param {Pin} pin */
export const exactWithin = ({ first, last }) =>
  (server.keys?.frames ?? []).filter((at) => first <= at && at <= last && !isSoft(at));

/** A soft keyframe's own pose, as a ghost beside the motion that passes it. */
export function showOwnPose(at = frame()) {
  stopPlaying();
  goTo(at);
  send({ do: 'display', ghosts: true });
}
