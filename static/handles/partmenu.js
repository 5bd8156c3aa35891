// What the menus of the free view have besides: how one looks at what is there.

import { contextEntries } from '../actions/context_menus.js';
import { line } from '../controls/menu.js';
import { partNamed } from '../store/parts.js';

/** Entries about the eye; `part` is what was pressed on, if anything. */
export function freeEntries(view, part = null) {
  const look = (words, axis) => ({ label: words, icon: 'camc', run: () => view.alongAxis(axis) });
  return [
    ...orbitEntries(view, part?.name), line,
    look('Look from the side', 'x'), look('Look from above', 'y'), look('Look from the front', 'z'), line,
    ...contextEntries('eye'),
  ];
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
