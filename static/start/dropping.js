// The whole window accepts a video, at any time.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop } from '../controls/elements.js';
import { importOpenPose, isOpenPose } from '../actions/importing.js';
import { server, ui, setUi, watch } from '../store/state.js';
import { toast } from '../controls/toasts.js';
import { takeFiles, uploadCard } from './uploading.js';

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
  return html`<div class="veil"><div>Drop a video to open it, or motion, keypoints or a camera to import them into ${server.file.name}.</div></div>`;
}

function over(event) {
  if (!hasFiles(event)) return;
  event.preventDefault();
  event.dataTransfer.dropEffect = 'copy';
  setUi('dropping', true);
}

function onDrop(event) {
  if (!hasFiles(event)) return;
  event.preventDefault();
  setUi('dropping', false);
  const items = [...event.dataTransfer.items].filter((item) => item.kind === 'file');
  const folder = items.map((item) => item.webkitGetAsEntry?.()).find((entry) => entry?.isDirectory);
  if (folder) {
    if (server.file) openFolder(folder);
    else refuseFolder(folder);
    return;
  }
  takeFiles([...event.dataTransfer.files]);
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
