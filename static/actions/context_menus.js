// What is in the menu of a thing, group by group: names of the table of actions. What is not possible
// now stays in it, greyed, with its reason in the place of the key.

import { line } from '../controls/menu.js';
import { entryOf, whyNot } from './actions.js';
import { menuItem } from './buttons.js';
import { heldFrame } from './films.js';
import { isDraftAlone } from './keying.js';
import { frame, isKey } from './playhead.js';

/** @typedef {import('./actions.js').ActionId} ActionId */

/** title: what the menu belongs to. @type {Record<string, { title: string, groups: ActionId[][] }>} */
export const CONTEXTS = {
  part: {
    title: 'a part',
    groups: [
      ['keyLimb', 'turnInDepth', 'resetPart', 'otherSide'],
      ['addKeyframe', 'deleteKeyframe', 'fitPose', 'copyPose', 'pastePose'],
      ['addPart', 'deletePart'],
    ],
  },
  picture: {
    title: 'the picture',
    groups: [
      ['addKeyframe', 'deleteKeyframe', 'fitPose', 'useTracked'],
      ['copyPose', 'pastePose', 'pasteMirrored', 'copyPrevious', 'copyNext', 'swapSides', 'resetPose'],
      ['note'],
      ['fitView', 'freeView', 'ghosts', 'trail', 'floor', 'rings'],
      ['saveImage', 'copyImage'],
    ],
  },
  free: {
    title: 'the free view',
    groups: [
      ['addKeyframe', 'deleteKeyframe', 'copyPose', 'pastePose', 'note'],
      ['ghosts', 'trail'],
    ],
  },
  freePart: { title: 'a part', groups: [['turnInDepth', 'resetPart', 'otherSide']] },
  eye: { title: 'the free view', groups: [['fitView']] },
  keyframe: { title: 'a keyframe', groups: [['copyKeyHere', 'note']] },
  partKeyframe: { title: 'a part keyframe', groups: [['note']] },
  segment: { title: 'a segment', groups: [['trackChanged', 'reduce', 'nextProblem', 'review'], ['note']] },
  frames: {
    title: 'the timeline',
    groups: [
      ['goTo', 'note'],
      ['zoomToInterval', 'lanes', 'trackChanged', 'reduce'],
    ],
  },
  note: { title: 'a note', groups: [['goTo', 'note', 'deleteNote']] },
  film: {
    title: 'another film',
    groups: [
      ['enlargeFilm', 'holdFilm', 'alignFilm', 'filmBegins', 'placeFilm'],
      ['addFilm', 'removeFilm'],
    ],
  },
  body: { title: 'a body', groups: [['poseBody', 'nameBody', 'removeBody']] },
};

/** Of a pair the one that fits the frame stands in a menu. */
const FITS = {
  addKeyframe: () => !isKey(frame()),
  deleteKeyframe: () => isKey(frame()) || isDraftAlone(frame()),
  copyKeyHere: (from) => from !== frame(),
  filmBegins: (film) => film.also.length > 0,
  alignFilm: (film) => heldFrame(film) !== null,
};

/**
 * The entries of a thing's menu. about: what an action is done to, by its name; where that is not
 * what its key does, no key is shown.
 * @param {keyof typeof CONTEXTS} name
 * @param {Partial<Record<ActionId, unknown>>} about
 */
export function contextEntries(name, about = {}) {
  const groups = CONTEXTS[name].groups
    .map((ids) => ids.filter((id) => FITS[id]?.(about[id]) ?? true))
    .filter((ids) => ids.length);
  return groups.flatMap((ids, i) => [...(i > 0 ? [line] : []), ...ids.map((id) => entry(id, about[id]))]);
}

/** The entries of a film's menu. @param {import('../store/shapes.js').Film} film */
export function filmEntries(film) {
  const ids = CONTEXTS.film.groups.flat().filter((id) => id !== 'addFilm');
  return contextEntries('film', Object.fromEntries(ids.map((id) => [id, film])));
}

/** The entries of a body's menu. @param {string} id */
export const bodyEntries = (id) => contextEntries('body', { poseBody: id, nameBody: id, removeBody: id });

/** One entry: its key where that does the same, or why it cannot be done. */
function entry(id, about) {
  const why = whyNot(id, about);
  const isElsewhere = typeof about === 'number' && about !== frame();
  const { alone } = entryOf(id); // its name without the heading that it has elsewhere
  const label = alone ? { label: alone } : {};
  return menuItem(id, about, { ...label, ...(why || isElsewhere ? { right: why } : {}) });
}

/** The menus an action is in: ["a part", "the picture"]. */
export const menusWith = (id) => [
  ...new Set(
    Object.values(CONTEXTS)
      .filter(({ groups }) => groups.flat().includes(id))
      .map(({ title }) => title),
  ),
];
