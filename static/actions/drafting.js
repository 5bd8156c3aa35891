// Poses for every frame from a box around the person on one of them: whether it can begin, and why not.

import { server, ui } from '../store/state.js';
import { frame } from './playhead.js';

/** A person of fewer pixels has joints that are hard to tell apart. */
export const SMALL_PX = 60;

/** Why this body cannot be drafted, or ''. */
export const whyNotDraftable = () => (server.body?.is_persons ? '' : 'Needs a person’s body');

export const whyNotDraft = () => whyNotDraftable() || (ui.box ? '' : 'Draw a box around the person first');

/** What is sent: the box as it lies over the frame of the playhead. */
export function draftMessage() {
  return { do: 'draft', frame: frame(), box: ui.box.map((side) => Math.round(10 * side) / 10) };
}

/** What to say of a box around somebody small, or ''. */
export function smallWords() {
  const height = ui.box ? Math.round(ui.box[3] - ui.box[1]) : SMALL_PX;
  return height < SMALL_PX ? `The person is small here (${height} px). Choose a nearer frame if there is one.` : '';
}
