// Poses for every frame from a box around the person on one of them: whether it can begin, why not, and
// what to say of its result.

import { server, ui } from '../store/state.js';
import { count } from '../controls/words.js';
import { frame, placesToConfirm } from './playhead.js';

/** A person of fewer pixels has joints that are hard to tell apart. */
export const SMALL_PX = 60;

/** Why this body cannot be drafted, or ''. */
export const whyNotDraftable = () => (server.body?.is_persons ? '' : 'Needs a person’s body');

export function whyNotDraft() {
  const { state, kind } = server.job ?? {};
  const isAtWork = state === 'running' && kind === 'draft';
  return whyNotDraftable() || (isAtWork ? 'Drafting already' : ui.box ? '' : 'Draw a box around the person first');
}

/** What is sent: the box as it lies over the frame of the playhead. */
export function draftMessage() {
  return { do: 'draft', frame: frame(), box: ui.box.map((side) => Math.round(10 * side) / 10) };
}

/** What to say of a box around somebody small, or ''. */
export function smallWords() {
  const height = ui.box ? Math.round(ui.box[3] - ui.box[1]) : SMALL_PX;
  return height < SMALL_PX ? `The person is small here (${height} px). Choose a nearer frame if there is one.` : '';
}

/** @type {Record<string, (parts: string) => string>} */
const REASONS = {
  start: () => 'first frame of the draft',
  end: () => 'last frame of the draft',
  residual: (parts) => `${parts} may be off`,
  hidden: (parts) => `${parts} hidden`,
  flip: (parts) => `${parts} may point the other way`,
  person: () => 'may be another person from here on',
};

/** "Right forearm hidden": why a place should be confirmed. */
export function reasonOf({ reason, parts }) {
  const words = REASONS[reason]?.(partWords(parts)) ?? '';
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** Several are named by the first of them. */
function partWords(parts) {
  if (parts.length === 0) return 'the body';
  const more = parts.length > 1 ? ` and ${count(parts.length - 1, 'more part')}` : '';
  return `${parts[0].toLowerCase()}${more}`;
}

/** "3 places to confirm" */
export const placesWords = () => `${count(placesToConfirm().length, 'place')} to confirm`;

/** "Drafted 150 of 180 frames." */
export function draftedWords({ first, last, missing }) {
  const all = last - first + 1;
  const some = missing.length ? `${all - missing.length} of ` : '';
  return `Drafted ${some}${count(all, 'frame')}.`;
}
