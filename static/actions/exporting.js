// Pictures, motion and films out of the page: saved as files, copied, or made by a job.

import { toast } from '../controls/toasts.js';
import { fetchOwn } from '../store/storage.js';
import { server, setUi, ui } from '../store/state.js';
import { view as viewNamed } from '../views/views.js';
import { frame } from './playhead.js';

const PICTURED = ['main', 'top', 'side', 'front', 'free'];

/** The view in the large place, which "this view" means; all four side by side: the camera. */
export const viewShown = () => (PICTURED.includes(ui.layout) ? ui.layout : 'main');

/** Save a picture of one view, or of all, as a PNG file. */
export async function savePicture(view = viewShown()) {
  const kind = view === 'main' ? '' : `-${view === 'all' ? 'views' : view}`;
  await saveFrom(pictureAddress(view), `${server.file.name}-frame${frame()}${kind}.png`);
}

/** Put a picture of this view on the clipboard. */
export async function copyPicture() {
  if (!navigator.clipboard?.write || !window.ClipboardItem) {
    toast({ kind: 'check', words: 'This browser cannot copy images.', detail: 'Save it with Shift E.' });
    return;
  }
  try {
    // The promise is handed over, not awaited: the permission lasts as long as the key press.
    const picture = fetchBlob(pictureAddress(viewShown()));
    await navigator.clipboard.write([new ClipboardItem({ 'image/png': picture })]);
    toast({ kind: 'good', words: `Image of frame ${frame()} copied.` });
  } catch (error) {
    toast({ kind: 'check', words: 'Image not copied.', detail: sentence(error.message) });
  }
}

const TRACKED = ['good', 'check', 'lost', 'outdated', 'tracking'];

/** Whether there is any motion to save. */
export const hasMotion = () => (server.segments ?? []).some((s) => TRACKED.includes(s.state));

/** The cut-off that is usual for how people move. */
export const FILTER_HZ = 6;

/** Save the motion in a format, such as "bvh", low-pass filtered where that is ticked. */
export function saveMotion(format) {
  const query = new URLSearchParams({ format });
  if (ui.filterMotion) query.set('filter_hz', String(FILTER_HZ));
  return saveFrom(`/motion?${query}`, `${server.file.name}.${format}`);
}

/** Save the report: verdicts, charts and pictures in one page that needs no other. */
export const saveReport = () => saveFrom('/report.html', `${server.file.name}-report.html`);

/** Where the session lies, on the clipboard; shown where there is none. */
export async function copyPath() {
  try {
    await navigator.clipboard.writeText(server.file.path);
    toast({ kind: 'good', words: 'Path copied.' });
  } catch {
    toast({ kind: 'info', words: server.file.path });
  }
}

function pictureAddress(view) {
  const { mode, opacity, tint } = server.view;
  const query = new URLSearchParams({ view, frame: frame() });
  if (view === 'free') {
    const { azimuth, elevation } = viewNamed('free').state;
    query.set('azimuth', azimuth.toFixed(2));
    query.set('elevation', elevation.toFixed(2));
  }
  if (mode !== undefined) query.set('mode', mode);
  if (opacity !== undefined) query.set('opacity', String(opacity));
  if (server.surface && tint !== undefined) query.set('tint', tint);
  return `/picture.png?${query}`;
}

/** Save what the server answers, or say why nothing was saved. */
export async function saveFrom(address, name) {
  try {
    const response = await fetchOk(address);
    const saved = await saveAs(response, name);
    const leftOut = decodeURIComponent(response.headers.get('x-keypose-left-out') ?? '');
    if (leftOut) toast({ kind: 'check', words: `Saved as ${saved}.`, detail: `Left out: ${leftOut}` });
    else toast({ kind: 'good', words: `Saved as ${saved}.` });
  } catch (error) {
    toast({ kind: 'check', words: 'Nothing was saved.', detail: sentence(error.message) });
  }
}

/** Save an answer as a file under the name it says, else under this one; the name. */
export async function saveAs(response, name) {
  const saved = nameIn(response) ?? name;
  saveBlob(await response.blob(), saved);
  return saved;
}

const fetchBlob = async (address) => (await fetchOk(address)).blob();

/** What the server answers; an error in its words where it refuses. */
export async function fetchOk(address, options = {}) {
  const response = await fetchOwn(address, options);
  if (response.ok) return response;
  const words = (await response.text()).slice(0, 300).trim();
  let problem;
  try {
    problem = JSON.parse(words).words;
  } catch {
    problem = words.startsWith('<') ? '' : words;
  }
  throw new Error(problem || `The server answered ${response.status}`);
}

function saveBlob(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The browser reads the address after the click has returned.
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

function nameIn(response) {
  const header = response.headers.get('content-disposition') ?? '';
  const exact = header.match(/filename\*=UTF-8''([^;]+)/i)?.[1];
  return exact ? decodeURIComponent(exact) : header.match(/filename="([^"]+)"/i)?.[1];
}

const sentence = (words) => (/[.?!]$/.test(words) ? words : `${words}.`);

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
