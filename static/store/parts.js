// Questions about the body's parts: which is selected, which is a child of which, what it is called,
// whether its joint limits apply.

import { server, ui } from './state.js';
import { send } from './link.js';

/** The part of this name, or undefined. */
export function partNamed(name) {
  return server.body?.parts.find((part) => part.name === name);
}

export function selectedPart() {
  return server.view?.selected ? partNamed(server.view.selected) : undefined;
}

/** Select a part by its name, or with null none. */
export function select(name) {
  if (name !== (server.view?.selected ?? null)) send({ do: 'select', part: name });
}

/** Parents from the root down to, not including, the part. */
export function ancestors(part) {
  const line = [];
  for (let up = partNamed(part.parent); up; up = partNamed(up.parent)) line.unshift(up);
  return line;
}

export function childrenOf(part) {
  return (server.body?.parts ?? []).filter((other) => other.parent === part.name);
}

/** "Left" or "Right" of the part on the other side. */
export function otherSideWord(part) {
  return part.side === 'R' ? 'Left' : 'Right';
}

/** Whether the limits of a part's axis do not count; `part` is its name. */
export function isFree(part, axis) {
  return !server.view?.limits || (ui.freeAxes?.has(`${part}.${axis}`) ?? false);
}
