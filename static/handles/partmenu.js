// The menu of a part at the pointer, in the free view: what can be pinned of it, how one looks at it.

import { perform } from '../actions/actions.js';
import { line, openMenuAt } from '../controls/menu.js';
import { partNamed } from '../store/parts.js';
import { pinEntries } from './pinmenu.js';
import { select } from './select.js';

/** Open it at a place of the window; `part` may be none. */
export function openPartMenu(view, part, place) {
  if (part) select(part);
  const label = part ? partNamed(part).label : 'Free view';
  const look = (words, axis) => ({ label: words, icon: 'camc', run: () => view.alongAxis(axis) });
  const pins = part ? pinEntries(partNamed(part)) : [];
  openMenuAt(label, [...pins, ...(pins.length ? [line] : []), ...orbitEntries(view, part), line, look('Look from the side', 'x'), look('Look from above', 'y'), look('Look from the front', 'z'), line,
    { label: 'Reset view', icon: 'reset', right: '0', run: () => perform('fitView') },
  ], place);
}

/** About what one orbits, and what the eye does by itself. */
export function orbitEntries(view, part) {
  const { about, follows, turns } = view.habits;
  return [
    { label: part ? `About ${partNamed(part).label.toLowerCase()}` : 'About the part', icon: 'rot', checked: about === 'part', run: () => view.choose('about', 'part') },
    { label: 'About the body', icon: 'rot', checked: about === 'body', run: () => view.choose('about', 'body') },
    { label: 'Follow the body', icon: 'move', checked: follows, run: () => view.choose('follows', !follows) },
    { label: 'Turntable while playing', icon: 'play', checked: turns, run: () => view.choose('turns', !turns) },
  ];
}
