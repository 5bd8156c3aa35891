// Parts: walking over them, part keyframes of some limbs alone, parts added and deleted.

import { count } from '../controls/words.js';
import { send } from '../store/link.js';
import { ancestors, childrenOf, partNamed, select, selectedPart } from '../store/parts.js';
import { server } from '../store/state.js';
import { isSurface } from '../store/clip.js';
import { draftFrames, frame, isKey, segmentAt } from './playhead.js';

/** All of them: [{frame, parts, limbs, words}], by frame. */
export const partKeys = () => server.keys?.parts ?? [];

export const partKeyAt = (at = frame()) => partKeys().find((key) => key.frame === at);

/** Shift K: what was posed here, else the selected limb, is this frame's part keyframe. */
export function keyLimb() {
  send({ do: 'key_parts', frame: frame() });
}

export function whyNotKeyLimb(part = selectedPart()) {
  const at = frame();
  if (isSurface()) return 'Surfaces are fitted to the whole body';
  if (isKey(at)) return `Frame ${at} is a keyframe of the whole body`;
  const segment = segmentAt(at);
  if (!segment || segment.first === at || segment.last === at) return 'Go between two keyframes';
  const hasLimb = part && part.parent !== null;
  return hasLimb || draftFrames().includes(at) ? '' : 'Select a limb, or move one';
}

/** The limb of a part stays with the tracker again. about: {frame, parts}. */
export const unkeyMessage = ({ frame: at, parts }) => ({ do: 'unkey_parts', frame: at, parts });

/** The part that another one is added to: the selected one, else the first. */
export const carrier = () => selectedPart() ?? server.body?.parts[0];

/** Add a part to another one, and select it. */
export function addPart(part = carrier()) {
  const name = freeName();
  send({ do: 'add_part', parent: part.name, name });
  select(name);
}

function freeName() {
  let number = server.body.parts.length + 1;
  while (partNamed(`part_${number}`)) number += 1;
  return `part_${number}`;
}

export function whyNotDeletePart(part = selectedPart()) {
  if (!part) return 'Select a part first';
  return part.parent ? '' : `${part.label} carries all other parts`;
}

/** Such as "Delete right forearm and 1 part on it". */
export function deleteTitle(part = selectedPart()) {
  if (!part) return 'Delete part';
  const hanging = descendants(part).length;
  return `Delete ${part.label.toLowerCase()}${hanging ? ` and ${count(hanging, 'part')} on it` : ''}`;
}

const descendants = (part) => childrenOf(part).flatMap((child) => [child, ...descendants(child)]);

/** Which child was last visited below a part: ] retraces the way [ came. */
const lastChild = new Map();

/** Select the part on the other side of the body. */
export function otherSide(part = selectedPart()) {
  if (part?.mirror) select(part.mirror);
}

/** Select the next part: −1 toward the body, +1 toward hand, foot or head. */
export function alongChain(step) {
  const part = selectedPart();
  if (!part) {
    if (server.body?.parts.length) select(server.body.parts[0].name);
    return;
  }
  const next = step < 0 ? partNamed(part.parent) : outward(part);
  if (next) select(next.name);
}

/** The part that ] leads to. */
export function outward(part) {
  const children = childrenOf(part);
  return children.find((child) => child.name === lastChild.get(part.name)) ?? children[0];
}

/** Where the chain through a part ends. */
export function endOfChain(part) {
  let end = part;
  for (let next = outward(end); next; next = outward(end)) end = next;
  return end;
}

/** Keep the way to the selected part, whoever selected it. */
export function remember(part) {
  const line = [...ancestors(part), part];
  for (let i = 1; i < line.length; i++) lastChild.set(line[i - 1].name, line[i].name);
}
