// The dialog of exports: what, with which options, how far it is.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { beginExport, cancelExport, furtherOf, notInstalled, whyNoMatte, whyNotExport } from '../actions/exporting.js';
import { whyNot } from '../actions/actions.js';
import { cameraFindings } from '../actions/camera.js';
import { mountDialog } from '../controls/dialogs.js';
import { dropdown, segmented } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { field, orderFields } from '../controls/order_form.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { workUnderWay } from './job.js';
import { frameCount } from '../store/clip.js';
import { EXPORTS, FORMATS } from '../store/orders.js';

const KINDS = { film: 'Film', pictures: 'Images', sheet: 'Keyframe sheet', matte: 'Matte', motion: 'Motion' };
export function mountExportDialog() {
  mountDialog({
    id: 'exporting',
    label: 'Export',
    name: 'exporting',
    names: ['u:exportJob', 'u:exportMissing', 'file', 'keys', 'segments'],
    draw: () => (server.file ? dialog() : nothing),
  });
  watch(['file'], () => server.file || setUi('exporting', null)); // what was to be exported is closed
}

function dialog() {
  const options = ui.exporting;
  return html`<form class="in" @submit=${submit} @keydown=${onKey}>
    <div class="row sheethead">
      <span class="title">Export</span><span class="sp"></span>
      <button type="button" class="ib" title="Close" data-key="Esc" aria-label="Close"
        @click=${() => setUi('exporting', null)}>${icon('x')}</button>
    </div>
    ${segmented({ label: 'What to export', value: options.what, options: kinds(), act: (what) => change({ what }) })}
    <div class="exfields" ?inert=${Boolean(ui.exportJob)}>${fields(options)}</div>
    ${ui.exportJob ? progress(ui.exportJob) : foot(options)}
  </form>`;
}

/** @param {Partial<import('../store/shapes.js').Exporting>} changed */
const change = (changed) => setUi('exporting', { ...ui.exporting, ...changed });

function kinds() {
  const missing = ui.exportMissing?.film;
  return Object.entries(KINDS).map(([id, label]) => ({
    id,
    label,
    off: id === 'film' && missing ? `This needs an H.264 encoder: ${missing}` : '',
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
  } else if (options.what === 'matte') {
    const off = whyNoMatte();
    if (off) return `${off}.`;
  } else if (!server.keys?.frames.length) return 'Add a keyframe first.';
  return whyNotExport(options, frameCount());
}

// --- the fields

/** Where nothing tells how far the camera went. */
function withoutScale() {
  const found = cameraFindings().filter(({ kind }) => kind === 'no_scale');
  if (!found.length) return nothing;
  const frames = found.map(({ first, last }) => `${first}–${last}`).join(', ');
  return html`<p class="note icons warned">${icon('warn')}<span>Frames ${frames}: the scale of the camera’s path is not known. It is written as if the camera only turned there.</span></p>`;
}

function fields(exporting) {
  const { what, values } = exporting;
  const set = (changed) => change({ values: { ...values, [what]: { ...values[what], ...changed } } });
  const own = orderFields(EXPORTS[what], values[what], set, furtherOf(exporting));
  return what === 'motion' ? html`${formats(exporting.format)}${own}${withoutScale()}` : own;
}

function formats(format) {
  const off = Object.keys(FORMATS).map(notInstalled).filter(Boolean);
  const left =
    format === 'all' && off.length
      ? `Left out: ${off.join('; ')}`
      : FORMATS[format]?.remark || FORMATS[format]?.then || '';
  const options = [
    { id: 'all', label: 'All, ZIP' },
    ...Object.entries(FORMATS).map(([id, { label, reader }]) => ({
      id,
      label,
      note: reader,
      off: notInstalled(id),
    })),
  ];
  return field(
    'Format',
    dropdown({ label: 'Format', value: format, kind: 'field', options, act: (id) => change({ format: id }) }),
    left,
  );
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
  matte: 'The person with alpha: pictures, or a film (VP9, ProRes 4444).',
  motion: 'As keypose export writes it.',
};

const STEPS = { film: 'Frame', matte: 'Step' };

function progress({ what, done, of }) {
  const words = of ? `${STEPS[what] ?? 'Image'} ${done} of ${of}` : 'Preparing…';
  return workUnderWay({ label: 'Export', title: KINDS[what], words, done, of, cancel: cancelExport });
}
