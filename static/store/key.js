// The key this browser was given for this page's origin. Cookies go to every server on this host,
// whatever its port; what is stored for the origin stays here.

import { inBrowser } from './storage.js';

const NAME = 'keypose.key';

/** The newest: another tab may have been let in anew. */
function key() {
  return inBrowser.read(NAME) ?? ''; // without one this browser is not let in
}

/** Fetch from this page's own server. */
export function fetchOwn(path, options = {}) {
  return fetch(path, { ...options, headers: { ...options.headers, ...keyHeader() } });
}

/** Whether it has one: a browser whose stored data was cleared has not. */
export const hasKey = () => key() !== '';

export const keyHeader = () => ({ 'X-Keypose-Key': key() });

/** The subprotocols of the line of events: a page can give a socket no header. */
export const keyProtocols = () => ['keypose', `keypose-key.${key()}`];
