// What can be opened: recent sessions, samples, the files of the server's folders.

import { fetchOwn } from './key.js';
import { listen } from './link.js';
import { setUi, ui } from './state.js';

let loading = null; // until the newest list is here
let isOutdated = false; // what is on its way may be from before the last change
listen('library', loadLibrary); // sessions were renamed, duplicated, deleted or put back

/** Ask the server anew; the answer becomes ui.library. */
export function loadLibrary() {
  isOutdated = true;
  loading ??= fetchUntilCurrent().finally(() => (loading = null));
  return loading;
}

/** Whether a name's ending is one of a video; while none are known, the server will say. */
export function isVideoName(name) {
  return videoSuffixes()?.some((suffix) => name.toLowerCase().endsWith(suffix)) ?? true;
}

/** The endings of all that can be opened, undefined until the server has sent them. */
export function videoSuffixes() {
  return ui.library?.suffixes;
}

async function fetchUntilCurrent() {
  while (isOutdated) {
    isOutdated = false;
    await fetchLibrary();
  }
}

async function fetchLibrary() {
  try {
    const response = await fetchOwn('/library');
    if (response.ok) setUi('library', await response.json());
  } catch {
    // The line is down; the status bar says so, and the next opening asks again.
  }
}
