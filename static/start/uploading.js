// Bringing a video from elsewhere on the computer into Keypose's folder, with progress and Cancel.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { importFile, importOpenPose, isImported, isOpenPose } from '../actions/importing.js';
import { icon } from '../controls/icons.js';
import { keyHeader } from '../store/key.js';
import { send } from '../store/link.js';
import { server, ui, setUi } from '../store/state.js';
import { toast } from '../controls/toasts.js';
import { bytes } from '../controls/words.js';
import { isVideoName } from '../store/library.js';

const KINDS = 'MP4, MOV, MKV, WebM, AVI, TS, MPG and the like';

let request = null;

/** Take what was dropped or chosen: one video, or one file to import into the open session. */
export function takeFiles(files) {
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
  if (files.length > 1) toast({ kind: 'info', words: `One video at a time. Opening ${video.name}.` });
  const most = ui.library?.largest_upload;
  if (most && video.size > most) tooLarge(video, most);
  else upload(video);
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
  return html`<div
    class="job upload"
    role="progressbar"
    aria-label="Copying ${name}"
    aria-valuenow=${Math.round(percent)}
  >
    <span class="spin">${icon('run')}</span><b class="cut">${isOver ? 'Opening' : 'Copying'} ${name}</b>
    <span class="mut num">${isOver ? '' : `${bytes(loaded)} of ${bytes(total)}`}</span>
    <button class="btn ghost sm" @click=${cancelUpload}>Cancel</button>
    <span class="bar" style="width:${percent.toFixed(1)}%"></span>
  </div>`;
}

function upload(file) {
  request = new XMLHttpRequest();
  const finish = (words) => {
    request = null;
    setUi('upload', null);
    if (words) toast({ kind: 'lost', words });
  };
  request.upload.onprogress = ({ loaded, total }) => setUi('upload', { name: file.name, loaded, total });
  request.onload = () => finish(openUploaded(request, file));
  request.onerror = () => finish(`${file.name} was not copied. The connection was lost on the way.`);
  request.onabort = () => finish('');
  request.open('POST', `/upload?name=${encodeURIComponent(file.name)}`);
  for (const [name, value] of Object.entries(keyHeader())) request.setRequestHeader(name, value);
  request.send(file);
  setUi('upload', { name: file.name, loaded: 0, total: file.size });
}

/** Open what has arrived; otherwise the words of the refusal. */
function openUploaded({ status, response }, file) {
  let reply = {};
  try {
    reply = JSON.parse(response);
  } catch {
    // An answer of the door, not of the library.
  }
  if (status < 300 && reply.id) {
    send({ do: 'open', kind: 'upload', id: reply.id });
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
