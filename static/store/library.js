// What can be opened: recent sessions, samples, the files of the server's folders.

import { fetchOwn, inBrowser } from './storage.js';
import { listen } from './link.js';
import { setUi, ui } from './state.js';

const NAME = 'keypose.folder';

let asked = 0;

/** Go where one was the last time, or to the folders there are. */
export async function enterLastFolder() {
  const last = inBrowser.read(NAME) ?? '';
  if (!(last && (await enterFolder(last)))) await enterFolder('');
}

/** Go into a folder, by its id; an only folder is entered at once. Returns whether it is there. */
export async function enterFolder(id) {
  const number = ++asked;
  const listing = await fetchFolder(id);
  if (number !== asked) return true; // one has gone on already
  if (!listing) return false;
  if (!id && listing.folders.length === 1) return enterFolder(listing.folders[0].id);
  setUi('place', listing);
  inBrowser.write(NAME, id);
  return true;
}

async function fetchFolder(id) {
  try {
    const response = await fetchOwn(`/folder?${new URLSearchParams({ at: id })}`);
    return response.ok ? await response.json() : null;
  } catch {
    return null; // the line is down; the status bar says so
  }
}

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
