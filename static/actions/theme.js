// Dark, light, or as the system says; kept per browser.

import { setUi } from '../store/state.js';
import { inBrowser } from '../store/storage.js';

const KEY = 'keypose.theme';
const THEMES = ['dark', 'light', 'auto'];
const WANTS_LIGHT = '(prefers-color-scheme: light)';

export function mountTheme() {
  matchMedia(WANTS_LIGHT).addEventListener('change', apply);
  apply();
}

export function chooseTheme(name) {
  inBrowser.write(KEY, name);
  apply();
}

export function chosenTheme() {
  const name = inBrowser.read(KEY);
  return THEMES.includes(name) ? name : 'dark';
}

function apply() {
  const wanted = chosenTheme();
  const system = matchMedia(WANTS_LIGHT).matches ? 'light' : 'dark';
  const theme = wanted === 'auto' ? system : wanted;
  document.documentElement.dataset.theme = theme;
  setUi('theme', theme);
}
