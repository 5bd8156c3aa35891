// Bringing a video from elsewhere into Keypose's folder: chosen, or dropped on the window.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { whyNot } from '../actions/actions.js';
import { importFile, importOpenPose, isImported, isOpenPose } from '../actions/importing.js';
import { addOnTop } from '../controls/focus.js';
import { icon } from '../controls/icons.js';
import { progressBar } from '../controls/progress_bar.js';
import { toast } from '../controls/toasts.js';
import { bytes } from '../controls/words.js';
import { keyHeader } from '../store/storage.js';
import { isVideoName } from '../store/library.js';
import { send } from '../store/link.js';
import { server, setUi, ui, watch } from '../store/state.js';

const KINDS = 'MP4, MOV, MKV, WebM, AVI, TS, MPG and the like';

let request = null;

/**
 * Take what was dropped or chosen: one video, or one file to import into the open session.
 * @param {File[]} files
 * @param {boolean} isAdded  Whether the video is added to the open session as another film of its motion.
 */
export function takeFiles(files, isAdded = false) {
  const video = files.find(({ name }) => isVideoName(name));
  if (!video) {
    if (server.file && files[0] && isImported(files[0].name)) importFirst(files);
    else refuse(files[0]);
    return;
  }
  if (request) {
    toast({ kind: 'check', words: `${ui.upload.name} is still being copied. Cancel it first.` });
    return;
  }
  if (files.length > 1) {
    toast({ kind: 'info', words: `One video at a time. ${isAdded ? 'Adding' : 'Opening'} ${video.name}.` });
  }
  const most = ui.library?.largest_upload;
  if (most && video.size > most) tooLarge(video, most);
  else upload(video, isAdded);
}

/** Stop the copying. */
function cancelUpload() {
  if (!request) return false;
  request.abort();
  return true;
}

/** "Copying jump.mp4 · 12 of 48 MB" with a line and Cancel, or nothing. */
export function uploadCard() {
  if (!ui.upload) return nothing;
  const { name, loaded, total } = ui.upload;
  const percent = total ? (100 * loaded) / total : 0;
  const isOver = loaded >= total;
  const copied = isOver ? '' : `${bytes(loaded)} of ${bytes(total)}`;
  return html`<div class="job upload">
    <span class="spin">${icon('run')}</span><b class="cut">${isOver ? 'Opening' : 'Copying'} ${name}</b>
    <span class="mut num">${copied}</span>
    <button class="btn ghost sm" @click=${cancelUpload}>Cancel</button>
    ${progressBar(`Copying ${name}`, percent, copied)}
  </div>`;
}

function upload(file, isAdded) {
  request = new XMLHttpRequest();
  const finish = (words) => {
    request = null;
    setUi('upload', null);
    if (words) toast({ kind: 'lost', words });
  };
  request.upload.onprogress = ({ loaded, total }) => setUi('upload', { name: file.name, loaded, total });
  request.onload = () => finish(openUploaded(request, file, isAdded));
  request.onerror = () => finish(`${file.name} was not copied. The connection was lost on the way.`);
  request.onabort = () => finish('');
  request.open('POST', `/upload?name=${encodeURIComponent(file.name)}`);
  for (const [name, value] of Object.entries(keyHeader())) request.setRequestHeader(name, value);
  request.send(file);
  setUi('upload', { name: file.name, loaded: 0, total: file.size });
}

/** Open or add what has arrived; otherwise the words of the refusal. */
function openUploaded({ status, response }, file, isAdded) {
  let reply = {};
  try {
    reply = JSON.parse(response);
  } catch {
    // An answer of the door, not of the library.
  }
  if (status < 300 && reply.id) {
    send({ do: isAdded ? 'add_film' : 'open', kind: 'upload', id: reply.id });
    return '';
  }
  return reply.words || `${file.name} was not copied. The server answered ${status}.`;
}

/** One file, or OpenPose's, which are one for each frame. */
function importFirst(files) {
  if (files.length > 1 && files.every(isOpenPose)) {
    importOpenPose(files[0].name.replace(/_?\d+(_keypoints)?\.json$/, ''), files);
    return;
  }
  if (files.length > 1) toast({ kind: 'info', words: `One file at a time. Importing ${files[0].name}.` });
  importFile(files[0]);
}

function refuse(file) {
  if (file) toast({ kind: 'check', words: whyNotVideo(file.name) });
}

/** What to do with a file that is no video, by its name.
 * @param {string} name */
export function whyNotVideo(name) {
  if (name.toLowerCase().endsWith('.json')) {
    return `${name} is opened where it lies. Its video and its motion lie beside it: Open a session…`;
  }
  if (isImported(name)) return `${name} is not a video. Open the video first, then drop it here again to import it.`;
  return `${name} is not a video. Keypose opens ${KINDS}.`;
}

function tooLarge({ name, size }, most) {
  const words = `${name} is too large to copy. It has ${bytes(size)}, ${bytes(most)} are allowed: put it into a folder that Keypose sees, then Choose a video…`;
  toast({ kind: 'check', words });
}

export function mountDropping() {
  const place = addOnTop('drop', 'div');
  watch(['file', 'u:dropping', 'u:upload'], () => render(overlay(), place));
  addEventListener('dragenter', over);
  addEventListener('dragover', over);
  addEventListener('dragleave', (event) => event.relatedTarget === null && setUi('dropping', false));
  addEventListener('drop', onDrop);
}

/** On the start screen the drop zone itself answers. */
function overlay() {
  if (!server.file) return nothing;
  if (ui.upload) return html`<div class="copying">${uploadCard()}</div>`;
  if (!ui.dropping) return nothing;
  return html`<div class="veil"><div>Drop a video to open it, or motion, keypoints or a camera to import
    them into ${server.file.name}.</div>${
      whyNot('addFilm')
        ? nothing
        : html`<div class=${ui.dropping === 'add' ? 'over' : ''} data-drop="add">Drop a film of the same motion here
    to add it to ${server.file.name}.</div>`
    }</div>`;
}

function over(event) {
  if (!hasFiles(event)) return;
  event.preventDefault();
  event.dataTransfer.dropEffect = 'copy';
  setUi('dropping', isOverAdding(event) ? 'add' : true);
}

/** Whether a film that is dropped there is added to the open session. */
function isOverAdding({ clientX: x, clientY: y }) {
  const box = document.querySelector('#drop [data-drop="add"]')?.getBoundingClientRect();
  return Boolean(box && x > box.left && x < box.right && y > box.top && y < box.bottom);
}

function onDrop(event) {
  if (!hasFiles(event)) return;
  event.preventDefault();
  const isAdded = isOverAdding(event);
  setUi('dropping', false);
  const items = [...event.dataTransfer.items].filter((item) => item.kind === 'file');
  const folder = items.map((item) => item.webkitGetAsEntry?.()).find((entry) => entry?.isDirectory);
  if (folder) {
    if (server.file) openFolder(folder);
    else refuseFolder(folder);
    return;
  }
  takeFiles([...event.dataTransfer.files], isAdded);
}

/** What OpenPose wrote is imported; any other folder is opened where it lies. */
async function openFolder(folder) {
  const files = (await entriesOf(folder)).filter((entry) => entry.isFile && isOpenPose(entry));
  if (!files.length) {
    refuseFolder(folder);
    return;
  }
  const read = files.map((entry) => new Promise((resolve, reject) => entry.file(resolve, reject)));
  importOpenPose(folder.name, await Promise.all(read));
}

/** All that lies in a folder; a browser gives it piece by piece. */
async function entriesOf(folder) {
  const reader = folder.createReader();
  const found = [];
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) return found;
    found.push(...some);
  }
}

function refuseFolder({ name }) {
  const words = `${name} is a folder. A folder of images or meshes is opened where it lies: choose it in the list.`;
  toast({ kind: 'check', words });
}

const hasFiles = (event) => event.dataTransfer?.types.includes('Files') ?? false;
