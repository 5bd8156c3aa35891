// The whole window accepts a video, at any time.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop } from '../controls/elements.js';
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
    const words = `${folder.name} is a folder. A folder of images or meshes is opened where it lies: choose it in the list.`;
    toast({ kind: 'check', words });
    return;
  }
  takeFiles([...event.dataTransfer.files]);
}

const hasFiles = (event) => event.dataTransfer?.types.includes('Files') ?? false;
