// What the top bar has no room for in a narrow window: a menu at its end, and how narrow it is.

import { keyOf } from '../actions/actions.js';
import { menuItem } from '../actions/buttons.js';
import { icon } from '../controls/icons.js';
import { heading, line, menuButton, menuHolder } from '../controls/menu.js';
import { server } from '../store/state.js';
import { words } from '../store/clip.js';

const NARROW = matchMedia('(max-width: 799px)');
const TINY = matchMedia('(max-width: 439px)');

/** Whether Live, help and theme are in the menu, and Export is an icon. */
export const isNarrow = () => NARROW.matches;

/** Whether redo is there as well. */
export const isTiny = () => TINY.matches;

/** Call fn when the window has become wider or narrower than that. */
export function onWidth(fn) {
  for (const width of [NARROW, TINY]) width.addEventListener('change', fn);
}

export function moreButton() {
  const button = menuButton('more', { kind: 'ib', title: 'More', label: 'More', face: icon('more') });
  return menuHolder('more', () => button, items, 'right');
}

function items() {
  return [
    ...(server.file ? ofTheSession() : []),
    menuItem('search'),
    menuItem('showKeys'),
    line,
    heading('Theme'),
    ...[menuItem('darkTheme'), menuItem('lightTheme'), menuItem('systemTheme')],
  ];
}

function ofTheSession() {
  return [
    isTiny() ? menuItem('redo') : null,
    menuItem('live', undefined, { label: `Live: ${words().verb.toLowerCase()} while posing`, right: keyOf('live') }),
    line,
    heading('Views'),
    menuItem('mainView'),
    menuItem('topView'),
    menuItem('sideView'),
    menuItem('frontView'),
    menuItem('allViews'),
    menuItem('freeView'),
    line,
  ];
}
