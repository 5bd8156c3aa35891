// Long exports: what is asked for, the job that the server makes of it, and the file it becomes.

import { toast } from '../controls/toasts.js';
import { fetchOwn } from '../store/key.js';
import { server, setUi, ui } from '../store/state.js';
import { view as viewNamed } from '../views/views.js';
import { FILTER_HZ, fetchOk, saveAs, saveFrom } from './export.js';
import { frame } from './playhead.js';

const LOOK_MS = 400;
const PATIENCE = 20; // looks in a row without an answer, before it is given up

/**
 * @typedef {object} Options  What is chosen in the dialog.
 * @property {'film' | 'pictures' | 'sheet' | 'motion'} what
 * @property {string} view
 * @property {string} size  'own', or such as '1280x720'.
 * @property {'wire' | 'solid' | 'both'} style
 * @property {string} first
 * @property {string} last
 * @property {string} fps  Empty: the film's own.
 * @property {'this' | 'keyframes' | 'posed'} frames
 * @property {'video' | 'none'} background
 * @property {string} columns  Empty: as it fits.
 * @property {string} format
 * @property {string} filter  Hertz; empty: none.
 * @property {string} rig  Whose bones formats have that have bones; a key of RIGS.
 * @property {string} unit  Of lengths in BVH; a key of UNITS.
 * @property {boolean} fromZero  Whether times begin at 0 instead of where they are in the film.
 */

/** The rigs as of `tracker/formats/rigs`. */
export const RIGS = {
  keypose: 'Own names', mixamo: 'Mixamo', ue5: 'Unreal Engine 5', metahuman: 'MetaHuman', vrm: 'VRM humanoid', cmu: 'CMU', smpl: 'SMPL',
};

/** The units as of `tracker/formats/units.py`. */
export const UNITS = {
  m: { label: 'Metres', note: 'Blender' }, cm: { label: 'Centimetres', note: 'MotionBuilder, Maya, Daz' }, in: { label: 'Inches', note: '' },
};

/** What the dialog starts with. @returns {Options} */
export function usualOptions() {
  const keys = server.keys?.frames ?? [];
  return {
    what: 'film', view: 'main', size: 'own', style: /** @type {Options['style']} */ (server.view?.mode ?? 'both'),
    first: String(keys[0] ?? 0), last: String(keys.at(-1) ?? 0), fps: '', frames: 'keyframes', background: 'video',
    columns: '', format: 'all', filter: ui.filterMotion ? String(FILTER_HZ) : '', rig: 'keypose', unit: 'm', fromZero: false,
  };
}

/**
 * The order that the server takes. eye: azimuth and elevation of the free view, where that is wanted.
 * @param {Options} options
 * @param {{ opacity?: number, tint?: string, frame: number, eye: { azimuth: number, elevation: number } | null }} at
 */
export function orderOf(options, { opacity = 0.5, tint = 'clay', frame: now, eye }) {
  const { what, style, columns, fps, view } = options;
  const drawn = { what, style, opacity, tint };
  if (what === 'sheet') return { ...drawn, columns: columns === '' ? null : Number(columns) };
  const looks = view === 'free' && eye ? { view: 'camera', azimuth: eye.azimuth, elevation: eye.elevation } : { view };
  const size = options.size === 'own' ? null : options.size.split('x').map(Number);
  if (what === 'pictures') {
    const frames = options.frames === 'this' ? now : options.frames;
    return { ...drawn, ...looks, size, frames, background: options.background };
  }
  return { ...drawn, ...looks, size, frames: rangeOf(options), fps: fps === '' ? null : Number(fps) };
}

/** The address of the motion that is chosen. @param {Options} options */
export function motionAddress({ format, filter, fps, first, last, rig, unit, fromZero }) {
  const query = new URLSearchParams({ format });
  if (filter !== '') query.set('filter_hz', filter);
  if (fps !== '') query.set('fps', fps);
  if (rig !== 'keypose') query.set('rig', rig);
  if (unit !== 'm') query.set('unit', unit);
  if (fromZero) query.set('from_zero', 'true');
  query.set('first', first);
  query.set('last', last);
  return `/motion?${query}`;
}

/**
 * What is wrong with the options, a sentence, or ''.
 * @param {Options} options
 * @param {number} count  Of the video's frames.
 */
export function whyNotExport(options, count) {
  const { what, first, last, fps, filter, columns } = options;
  const asks = (/** @type {string[]} */ ...kinds) => kinds.includes(what);
  const isWhole = (text) => /^\d{1,9}$/.test(text);
  if (asks('film', 'motion')) {
    if (!isWhole(first) || !isWhole(last) || Number(first) > Number(last)) return 'The frames are two numbers, the first one not after the last.';
    if (Number(last) >= count) return `The last frame of the video is ${count - 1}.`;
    if (fps !== '' && !(Number(fps) >= 0.1 && Number(fps) <= 1000)) return 'The rate is a number from 0.1 to 1000 frames a second.';
  }
  if (asks('motion') && filter !== '' && !(Number(filter) > 0 && Number(filter) <= 1000)) return 'The filter is a number of hertz, such as 6.';
  if (asks('sheet') && columns !== '' && !(isWhole(columns) && Number(columns) >= 1 && Number(columns) <= 100)) return 'Columns are from 1 to 100.';
  return '';
}

const rangeOf = ({ first, last }) => [Number(first), Number(last)];

/**
 * Why a format of motion cannot be written here, with what mends it, or ''.
 * @param {{ label: unknown, needs?: string }} kind  An entry of MOTION.
 */
export function notInstalled({ label, needs }) {
  const remedy = ui.exportMissing?.[String(label).toLowerCase()];
  return remedy ? `${label} needs ${needs}: ${remedy}` : '';
}

/** Ask which formats cannot be written here, and what mends that. */
export async function askWhatIsMissing() {
  try {
    const response = await fetchOk('/exports');
    setUi('exportMissing', (await response.json()).missing);
  } catch {
    // Nobody answers: then nothing can be exported either, which is said when it is tried.
  }
}

/** Export what is chosen in the dialog. */
export async function beginExport() {
  const { exporting } = ui;
  if (!exporting || ui.exportJob) return;
  if (exporting.what === 'motion') {
    setUi('exporting', null);
    await saveFrom(motionAddress(exporting), `${server.file.name}.zip`);
    return;
  }
  const { opacity, tint } = server.view;
  const eye = exporting.view === 'free' ? viewNamed('free').state : null;
  const order = orderOf(exporting, { opacity, tint: server.surface ? tint : 'clay', frame: frame(), eye });
  const begun = { id: '', what: exporting.what, done: 0, of: 0 };
  const isMine = (id) => ui.exportJob === begun || (id !== '' && ui.exportJob?.id === id);
  let id = '';
  setUi('exportJob', begun);
  try {
    const response = await fetchOk('/exports', { method: 'POST', body: JSON.stringify(order) });
    ({ id } = await response.json());
    if (!isMine(id)) return void end(id); // cancelled before it had a number
    setUi('exportJob', { ...begun, id });
    await follow(id);
  } catch (error) {
    if (!isMine(id)) return; // cancelled meanwhile
    finish();
    toast({ kind: 'check', words: 'Nothing was saved.', detail: error.message });
  }
}

/** Look how far it is until it is done; then save the file. */
async function follow(id) {
  let missed = 0;
  while (ui.exportJob?.id === id) {
    const state = await stateOf(id);
    missed = state ? 0 : missed + 1;
    if (missed > PATIENCE) throw new Error('The connection was lost on the way.');
    if (ui.exportJob?.id !== id) return; // cancelled meanwhile
    if (state?.state === 'failed') throw new Error(state.words);
    if (state?.state === 'cancelled') return finish();
    if (state?.state === 'done') return fetchFile(id, state.words);
    if (state) setUi('exportJob', { ...ui.exportJob, done: state.done, of: state.of });
    await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
  }
}

async function stateOf(id) {
  try {
    const response = await fetchOwn(`/exports/${id}`);
    if (response.status === 404) return { state: 'failed', words: 'Keypose was restarted meanwhile. Export again.' };
    return response.ok ? await response.json() : null;
  } catch {
    return null; // the line is down for a moment
  }
}

async function fetchFile(id, words) {
  const response = await fetchOk(`/exports/${id}/file`);
  if (ui.exportJob?.id !== id) return; // cancelled meanwhile
  const name = await saveAs(response, `${server.file?.name ?? 'export'}`);
  finish();
  setUi('exporting', null);
  toast({ kind: 'good', words: `Saved as ${name}.`, ...(words ? { detail: words } : {}) });
}

/** Stop the export that is under way. */
export async function cancelExport() {
  const { exportJob } = ui;
  finish();
  if (exportJob?.id) await end(exportJob.id); // one without a number yet is ended when it has one
}

async function end(id) {
  try {
    await fetchOwn(`/exports/${id}`, { method: 'DELETE' });
    toast({ kind: 'info', words: 'Export cancelled.' });
  } catch {
    // Nobody answers: it ends with the server, or with the next export.
  }
}

const finish = () => setUi('exportJob', null);
