// Notes and flags at frames.

import { toggleSearch } from '../../controls/dialogs.js';
import { server } from '../../store/state.js';
import { noNote, noteAt, toNote, whyNoNote, writeNote } from '../notes.js';
import { frame } from '../playhead.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const NOTES = {
  note: {
    also: 'comment annotate annotation marker bookmark label flag remark todo',
    label: (at) => (noteAt(at) ? 'Edit note' : 'Add note'), icon: 'note', keys: ['Shift M'], row: 'Note at this frame', run: writeNote,
    title: (at) => (noteAt(at) ? 'Edit the note at this frame' : 'Write a note at this frame, or leave a flag'),
  },
  deleteNote: {
    also: 'remove comment marker flag',
    label: 'Delete note', icon: 'trash', off: whyNoNote,
    message: (at = frame()) => ({ do: 'delete_note', frame: at }),
  },
  notes: {
    label: 'All notes', icon: 'note', off: () => (server.notes?.length ? '' : 'There are no notes'), run: () => toggleSearch('Note'),
  },
  previousNote: {
    also: 'comment marker bookmark flag back',
    label: 'Previous note', icon: 'flag', keys: ['Shift H'], row: 'Previous, next note', repeats: true,
    off: () => noNote(-1), run: () => toNote(-1),
  },
  nextNote: {
    also: 'comment marker bookmark flag forward',
    label: 'Next note', icon: 'flag', keys: ['H'], row: 'Previous, next note', repeats: true,
    off: () => noNote(1), run: () => toNote(1),
  },
};
