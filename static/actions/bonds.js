// Bonds: what of the posed body holds a part of another one, or of itself.

import { bodies, posedBody } from '../store/bodies.js';
import { selectedPart } from '../store/parts.js';
import { server } from '../store/state.js';
import { frame } from './playhead.js';

/** @typedef {import('../store/shapes.js').Bond} Bond */

/** @returns {Bond[]} */
export const allBonds = () => server.bonds ?? [];

/** The end that is on the posed body; of two on it the one of the part. @param {Bond} bond */
export function ownEnd({ holder, held }, part = selectedPart()) {
  const posed = posedBody()?.id;
  if (held.body !== posed) return holder;
  if (holder.body !== posed) return held;
  return held.part === part?.name ? held : holder;
}

/** @param {Bond} bond */
export const otherEnd = (bond, part = selectedPart()) => (ownEnd(bond, part) === bond.holder ? bond.held : bond.holder);

/** Those between the posed body and this one; of the posed one, between parts of it. @param {string} id */
export function bondsWith(id) {
  const posed = posedBody()?.id;
  return allBonds().filter(
    ({ holder, held }) => (holder.body === posed && held.body === id) || (held.body === posed && holder.body === id),
  );
}

/** Those of a part. @returns {Bond[]} */
export const bondsOf = (part) => allBonds().filter((bond) => ownEnd(bond, part).part === part?.name);

/** The one of a part at the playhead. */
export const bondHere = (part = selectedPart()) =>
  bondsOf(part).find(({ first, last }) => first <= frame() && frame() <= last);

export function whyNotBond(part = selectedPart()) {
  if (!part) return 'Select the part that holds, or is held';
  return bodies().length > 1 ? '' : 'There is no other body: add one first';
}

/** With a part of a body, or with the nearest of the others. @param {{ body?: string, onto?: string }} [about] */
export const bondMessage = (about = {}) => ({ do: 'set_bond', part: selectedPart()?.name, frame: frame(), ...about });

export const whyNoBond = () => (bondHere() ? '' : `Nothing is held at frame ${frame()}`);

/** @param {number} [index] */
export const letGoMessage = (index = bondHere()?.index ?? 0) => ({ do: 'delete_bond', index });
