// Dark, light, or as the system has it.

import { chooseTheme, chosenTheme } from '../theme.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const THEME = {
  darkTheme: { ...theme('dark', 'Dark', 'moon'), also: 'appearance night mode colours colors', alone: 'Dark theme' },
  lightTheme: { ...theme('light', 'Light', 'sun'), also: 'appearance day mode colours colors', alone: 'Light theme' },
  systemTheme: { ...theme('auto', 'System', 'both'), also: 'appearance auto mode colours colors', alone: 'System theme' },
};

function theme(name, label, icon) {
  return { label, icon, always: true, on: () => chosenTheme() === name, run: () => chooseTheme(name) };
}
