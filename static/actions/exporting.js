// Pictures, motion and films out of the page: saved as files, copied, or made by a job.

import { orderOf, usualOf, whyNotOrder } from '../controls/order_form.js';
import { toast } from '../controls/toasts.js';
import { count, joined } from '../controls/words.js';
import { bodies } from '../store/bodies.js';
import { chosenFrames, isSurface, lastFrame } from '../store/clip.js';
import { EXPORTS, FORMATS } from '../store/orders.js';
import { fetchOwn } from '../store/storage.js';
import { server, setUi, ui } from '../store/state.js';
import { view as viewNamed } from '../views/views.js';
import { follow, leave } from './following.js';
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

/** First and last frame that are exported: from the first keyframe to the last, of these what lies between the
 * in and the out point. @returns {[number, number]} */
export function motionFrames() {
  const keys = server.keys?.frames ?? [];
  const [first, last] = [keys[0] ?? 0, keys.at(-1) ?? 0];
  const [from, to] = chosenFrames() ?? [first, last];
  return from > last || to < first ? [from, to] : [Math.max(first, from), Math.min(last, to)];
}

/** Save the motion in a format, such as "bvh", low-pass filtered where that is ticked. */
export function saveMotion(format) {
  const query = new URLSearchParams({ format });
  if (ui.filterMotion) query.set('filter_hz', String(FILTER_HZ));
  if (chosenFrames()) query.set('frames', motionFrames().join('-'));
  return saveFrom(`/motion?${query}`, `${server.file.name}.${format}`, FORMATS[format]?.then);
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
  return `/picture.png?${new URLSearchParams({
    frames: String(frame()),
    ...painted(),
    ...seenFrom(view, viewNamed('free')?.state, 'orbit'),
  })}`;
}

/** Save what the server answers, with what is left to do with it, or say why nothing was saved. */
export async function saveFrom(address, name, then = '') {
  try {
    const response = await fetchOk(address);
    const saved = await saveAs(response, name);
    const leftOut = decodeURIComponent(response.headers.get('x-keypose-left-out') ?? '');
    if (leftOut) toast({ kind: 'check', words: `Saved as ${saved}.`, detail: `Left out: ${leftOut}` });
    else toast({ kind: 'good', words: `Saved as ${saved}.`, ...(then ? { detail: then } : {}) });
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

/** Save what the page has made itself. */
export function saveBlob(blob, name) {
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

/** @typedef {import('../store/shapes.js').Exporting} Exporting */

/** What the dialog starts with. @returns {Exporting} */
export function usualExport() {
  const values = Object.fromEntries(Object.entries(EXPORTS).map(([what, options]) => [what, usualOf(options)]));
  for (const what of ['film', 'motion']) values[what].frames = motionFrames().join('-');
  values.matte.frames = (chosenFrames() ?? [0, lastFrame()]).join('-');
  for (const what of ['film', 'pictures']) values[what].view = viewShown();
  for (const what of ['film', 'pictures', 'sheet']) values[what].style = server.view?.mode ?? 'both';
  if (ui.filterMotion) values.motion.filter_hz = String(FILTER_HZ);
  return { what: 'film', format: 'all', values };
}

/**
 * What is left out of the form, or else than declared, as things stand.
 * @param {Exporting} exporting
 * @returns {Record<string, import('../controls/order_form.js').Further>}
 */
export function furtherOf({ what, format }) {
  const { width, height } = server.file ?? {};
  const keys = server.keys?.frames.length ?? 0;
  const own = { id: '', label: `As the video, ${width} × ${height}` };
  const { options = [] } = EXPORTS[what].find(({ name }) => name === 'view') ?? {};
  /** @type {Record<string, import('../controls/order_form.js').Further>} */
  const further = {
    view: { options: [...options, { id: 'free', label: 'As the free view looks' }] },
    size: { options: [own, ...SIZES.map((id) => ({ id, label: id.replace('x', ' × ') }))] },
  };
  if (what === 'pictures') {
    further.frames = {
      options: [
        { id: 'this', label: `Frame ${frame()}` },
        { id: 'keyframes', label: `All ${count(keys, 'keyframe')}` },
        { id: 'posed', label: 'Every frame' },
      ],
    };
  }
  for (const { name, only, persons, options: choices = [] } of EXPORTS[what]) {
    if (!only) continue;
    const off = persons && !server.body?.is_persons ? 'Only a person has these' : '';
    further[name] = {
      out: (format !== 'all' && !only.includes(format)) || (name === 'together' && bodies().length < 2),
      note: format === 'all' ? `of ${joined(only.map((one) => FORMATS[one].label))}` : '',
      options: choices.map((one, i) => (i && off ? { ...one, off } : one)),
    };
  }
  return further;
}

const SIZES = ['1280x720', '1920x1080', '3840x2160'];

/**
 * The order that the server takes.
 * @param {Exporting} exporting
 * @param {{ azimuth: number, elevation: number }} [eye]  Of the free view.
 * @returns {Record<string, any>}
 */
export function exportOrder(exporting, eye = viewNamed('free')?.state) {
  const { what, values } = exporting;
  const order = { ...orderOf(EXPORTS[what], values[what], furtherOf(exporting)) };
  if (what === 'motion') return order;
  if (what === 'matte') return { what, ...order };
  const frames = order.frames === 'this' ? { frames: String(frame()) } : {};
  return { what, ...painted(), ...order, ...seenFrom(order.view, eye, 'camera'), ...frames };
}

/**
 * A view as the server names it: the free view is a camera that stands where it looks from.
 * @returns {Record<string, string>}
 */
function seenFrom(view, eye, kind) {
  if (view !== 'free') return view ? { view } : {};
  const { azimuth, elevation } = eye;
  return { view: `${kind}:${azimuth.toFixed(2)},${elevation.toFixed(2)}` };
}

/** How the page draws the body, as the options of a picture. @returns {Record<string, string>} */
function painted() {
  const { mode, opacity, tint } = server.view ?? {};
  return {
    ...(mode === undefined ? {} : { style: mode }),
    ...(opacity === undefined ? {} : { opacity: String(Math.round(100 * opacity)) }),
    ...(server.surface && tint !== undefined ? { tint } : {}),
  };
}

/** The address of the motion that is chosen. @param {Exporting} exporting */
export const motionAddress = (exporting) =>
  `/motion?${new URLSearchParams({ format: exporting.format, ...exportOrder(exporting) })}`;

/**
 * What is wrong with what is chosen, a sentence, or ''.
 * @param {Exporting} exporting
 * @param {number} frames  Of the video.
 */
export const whyNotExport = (exporting, frames) =>
  whyNotOrder(EXPORTS[exporting.what], exporting.values[exporting.what], frames, furtherOf(exporting));

/**
 * Why a format of motion cannot be written here, with what mends it, or ''.
 * @param {string} format  A key of FORMATS.
 */
export function notInstalled(format) {
  const { label, needs } = FORMATS[format];
  const remedy = ui.exportMissing?.[format];
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

/** Why the person cannot be cut out of the film, or ''. */
export function whyNoMatte() {
  if (!server.body?.is_persons || isSurface()) return 'Only a person in a video can be cut out';
  return server.keys?.frames.length || server.keys?.drafts.length ? '' : 'Add a keyframe first';
}

/** Export what is chosen in the dialog. */
export async function beginExport() {
  const { exporting } = ui;
  if (!exporting || ui.exportJob) return;
  if (exporting.what === 'motion') {
    setUi('exporting', null);
    await saveFrom(motionAddress(exporting), `${server.file.name}.zip`, FORMATS[exporting.format]?.then);
    return;
  }
  const order = exportOrder(exporting);
  const begun = { id: '', what: exporting.what, done: 0, of: 0 };
  const isMine = (id) => ui.exportJob === begun || (id !== '' && ui.exportJob?.id === id);
  let id = '';
  setUi('exportJob', begun);
  try {
    const response = await fetchOk('/exports', { method: 'POST', body: JSON.stringify(order) });
    ({ id } = await response.json());
    if (!isMine(id)) return void end(id); // cancelled before it had a number
    setUi('exportJob', { ...begun, id });
    const state = await follow(
      `/exports/${id}`,
      () => ui.exportJob?.id === id,
      ({ done, of }) => setUi('exportJob', { ...begun, id, done, of }),
    );
    if (state?.state === 'failed') throw new Error(state.words);
    if (state?.state === 'cancelled') finish();
    if (state?.state === 'done') await fetchFile(id, state.words);
  } catch (error) {
    if (!isMine(id)) return; // cancelled meanwhile
    finish();
    toast({ kind: 'check', words: 'Nothing was saved.', detail: error.message });
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
  if (await leave(`/exports/${id}`)) toast({ kind: 'info', words: 'Export cancelled.' });
}

const finish = () => setUi('exportJob', null);
