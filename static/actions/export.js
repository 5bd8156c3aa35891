// Pictures and motion out of the page: saved as files, or copied to the clipboard.

import { fetchOwn } from '../store/key.js';
import { server, ui } from '../store/state.js';
import { frame } from './playhead.js';
import { toast } from '../controls/toasts.js';
import { view as viewNamed } from '../views/views.js';

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
