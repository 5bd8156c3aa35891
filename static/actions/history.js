// Undo and redo as a list of steps, by the days they were made on.

import { server } from '../store/state.js';
import { send } from '../store/link.js';

/**
 * @typedef {{ heading: string } | { label: string, time: string, done: number, state: 'done' | 'here' | 'undone' }} Row
 */

/** Go to where so many steps are done, as one move. */
export function goToStep(done) {
  const { total, done: now } = server.history;
  if (done !== now) send({ do: 'go_to_step', done, of: total });
}

export const noHistory = () => (server.history?.total ? '' : 'Nothing has been changed yet');

/**
 * The rows of the list, the newest first, with a heading where another day begins. The last one
 * stands before the first step.
 * @param {import('../store/shapes.js').History | null | undefined} history
 * @param {number} now  Seconds since 1970.
 * @returns {Row[]}
 */
export function historyRows(history, now = Date.now() / 1000) {
  if (!history) return [];
  /** @type {Row[]} */
  const rows = [];
  let day = null;
  for (const [i, step] of [...history.steps.entries()].reverse()) {
    const here = dayOf(step.made, now);
    if (here !== day) rows.push({ heading: here });
    day = here;
    rows.push({ label: sentence(step.label), time: timeOf(step.made), ...standing(history, history.first + i + 1) });
  }
  if (history.first === 0) rows.push({ label: 'Beginning', time: '', ...standing(history, 0) });
  return rows;
}

/** @returns {{ done: number, state: 'done' | 'here' | 'undone' }} */
function standing({ done: now }, done) {
  return { done, state: done === now ? 'here' : done < now ? 'done' : 'undone' };
}

const sentence = (words) => words[0].toUpperCase() + words.slice(1);

/** "14:32". */
function timeOf(made) {
  return made === null ? '' : new Date(made * 1000).toLocaleTimeString('en-GB', { hour: '2-digit', minute: '2-digit' });
}

/** "Today", "Yesterday", "12 Nov"; "Earlier" where nobody kept when. */
export function dayOf(made, now) {
  if (made === null) return 'Earlier';
  const days = Math.round((midnight(now) - midnight(made)) / 86400000);
  if (days <= 0) return 'Today';
  if (days === 1) return 'Yesterday';
  const date = new Date(made * 1000);
  const year = date.getFullYear() === new Date(now * 1000).getFullYear() ? undefined : 'numeric';
  return date.toLocaleDateString('en-GB', { day: 'numeric', month: 'short', year });
}

const midnight = (seconds) => new Date(seconds * 1000).setHours(0, 0, 0, 0);
