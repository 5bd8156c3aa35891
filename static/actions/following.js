// Work that takes the server a while, an export or an import: followed until it is over.

import { fetchOwn } from '../store/storage.js';

const LOOK_MS = 300;
const PATIENCE = 20; // looks in a row without an answer, before it is given up

/**
 * Look how far it is until it is over: its last state, or null once nobody wants it any more.
 * @param {string} address
 * @param {() => boolean} isWanted
 * @param {(state: Record<string, any>) => void} show
 */
export async function follow(address, isWanted, show) {
  let missed = 0;
  while (isWanted()) {
    const state = await stateAt(address);
    if (!isWanted()) break;
    missed = state ? 0 : missed + 1;
    if (missed > PATIENCE) throw new Error('The connection was lost on the way.');
    if (state && state.state !== 'running') return state;
    if (state) show(state);
    await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
  }
  return null;
}

async function stateAt(address) {
  try {
    const response = await fetchOwn(address);
    if (response.status === 404) return { state: 'failed', words: 'Keypose was restarted meanwhile. Begin again.' };
    return response.ok ? await response.json() : null;
  } catch {
    return null; // the line is down for a moment
  }
}

/** End it, and let the server forget its files; whether the server has heard it. */
export async function leave(address) {
  try {
    await fetchOwn(address, { method: 'DELETE' });
    return true;
  } catch {
    return false; // it ends with the server, or with the next of its kind
  }
}
