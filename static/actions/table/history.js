// Steps undone and done again.

import { toggleMenu } from '../../controls/menu.js';
import { server } from '../../store/state.js';
import { goToStep, noHistory } from '../history.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const HISTORY = {
  undo: {
    also: 'revert back mistake take back',
    label: () => stepLabel('Undo', server.undo?.undo), icon: 'undo', keys: ['Ctrl Z'], row: 'Undo, redo', repeats: true,
    off: () => (server.undo?.undo ? '' : 'Nothing to undo'), message: () => ({ do: 'undo' }),
  },
  history: {
    also: 'undo list steps versions earlier changes log revert',
    label: 'History', icon: 'old', title: 'All steps that can be undone or redone', off: noHistory,
    run: () => toggleMenu('history'),
  },
  goToStep: { label: 'Go to this step', icon: 'old', run: goToStep },
  redo: {
    also: 'again forward repeat',
    label: () => stepLabel('Redo', server.undo?.redo), icon: 'redo', keys: ['Ctrl Shift Z'], aliases: ['Ctrl Y'],
    row: 'Undo, redo', repeats: true,
    off: () => (server.undo?.redo ? '' : 'Nothing to redo'), message: () => ({ do: 'redo' }),
  },
};

const stepLabel = (word, what) => (what ? `${word} ${what}` : word);
