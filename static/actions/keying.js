// Adding and deleting keyframes, and notes at frames. K only ever adds one; what is deleted can be had
// back at once.

import { toast } from '../controls/toasts.js';
import { lastFrame } from '../store/clip.js';
import { isNewest } from '../store/edits.js';
import { send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';
import { partKeyAt } from './parts.js';
import { draftFrames, frame, goTo, isKey, keyBeside, keyFrames, stopPlaying } from './playhead.js';

/** K: the pose here is this frame's keyframe. Where it is one already, nothing is lost. */
export function addKey() {
  const at = frame();
  if (isKey(at) && !draftFrames().includes(at)) {
    const words = `Frame ${at} is already a keyframe.`;
    toast({ kind: 'info', words, detail: 'Changes to its pose are kept. Delete removes it.' });
  }
  send({ do: 'add_key', frame: at });
}

/** Whether a frame has no keyframe, and its draft is what can be deleted there. */
export const isDraftAlone = (at) => !isKey(at) && !partKeyAt(at) && draftFrames().includes(at);

/** Delete a keyframe, or a draft where there is none; by default the one under the playhead. */
export function deleteKey(at = frame()) {
  const isDraft = isDraftAlone(at);
  const what = isDraft ? 'Draft' : partKeyAt(at) ? 'Part keyframe' : 'Keyframe';
  sayDeleted(send({ do: isDraft ? 'delete_draft' : 'delete_key', frame: at }), `${what} ${at} deleted.`);
}

/** What message n has deleted can be had back at once. */
export function sayDeleted(n, words) {
  toast({ kind: 'info', words, button: { label: 'Undo', run: () => bringBack(n) }, brief: true, edit: n });
}

export const whyNotDelete = (at = frame()) =>
  isKey(at) || partKeyAt(at) || draftFrames().includes(at) ? '' : `Frame ${at} is not a keyframe`;

function bringBack(n) {
  if (isNewest(n)) send({ do: 'undo' });
  else toast({ kind: 'info', words: 'Undo later steps first (Ctrl Z)' });
}

/** The pose of another keyframe goes to the playhead, −1 from the one before, +1 from the one after. */
export const copyKey = (way) => ({ do: 'copy_key', from_frame: keyBeside(way) });

/** Of a keyframe elsewhere: why its pose cannot come to the playhead. */
export function whyNotCopyHere(from = frame()) {
  if (!isKey(from)) return `Frame ${from} is not a keyframe`;
  return from === frame() ? 'It is the frame you are at' : '';
}

/** A copy of a keyframe, to be worked on at once. */
export function duplicateKey(at, to) {
  send({ do: 'duplicate_key', frame: at, to });
  goTo(to);
}

/** Where a copy most likely goes: under the playhead, or half-way to the next key. */
export function placeForCopy(at) {
  if (!isKey(frame())) return frame();
  const after = keyFrames().find((key) => key > at) ?? lastFrame();
  return Math.round((at + after) / 2);
}

/** @typedef {import('../store/shapes.js').Note} Note */

export const LONGEST = 500;
const IN_A_LINE = 48;

/** @returns {Note[]} */
export const allNotes = () => server.notes ?? [];

export const noteAt = (at = frame()) => allNotes().find((note) => note.frame === at);

export const whyNoNote = (at = frame()) => (noteAt(at) ? '' : `Frame ${at} has no note`);

/** The note before (−1) or after (+1) the playhead. */
export function noteBeside(way) {
  const here = frame();
  return way < 0 ? allNotes().findLast((note) => note.frame < here) : allNotes().find((note) => note.frame > here);
}

export function noNote(way) {
  if (noteBeside(way)) return '';
  return allNotes().length ? `There is no note ${way < 0 ? 'before' : 'after'} frame ${frame()}` : 'There are no notes';
}

export function toNote(way) {
  const note = noteBeside(way);
  stopPlaying();
  if (note) goTo(note.frame);
}

/** Open the card that a note is written on. */
export function writeNote(at = frame()) {
  stopPlaying();
  goTo(at);
  setUi('note', at);
}

/** What to send when the card closes with these words, or null where nothing has changed. */
export function noteMessage(at, text) {
  const before = noteAt(at);
  const words = text.trim();
  return before?.text === words ? null : { do: 'set_note', frame: at, text: words };
}

/** A note in one line; a mere flag by its name. */
export function noteAsOneLine({ text }, most = IN_A_LINE) {
  const line = text.replace(/\s+/g, ' ').trim();
  if (!line) return 'Flag';
  return line.length > most ? `${line.slice(0, most - 1).trimEnd()}…` : line;
}

export const isWriting = () => ui.note !== null && ui.note !== undefined;
