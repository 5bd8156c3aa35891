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
  openFile: {
    label: 'Open…', icon: 'folder', run: () => openChooser('any'),
    also: 'load import video session browse', alone: 'Open a video or session…',
  },
  importFile: {
    also: 'bvh c3d trc csv npz amass smpl mocap openpose mediapipe coco sleap deeplabcut chan load motion keypoints camera',
    label: 'Import…', icon: 'up', title: 'Motion, 2D keypoints or a camera from another program', run: chooseImport,
  },
  openRecent: { label: (recent) => recent.name, icon: 'film', message: ({ id }) => ({ do: 'open', kind: 'recent', id }) },
  renameSession: {
    label: 'Rename', icon: 'pen', always: true, off: whichSession, run: ({ id } = server.file) => setUi('renaming', id),
    alone: 'Rename session',
  },
  duplicateSession: {
    alone: 'Duplicate session',
    label: 'Duplicate', icon: 'copy', title: 'A copy for another try on the same video', always: true, off: whichSession,
    message: ({ id } = server.file) => ({ do: 'duplicate_session', id }),
  },
  deleteSession: {
    alone: 'Move session to the trash',
    label: 'Move to the trash', icon: 'trash', title: 'The video stays', always: true, off: whichSession,
    message: ({ id } = server.file) => ({ do: 'delete_session', id }),
  },
  copyPath: { also: 'file location clipboard folder', label: 'Copy path', icon: 'copy', run: copyPath },
  closeFile: {
    label: 'Close', icon: 'x', message: () => ({ do: 'close' }),
    also: 'quit exit start screen home', alone: 'Close the session',
  },
};
