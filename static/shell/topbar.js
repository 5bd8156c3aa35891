// The top bar: file, saved, undo, job, Live, Track, Export, help, theme.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { actionIcon, menuItem } from '../actions/buttons.js';
import { historyRows } from '../actions/history.js';
import { icon, LOGO } from '../controls/icons.js';
import { heading, line, menuButton, menuHolder, note, toggleMenu } from '../controls/menu.js';
import { count, longAgo } from '../controls/words.js';
import { isRenamed, renameBox, sessionEntries } from '../start/recents.js';
import { damagedFrames, isSurface } from '../store/clip.js';
import { loadLibrary } from '../store/library.js';
import { server, ui, watch } from '../store/state.js';
import { exportButton } from './export_menu.js';
import { jobState, noticeJob, sayWhatIsCut } from './job.js';
import { isNarrow, isTiny, moreButton, onWidth } from './more.js';
import { savedState, savedTicks } from './status.js';
import { liveSwitch, trackButton } from './track.js';

const RECENT = 5;

export function fileButton() {
  const { id, name, path, video } = server.file;
  if (isRenamed(id)) return html`<span class="row file">${icon('film')}${renameBox({ id, name })}</span>`;
  const face = html`${icon('film')}<span class="b cut">${name}</span> <span class="mut wide cut">${video}</span>${icon('chev')}`;
  const button = menuButton('file', { kind: 'row file', title: path, face, act: showFileMenu });
  return menuHolder('file', () => button, fileItems, 'left filemenu');
}

function showFileMenu() {
  loadLibrary();
  toggleMenu('file');
}

function fileItems() {
  const others = (ui.library?.recents ?? []).filter((r) => r.path !== server.file.path && !r.missing);
  return [
    menuItem('openFile'),
    menuItem('importFile', undefined, { right: 'motion, keypoints, camera' }),
    menuItem('addFilm', undefined, { right: 'of the same motion' }),
    ...(others.length ? [heading('Recent'), ...others.slice(0, RECENT).map(recent)] : []),
    line,
    note(facts()),
    ...sessionEntries(server.file).map((entry) => ({ ...entry, right: '' })),
    menuItem('copyPath'),
    line,
    menuItem('closeFile', undefined, { right: 'to the start screen' }),
  ];
}

function recent(session) {
  const { keyframes, opened_at: at } = session;
  return menuItem('openRecent', session, { right: `${count(keyframes, 'keyframe')} · ${longAgo(at)}` });
}

function facts() {
  const { frames, fps, width, height, duration_s: seconds, path, missing, repeated } = server.file;
  const lost = isSurface() ? missing.length : damagedFrames();
  const rate = Number.isInteger(fps) ? fps : fps?.toFixed(2);
  return html`<span class="num">${count(frames, 'frame')} · ${rate} fps · ${width} × ${height}</span>
    <span class="num"> · ${seconds?.toFixed(2)} s</span>
    ${lost ? html`<br /><span class="checkword">${damaged(lost)}</span>` : nothing}
    ${repeated ? html`<br /><span>${count(repeated, 'repeated frame')}, not counted as standing still</span>` : nothing}
    <br /><span class="path">${path}</span>`;
}

const damaged = (n) =>
  isSurface() ? `${count(n, 'step')} without a surface` : `${count(n, 'damaged frame')}, not used for tracking`;

const NAME = 'history';

/** Undo and redo, the way to the list beside them. */
export function historyButtons() {
  const arrow = menuButton(NAME, { kind: 'ib slim', title: 'History', label: 'History', face: icon('chev') });
  return html`<span class="undoes" @contextmenu=${showHistoryMenu}>
    ${actionIcon('undo', undefined, { size: '' })}${isTiny() ? nothing : actionIcon('redo', undefined, { size: '' })}
    ${menuHolder(NAME, () => (isNarrow() ? nothing : arrow), historyItems, 'left history')}</span>`;
}

/** The right button on undo or redo. */
function showHistoryMenu(event) {
  event.preventDefault();
  if (!event.target.closest('.menu')) toggleMenu(NAME);
}

function historyItems() {
  const rows = historyRows(server.history);
  if (rows.length < 2) return [heading('Nothing has been changed yet')];
  return rows.map((row) => ('heading' in row ? heading(row.heading) : step(row)));
}

const step = ({ label, time, done, state }) =>
  menuItem('goToStep', done, { label, right: time, checked: state === 'here', kind: state });

/** @type {import('../store/shapes.js').Watched[]} */
const SECTIONS = ['file', 'saved', 'undo', 'history', 'job', 'view', 'keys', 'segments'];
/** @type {import('../store/shapes.js').Watched[]} */
const OWN = [
  'u:menu',
  'u:span',
  'u:ended',
  'u:library',
  'u:connected',
  'u:layout',
  'u:sheet',
  'u:filterMotion',
  'u:renaming',
  'u:exportJob',
  'u:exportMissing',
];

export function mountTopbar() {
  const element = document.getElementById('top');
  const draw = () => {
    render(bar(), element);
    if (document.title !== title()) document.title = title(); // a browser tells its window of every title
    sayWhatIsCut();
  };
  onWidth(draw);
  watch(['job'], noticeJob);
  watch([...SECTIONS, ...OWN], draw);
  setInterval(() => savedTicks() && draw(), 1000);
}

function bar() {
  return html`<div class="row logo">${LOGO}<span class="wordmark">Keypose</span></div>
    ${server.file ? sessionButton() : html`<span class="sp"></span>`}
    ${
      isNarrow()
        ? moreButton()
        : html`${actionIcon('search', undefined, { size: '' })}${actionIcon('showKeys', undefined, {
            size: '',
          })}${themeButton()}`
    }`;
}

/** The browser's tab shows how far the tracking is while one works elsewhere. */
function title() {
  if (!server.file) return 'Keypose';
  const percent = server.job?.state === 'running' ? `${Math.round(server.job.percent ?? 0)} % ` : '';
  return `${percent}${server.file.name} – Keypose`;
}

/** What comes and goes by itself stands in the middle; nothing left or right of it moves. */
function sessionButton() {
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
