// Questions about the body's parts: which is selected, who hangs on whom, what it is called.

import { server } from '../store/state.js';
import { send } from '../store/link.js';

/** The part of this name, or undefined. */
export function partNamed(name) {
  return server.body?.parts.find((part) => part.name === name);
}

export function selectedPart() {
  return server.view?.selected ? partNamed(server.view.selected) : undefined;
}

export function select(name) {
  if (name !== server.view?.selected) send({ do: 'select', part: name });
}

/** Parents from the root down to, not including, the part. */
export function ancestors(part) {
  const line = [];
  for (let up = partNamed(part.parent); up; up = partNamed(up.parent)) line.unshift(up);
  return line;
}

export function childrenOf(part) {
  return server.body.parts.filter((other) => other.parent === part.name);
}

/** The name without its side: the dot beside it tells that. */
export function shortLabel(part) {
  const bare = part.label.replace(/^(left|right)\s+/i, '');
  return bare.charAt(0).toUpperCase() + bare.slice(1);
}

/** "Left" or "Right" of the part on the other side. */
export function otherSideWord(part) {
  return part.side === 'R' ? 'Left' : 'Right';
}
