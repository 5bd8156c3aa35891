// Where the network sees the person, over the picture: fetched once the picture rests.

import { toast } from '../controls/toasts.js';
import { isSurface } from '../store/clip.js';
import { server, ui, watch } from '../store/state.js';
import { fetchOwn } from '../store/storage.js';

const REST_MS = 120;

/** @type {HTMLImageElement} */
let element;
let wanted = '';
let timer = 0;
let last = Promise.resolve();
let isTold = false;

/**
 * Show it in this image; `changed()` when there is another one.
 * @param {HTMLImageElement} image
 * @param {() => void} changed
 */
export function mountPersonMask(image, changed) {
  element = image;
  watch(['u:personMask', 'u:shown', 'u:playing', 'file', 'camera', 'body'], () => follow(changed));
}

function follow(changed) {
  const isWanted =
    ui.personMask && !ui.playing && server.file && server.body?.is_persons && !isSurface() && ui.shown !== undefined;
  const frame = ui.shown;
  if (!ui.personMask) isTold = false;
  const now = isWanted ? `${server.file.path}|${server.camera?.image_version}|${frame}` : '';
  if (now === wanted) return;
  wanted = now;
  clearTimeout(timer);
  delete element.dataset.frame;
  // One after another: each is work for the server, and those left behind are not asked for.
  const ask = () => void (last = last.then(() => load(now, frame, changed)));
  if (now) timer = setTimeout(ask, REST_MS);
}

async function load(asked, frame, changed) {
  if (asked !== wanted) return;
  try {
    const answer = await fetchOwn(`/person/${frame}.png`);
    if (asked !== wanted) return; // another frame is shown by now
    if (!answer.ok) {
      // Why, once: frames without the person may follow one another.
      if (!isTold) toast({ kind: 'check', words: (await answer.text()).trim() });
      isTold = true;
      return;
    }
    const address = URL.createObjectURL(await answer.blob());
    element.src = address;
    await element.decode().finally(() => URL.revokeObjectURL(address));
    if (asked !== wanted) return;
    element.dataset.frame = String(frame);
    changed();
  } catch {
    // The connection is lost, which is said elsewhere.
  }
}
