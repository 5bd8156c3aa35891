// Notes at frames: which is where, writing one, going from one to the next.

import { setUi, server, ui } from '../store/state.js';
import { frame, goTo, stopPlaying } from './playhead.js';

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
  return way < 0
    ? allNotes().findLast((note) => note.frame < here)
    : allNotes().find((note) => note.frame > here);
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
export function noteLine({ text }, most = IN_A_LINE) {
  const line = text.replace(/\s+/g, ' ').trim();
  if (!line) return 'Flag';
  return line.length > most ? `${line.slice(0, most - 1).trimEnd()}…` : line;
}

export const isWriting = () => ui.note !== null && ui.note !== undefined;
