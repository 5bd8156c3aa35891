// The top bar: file, saved, undo, job, Live, Track, Export, help, theme.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { actionIcon, menuItem } from '../actions/buttons.js';
import { icon, LOGO } from '../controls/icons.js';
import { menuButton, menuHolder } from '../controls/menu.js';
import { server, watch } from '../store/state.js';
import { exportButton } from './export_menu.js';
import { fileButton } from './file_menu.js';
import { historyButtons } from './history_menu.js';
import { jobState, noticeJob } from './job.js';
import { isNarrow, moreButton, onWidth } from './more.js';
import { savedState, savedTicks } from './saved.js';
import { liveSwitch, trackButton } from './track.js';

/** @type {import('../store/shapes.js').Watched[]} */
const SECTIONS = ['file', 'saved', 'undo', 'history', 'job', 'view', 'keys', 'segments'];
/** @type {import('../store/shapes.js').Watched[]} */
const OWN = ['u:menu', 'u:ended', 'u:library', 'u:connected', 'u:layout', 'u:sheet', 'u:filterMotion', 'u:renaming', 'u:exportJob', 'u:exportMissing'];

export function mountTopbar() {
  const element = document.getElementById('top');
  const draw = () => {
    render(bar(), element);
    document.title = title();
  };
  onWidth(draw);
  watch(['job'], noticeJob);
  watch([...SECTIONS, ...OWN], draw);
  setInterval(() => savedTicks() && draw(), 1000);
}

function bar() {
  return html`<div class="row logo">${LOGO}<span class="wordmark">Keypose</span></div>
    ${server.file ? session() : html`<span class="sp"></span>`}
    ${isNarrow() ? moreButton() : html`${actionIcon('search', undefined, { size: '' })}${actionIcon('showKeys', undefined, { size: '' })}${themeButton()}`}`;
}

/** The browser's tab shows how far the tracking is while one works elsewhere. */
function title() {
  if (!server.file) return 'Keypose';
  const percent = server.job?.state === 'running' ? `${Math.round(server.job.percent ?? 0)} % ` : '';
  return `${percent}${server.file.name} – Keypose`;
}

/** What comes and goes by itself stands in the middle; nothing left or right of it moves. */
function session() {
  return html`<h1 class="unseen">${server.file.name}</h1>${fileButton()}
    ${historyButtons()}
    <span class="news">${savedState()}</span>${jobState()}${isNarrow() ? nothing : liveSwitch()}${trackButton()}
    <span class="vsep"></span>${exportButton()}`;
}

function themeButton() {
  const button = menuButton('theme', { kind: 'ib', title: 'Theme', label: 'Theme', face: icon('sun') });
  const items = () => [menuItem('darkTheme'), menuItem('lightTheme'), menuItem('systemTheme')];
  return menuHolder('theme', () => button, items, 'right small');
}
