// Whole sessions: opened, renamed, duplicated, deleted, closed; files brought to one.

import { openChooser } from '../../controls/dialogs.js';
import { server, setUi } from '../../store/state.js';
import { copyPath } from '../export.js';
import { chooseImport } from '../importing.js';

/** @typedef {import('./action.js').Action} Action */

/** Why nothing can be done with a whole session: none is open, and none is meant. */
const whichSession = (session = server.file) => (session ? '' : 'Open a session first');

/** @satisfies {Record<string, Action>} */
export const SESSION = {
  openFile: { label: 'Open…', icon: 'folder', run: () => openChooser('any') },
  importFile: {
    label: 'Import…', icon: 'up', title: 'Motion, 2D keypoints or a camera from another program', run: chooseImport,
  },
  openRecent: { label: (recent) => recent.name, icon: 'film', message: ({ id }) => ({ do: 'open', kind: 'recent', id }) },
  renameSession: { label: 'Rename', icon: 'pen', always: true, off: whichSession, run: ({ id } = server.file) => setUi('renaming', id) },
  duplicateSession: {
    label: 'Duplicate', icon: 'copy', title: 'A copy for another try on the same video', always: true, off: whichSession,
    message: ({ id } = server.file) => ({ do: 'duplicate_session', id }),
  },
  deleteSession: {
    label: 'Move to the trash', icon: 'trash', title: 'Kept there for 30 days. The video stays', always: true, off: whichSession,
    message: ({ id } = server.file) => ({ do: 'delete_session', id }),
  },
  copyPath: { label: 'Copy path', icon: 'copy', run: copyPath },
  closeFile: { label: 'Close', icon: 'x', message: () => ({ do: 'close' }) },
};
