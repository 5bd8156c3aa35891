// The top bar: file, saved, undo, job, Live, Track, Export, help, theme.

import { html, render } from '../vendor/lit-html/lit-html.js';
import { LOGO, icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server, ui, watch } from '../store/state.js';
import { exportButton } from './export_menu.js';
import { fileButton } from './file_menu.js';
import { jobState, noticeJob } from './job.js';
import { toggleSheet } from '../controls/dialogs.js';
import { savedState, savedTicks } from './saved.js';
import { themeButton } from './theme.js';
import { liveSwitch, trackButton } from './track.js';

/** @type {import('../store/shapes.js').Watched[]} */
const SECTIONS = ['file', 'saved', 'undo', 'job', 'view', 'keys', 'segments'];
/** @type {import('../store/shapes.js').Watched[]} */
const OWN = ['u:menu', 'u:ended', 'u:library', 'u:connected', 'u:layout', 'u:sheet'];

export function mountTopbar() {
  const element = document.getElementById('top');
  const draw = () => {
    render(bar(), element);
    document.title = title();
  };
  watch(['job', 'segments'], noticeJob);
  watch([...SECTIONS, ...OWN], draw);
  setInterval(() => savedTicks() && draw(), 1000);
}

function bar() {
  return html`<div class="row logo">${LOGO}<span class="wordmark">Keypose</span></div>
    ${server.file ? session() : html`<span class="sp"></span>`}
    <button
      class="ib ${ui.sheet ? 'hov' : ''}"
      title="Keys and help   ?"
      aria-label="Keys and help"
      @click=${toggleSheet}
    >
      ${icon('help')}
    </button>
    ${themeButton()}`;
}

/** The browser's tab tells how far the tracking is while one works elsewhere. */
function title() {
  if (!server.file) return 'Keypose';
  const percent = server.job?.state === 'running' ? `${Math.round(server.job.percent ?? 0)} % ` : '';
  return `${percent}${server.file.name} – Keypose`;
}

function session() {
  return html`${fileButton()}${savedState()}
    <span class="vsep"></span>
    ${step('undo', 'Undo', 'Ctrl Z')}${step('redo', 'Redo', 'Ctrl Shift Z')}
    <span class="sp"></span>${jobState()}${liveSwitch()}${trackButton()}
    <span class="vsep"></span>${exportButton()}`;
}

function step(action, word, keys) {
  const label = server.undo?.[action];
  const hint = label ? `${word} “${label}”   ${keys}` : `Nothing to ${action}`;
  return html`<button
    class="ib"
    title=${hint}
    aria-label=${label ? `${word} ${label}` : word}
    ?disabled=${!label}
    @click=${() => send({ do: action })}
  >
    ${icon(action)}
  </button>`;
}
