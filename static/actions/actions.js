// An action by its name: its words, its keys, whether it can be done, and doing it.

import { isCaughtUp } from '../store/edits.js';
import { send } from '../store/link.js';
import { toast } from '../controls/toasts.js';
import { ACTIONS, GROUPS } from './table.js';

/** @typedef {import('./table.js').ActionId} ActionId */
/** @typedef {import('./table/action.js').Action} Action */

const SIGNS = { ArrowLeft: '←', ArrowRight: '→', Backspace: '⌫', Escape: 'Esc' };
const CTRL = /Mac|iPhone|iPad/.test(globalThis.navigator?.platform ?? '') ? '⌘' : 'Ctrl';

/**
 * The entry of the table.
 * @param {ActionId} id
 * @returns {Action}
 */
export const entryOf = (id) => ACTIONS[id];

/** @param {ActionId} id */
export const labelOf = (id, about = undefined) => text(entryOf(id).label, about);

/** What it does, in the words of its tip. @param {ActionId} id */
export const titleOf = (id, about = undefined) => text(entryOf(id).title, about) ?? labelOf(id, about);

/** @param {ActionId} id */
export const iconOf = (id, about = undefined) => text(entryOf(id).icon, about);

/** Why it cannot be done now, or ''. @param {ActionId} id */
export const whyNot = (id, about = undefined) => entryOf(id).off?.(about) ?? '';

/** Whether it is switched on; undefined where that is no question. @param {ActionId} id */
export const isOn = (id, about = undefined) => entryOf(id).on?.(about);

/** The key that is shown beside it, or ''. @param {ActionId} id */
export const keyOf = (id) => spell(entryOf(id).keys?.[0] ?? '');

/** "Ctrl Shift ⌫": a chord as it is shown on this computer. */
export function spell(chord) {
  const names = chord.split(' ').map((name) => SIGNS[name] ?? name);
  return names.map((name) => (name === 'Ctrl' ? CTRL : name)).join(' ');
}

/**
 * Do it; where it cannot be done, say why. While something sent is not answered yet, the page does
 * not know what can be done by then, and the server decides.
 * @param {ActionId} id
 * @param {unknown[]} about
 */
export function perform(id, ...about) {
  const { message, run, repeats } = entryOf(id);
  const why = whyNot(id, about[0]);
  if (why && isCaughtUp()) {
    if (!repeats) toast({ kind: 'info', words: `${why}.` });
  } else if (message) send(message(about[0]));
  else run?.(...about);
}

/** @typedef {{ id: ActionId, repeats?: boolean, always?: boolean }} Binding */

/**
 * What each chord does that the keyboard's table handles.
 * @type {Map<string, Binding>}
 */
export const BY_CHORD = new Map(
  GROUPS.flatMap(({ actions }) => Object.entries(actions)).flatMap(([id, entry]) => {
    /** @type {Action} */
    const { keys = [], aliases = [], handledBy, repeats, always } = entry;
    const binding = /** @type {Binding} */ ({ id, repeats, always });
    return handledBy ? [] : [...keys, ...aliases].map((chord) => /** @type {[string, Binding]} */ ([chord, binding]));
  }),
);

/** What each chord does while the film plays, before anything else. @type {Map<string, ActionId>} */
export const WHILE_PLAYING = new Map(
  Object.entries(ACTIONS).flatMap(([id, entry]) => {
    /** @type {Action} */
    const { keys = [], handledBy } = entry;
    return handledBy === 'playing' ? keys.map((chord) => /** @type {[string, ActionId]} */ ([chord, id])) : [];
  }),
);

/** The lines of the sheet of keys: [{ title, lines: [{ words, keys }] }]. */
export function keySheet() {
  return GROUPS.filter(({ title }) => title).map(({ title, actions }) => ({ title: title(), lines: linesOf(actions) }));
}

/** @param {Record<string, Action>} actions */
function linesOf(actions) {
  const lines = new Map();
  for (const { label, row, keys = [] } of Object.values(actions)) {
    if (!keys.length) continue;
    const words = row ?? text(label, undefined);
    lines.set(words, new Set([...(lines.get(words) ?? []), ...keys]));
  }
  return [...lines].map(([words, keys]) => ({ words, keys: [...keys] }));
}

const text = (value, about) => (typeof value === 'function' ? value(about) : value);
