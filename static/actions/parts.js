// Parts added to the body and taken from it.

import { count } from '../controls/words.js';
import { send } from '../store/link.js';
import { childrenOf, partNamed, select, selectedPart } from '../store/parts.js';
import { server } from '../store/state.js';

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
