// Walking over the body with Q, [ and ].

import { partNamed, ancestors, childrenOf, select, selectedPart } from '../store/parts.js';
import { server } from '../store/state.js';

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
