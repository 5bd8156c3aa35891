// Whole sessions, undo and redo, dark and light.

import { openChooser } from '../../controls/dialogs.js';
import { toggleMenu } from '../../controls/menu.js';
import { server, setUi } from '../../store/state.js';
import { copyPath } from '../exporting.js';
import { goToStep, noHistory } from '../history.js';
import { chooseImport } from '../importing.js';
import { chooseTheme, chosenTheme } from '../theme.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const HISTORY = {
  undo: {
    also: 'revert back mistake take back',
    label: () => stepLabel('Undo', server.undo?.undo),
    icon: 'undo',
    keys: ['Ctrl Z'],
    row: 'Undo, redo',
    repeats: true,
    off: () => (server.undo?.undo ? '' : 'Nothing to undo'),
    message: () => ({ do: 'undo' }),
  },
  history: {
    also: 'undo list steps versions earlier changes log revert',
    label: 'History',
    icon: 'old',
    title: 'All steps that can be undone or redone',
    off: noHistory,
    run: () => toggleMenu('history'),
  },
  goToStep: { label: 'Go to this step', icon: 'old', run: goToStep },
  redo: {
    also: 'again forward repeat',
    label: () => stepLabel('Redo', server.undo?.redo),
    icon: 'redo',
    keys: ['Ctrl Shift Z'],
    aliases: ['Ctrl Y'],
    row: 'Undo, redo',
    repeats: true,
    off: () => (server.undo?.redo ? '' : 'Nothing to redo'),
    message: () => ({ do: 'redo' }),
  },
};

const stepLabel = (word, what) => (what ? `${word} ${what}` : word);

/** Why nothing can be done with a whole session: none is open, and none is meant. */
const whichSession = (session = server.file) => (session ? '' : 'Open a session first');

/** @satisfies {Record<string, Action>} */
export const SESSION = {
  openFile: {
    label: 'Open…',
    icon: 'folder',
    run: () => openChooser('any'),
    also: 'load import video session browse',
    alone: 'Open a video or session…',
  },
  importFile: {
    also: 'bvh c3d trc csv npz amass smpl mocap openpose mediapipe coco sleap deeplabcut chan load motion keypoints camera',
    label: 'Import…',
    icon: 'up',
    title: 'Motion, 2D keypoints or a camera from another program',
    run: chooseImport,
  },
  openRecent: {
    label: (recent) => recent.name,
    icon: 'film',
    message: ({ id }) => ({ do: 'open', kind: 'recent', id }),
  },
  renameSession: {
    label: 'Rename',
    icon: 'pen',
    always: true,
    off: whichSession,
    run: ({ id } = server.file) => setUi('renaming', id),
    alone: 'Rename session',
  },
  duplicateSession: {
    alone: 'Duplicate session',
    label: 'Duplicate',
    icon: 'copy',
    title: 'A copy for another try on the same video',
    always: true,
    off: whichSession,
    message: ({ id } = server.file) => ({ do: 'duplicate_session', id }),
  },
  deleteSession: {
    alone: 'Move session to the trash',
    label: 'Move to the trash',
    icon: 'trash',
    title: 'The video stays',
    always: true,
    off: whichSession,
    message: ({ id } = server.file) => ({ do: 'delete_session', id }),
  },
  copyPath: { also: 'file location clipboard folder', label: 'Copy path', icon: 'copy', run: copyPath },
  closeFile: {
    label: 'Close',
    icon: 'x',
    message: () => ({ do: 'close' }),
    also: 'quit exit start screen home',
    alone: 'Close the session',
  },
};

/** @satisfies {Record<string, Action>} */
export const THEME = {
  darkTheme: { ...theme('dark', 'Dark', 'moon'), also: 'appearance night mode colours colors', alone: 'Dark theme' },
  lightTheme: { ...theme('light', 'Light', 'sun'), also: 'appearance day mode colours colors', alone: 'Light theme' },
  systemTheme: {
    ...theme('auto', 'System', 'both'),
    also: 'appearance auto mode colours colors',
    alone: 'System theme',
  },
};

function theme(name, label, icon) {
  return { label, icon, always: true, on: () => chosenTheme() === name, run: () => chooseTheme(name) };
}
