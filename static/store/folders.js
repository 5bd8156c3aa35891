// The folder that the file chooser stands in, of those that Keypose may look into.

import { fetchOwn } from './key.js';
import { setUi } from './state.js';
import { inBrowser } from './storage.js';

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
