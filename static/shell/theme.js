// Dark, light, or as the system says; kept per browser.

import { html } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { setUi } from '../store/state.js';
import { inBrowser } from '../store/storage.js';
import { menuHolder, toggleMenu } from '../controls/menu.js';

const KEY = 'keypose.theme';
const NAMES = { dark: 'Dark', light: 'Light', auto: 'As the system' };
const ICONS = { dark: 'moon', light: 'sun', auto: 'both' };
const system = matchMedia('(prefers-color-scheme: light)');

export function mountTheme() {
  system.addEventListener('change', apply);
  apply();
}

/** The button and its menu. */
export function themeButton() {
  const button = (open) => html`<button
    class="ib"
    title="Light or dark"
    aria-label="Light or dark"
    aria-haspopup="menu"
    aria-expanded=${open}
    @click=${() => toggleMenu('theme')}
  >
    ${icon('sun')}
  </button>`;
  return menuHolder('theme', button, items, 'right small');
}

function items() {
  return Object.keys(NAMES).map((name) => ({
    icon: ICONS[name],
    label: NAMES[name],
    checked: chosen() === name,
    run: () => choose(name),
  }));
}

function choose(name) {
  inBrowser.write(KEY, name);
  apply();
}

function chosen() {
  const name = inBrowser.read(KEY);
  return name in NAMES ? name : 'dark';
}

function apply() {
  const wanted = chosen();
  const theme = wanted === 'auto' ? (system.matches ? 'light' : 'dark') : wanted;
  document.documentElement.dataset.theme = theme;
  setUi('theme', theme);
}
