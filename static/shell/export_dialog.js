// The dialog of exports: what, with which options, how far it is.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { RIGS, UNITS, beginExport, cancelExport, notInstalled, whyNotExport } from '../actions/exporting.js';
import { whyNot } from '../actions/actions.js';
import { MOTION } from '../actions/table/export.js';
import { mountDialog } from '../controls/dialogs.js';
import { dropdown, segmented, textField } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { count, joined } from '../controls/words.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { frameCount } from '../store/clip.js';
import { frame } from '../actions/playhead.js';

/** @typedef {import('../actions/exporting.js').Options} Options */

const KINDS = { film: 'Film', pictures: 'Images', sheet: 'Keyframe sheet', motion: 'Motion' };
const VIEWS = {
  main: 'Camera', all: 'All four views', top: 'Top', side: 'Side', front: 'Front', orbit: 'Once round the body', free: 'As the free view looks',
};
const SIZES = ['1280x720', '1920x1080', '3840x2160'];

export function mountExportDialog() {
  mountDialog({
    id: 'exporting', label: 'Export', name: 'exporting',
    names: ['u:exportJob', 'u:exportMissing', 'file', 'keys', 'segments'], draw: () => (server.file ? dialog() : nothing),
  });
  watch(['file'], () => server.file || setUi('exporting', null)); // what was to be exported is closed
}

function dialog() {
  const options = ui.exporting;
  const fields = { film, pictures, sheet: keyframeSheet, motion }[options.what];
  return html`<form class="in" @submit=${submit} @keydown=${onKey}>
    <div class="row sheethead">
      <span class="title">Export</span><span class="sp"></span>
      <button type="button" class="ib" title="Close" data-key="Esc" aria-label="Close" @click=${() => setUi('exporting', null)}>${icon('x')}</button>
    </div>
    ${segmented({ label: 'What to export', value: options.what, options: kinds(), act: (what) => change({ what }) })}
    <div class="exfields" ?inert=${Boolean(ui.exportJob)}>${fields(options)}</div>
    ${ui.exportJob ? progress(ui.exportJob) : foot(options)}
  </form>`;
}

/** @param {Partial<Options>} changed */
const change = (changed) => setUi('exporting', { ...ui.exporting, ...changed });

function kinds() {
  const missing = ui.exportMissing?.film;
  return Object.entries(KINDS).map(([id, label]) => ({
    id, label, off: id === 'film' && missing ? `This needs an H.264 encoder: ${missing}` : '',
  }));
}

function submit(event) {
  event.preventDefault();
  if (!why(ui.exporting)) beginExport();
}

/** Enter in a field takes its text over first, with which it loses the focus. */
function onKey(event) {
  if (event.key === 'Enter' && event.target.matches('input.text')) requestAnimationFrame(() => submit(event));
}

/** Why this cannot be exported now, a sentence, or ''. */
function why(options) {
  if (options.what === 'motion') {
    const off = whyNot('saveAllMotion');
    if (off) return `${off}.`;
  } else if (!server.keys?.frames.length) return 'Add a keyframe first.';
  return whyNotExport(options, frameCount());
}

// --- the fields

const field = (label, content, note = '') =>
  html`<label class="exlabel">${label}</label><div class="exfield">${content}${note ? html`<span class="dim">${note}</span>` : nothing}</div>`;

const text = (label, name, placeholder = '', unit = '') =>
  html`${textField({ label, value: ui.exporting[name], placeholder, most: 9, act: (value) => change({ [name]: value }) })}${unit ? html`<span class="dim">${unit}</span>` : nothing}`;

const look = ({ style }) => field('Body', segmented({
  label: 'Body', value: style, act: (value) => change({ style: value }),
  options: [{ id: 'wire', label: 'Wire' }, { id: 'solid', label: 'Solid' }, { id: 'both', label: 'Both' }],
}));

function views(options, without = '') {
  const entries = Object.entries(VIEWS).filter(([id]) => id !== without);
  return field('View', dropdown({
    label: 'View', value: options.view, text: VIEWS[options.view], kind: 'field', act: (view) => change({ view }),
    options: entries.map(([id, label]) => ({ id, label })),
  }));
}

function size(options) {
  const { width, height } = server.file;
  const own = `As the video, ${width} × ${height}`;
  const label = (id) => (id === 'own' ? own : id.replace('x', ' × '));
  return field('Size', dropdown({
    label: 'Size', value: options.size, text: label(options.size), kind: 'field', act: (id) => change({ size: id }),
    options: ['own', ...SIZES].map((id) => ({ id, label: label(id) })),
  }));
}

const range = () => field('Frames', html`${text('First frame', 'first')}<span class="dim">to</span>${text('Last frame', 'last')}`);
const rate = () => field('Rate', text('Frames a second', 'fps', 'As the video', 'frames/s'));

const film = (options) => html`${views(options)}${range()}${size(options)}${rate()}${look(options)}`;

function pictures(options) {
  const keys = count(server.keys?.frames.length ?? 0, 'keyframe');
  const which = segmented({
    label: 'Frames', value: options.frames, act: (frames) => change({ frames }),
    options: [{ id: 'this', label: `Frame ${frame()}` }, { id: 'keyframes', label: `All ${keys}` }, { id: 'posed', label: 'Every frame' }],
  });
  const background = segmented({
    label: 'Background', value: options.background, act: (value) => change({ background: value }),
    options: [{ id: 'video', label: 'Video' }, { id: 'none', label: 'Transparent' }],
  });
  return html`${field('Frames', which)}${views(options, 'orbit')}${size(options)}${field('Background', background)}${look(options)}`;
}

const keyframeSheet = (options) => html`${field('Columns', text('Columns', 'columns', 'As it fits'))}${look(options)}`;

function motion(options) {
  const { format } = options;
  const off = Object.values(MOTION).map(notInstalled).filter(Boolean);
  const left = format === 'all' && off.length ? `Left out: ${off.join('; ')}` : remarkOf(format);
  return html`${field('Format', formats(format), left)}${rigs(options)}${units(options)}
    ${range()}${rate()}${times(options)}${field('Low-pass filter', text('Cut-off', 'filter', 'None', 'Hz'))}`;
}

function formats(format) {
  const options = [{ id: 'all', label: 'All, ZIP' }, ...Object.values(MOTION).map((kind) => ({
    id: String(kind.label).toLowerCase(), label: String(kind.label), note: kind.reader, off: notInstalled(kind),
  }))];
  return dropdown({ label: 'Format', value: format, kind: 'field', options, act: (id) => change({ format: id }) });
}

/** What a person should know of a format before choosing it. */
const remarkOf = (format) => Object.values(MOTION).find((kind) => String(kind.label).toLowerCase() === format)?.remark ?? '';

/** Whether times are those of the film. */
const times = ({ fromZero }) => field('Times', segmented({
  label: 'Times', value: fromZero ? 'zero' : 'film', act: (from) => change({ fromZero: from === 'zero' }),
  options: [{ id: 'film', label: 'As in the video' }, { id: 'zero', label: 'From 0' }],
}), fromZero ? 'for game engines and web players' : '');

/** Whose bones there are to be, where the format has bones. */
function rigs({ format, rig }) {
  const rigged = Object.values(MOTION).filter((kind) => 'rigged' in kind && kind.rigged).map(({ label }) => String(label));
  if (format !== 'all' && !rigged.includes(format.toUpperCase())) return nothing;
  const off = server.body?.is_persons ? '' : 'Only a person has these bones';
  return field('Rig', dropdown({
    label: 'Rig', value: rig, text: RIGS[rig], kind: 'field', act: (id) => change({ rig: id }),
    options: Object.entries(RIGS).map(([id, label]) => ({ id, label, off: id === 'keypose' ? '' : off })),
  }), rig === 'mixamo' ? 'three.js drops the colons of its names' : format === 'all' ? `of ${joined(rigged)}` : '');
}

/** In which unit lengths are, where the format cannot say it. */
function units({ format, unit }) {
  if (format !== 'all' && format !== 'bvh') return nothing;
  return field('Unit', dropdown({
    label: 'Unit', value: unit, kind: 'field', act: (id) => change({ unit: id }),
    options: Object.entries(UNITS).map(([id, words]) => ({ id, ...words })),
  }), format === 'all' ? 'of BVH' : '');
}

// --- below the fields

function foot(options) {
  const off = why(options);
  return html`<div class="row sheetfoot">
    <span class="dim" role="status">${off || FILES[options.what]}</span><span class="sp"></span>
    <button class="btn pri ${off ? 'off' : ''}" ?disabled=${Boolean(off)}>${icon('exp')}Export</button>
  </div>`;
}

const FILES = {
  film: 'One MP4 file (H.264, without sound).',
  pictures: 'PNG files, several of them in one ZIP.',
  sheet: 'One PNG file with all keyframes and their verdicts.',
  motion: 'As keypose export writes it.',
};

function progress({ what, done, of }) {
  const percent = of ? Math.round((100 * done) / of) : 0;
  const words = of ? `${what === 'film' ? 'Frame' : 'Image'} ${done} of ${of}` : 'Preparing…';
  return html`<div class="row sheetfoot">
    <div class="job exjob" role="progressbar" aria-label="Export" aria-valuenow=${of ? percent : nothing} aria-valuetext=${words}>
      <span class="spin">${icon('run')}</span><b>${KINDS[what]}</b><span class="mut num cut">${words}</span><span class="sp"></span>
      <button type="button" class="btn ghost sm" @click=${cancelExport}>Cancel</button>
      <span class="bar ${of ? '' : 'sweep'}" style="width:${of ? percent : 30}%"></span>
    </div>
  </div>`;
}
