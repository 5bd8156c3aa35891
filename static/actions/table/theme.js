// Dark, light, or as the system has it.

import { chooseTheme, chosenTheme } from '../theme.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const THEME = {
  darkTheme: theme('dark', 'Dark', 'moon'),
  lightTheme: theme('light', 'Light', 'sun'),
  systemTheme: theme('auto', 'System', 'both'),
};

function theme(name, label, icon) {
  return { label, icon, always: true, on: () => chosenTheme() === name, run: () => chooseTheme(name) };
}
