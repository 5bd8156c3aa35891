// What is in the menu of a thing, group by group: names of the table of actions. What is not possible
// now stays in it, greyed, with its reason in the place of the key.

import { line } from '../controls/menu.js';
import { whyNot } from './actions.js';
import { menuItem } from './buttons.js';
import { frame, isKey } from './playhead.js';

/** @typedef {import('./actions.js').ActionId} ActionId */

/** @type {Record<string, { title: string, groups: ActionId[][] }>} */
export const CONTEXTS = {
  part: {
    title: 'part',
    groups: [
      ['turnInDepth', 'resetPart', 'otherSide', 'inward', 'outward'],
      ['addKeyframe', 'deleteKeyframe', 'fitPose', 'copyPose', 'pastePose'],
    ],
  },
  picture: {
    title: 'picture',
    groups: [
      ['addKeyframe', 'deleteKeyframe', 'fitPose', 'useTracked'],
      ['copyPose', 'pastePose', 'pasteMirrored', 'copyPrevious', 'copyNext', 'swapSides', 'resetPose'],
      ['note'],
      ['fitView', 'freeView', 'ghosts', 'trail', 'floor', 'rings'],
      ['saveImage', 'copyImage'],
    ],
  },
  free: { title: 'free view', groups: [['addKeyframe', 'deleteKeyframe', 'copyPose', 'pastePose', 'note'], ['ghosts', 'trail']] },
  freePart: { title: 'part', groups: [['turnInDepth', 'resetPart', 'otherSide']] },
  eye: { title: 'free view', groups: [['fitView']] },
  keyframe: { title: 'keyframe', groups: [['copyKeyHere'], ['note']] },
  segment: { title: 'segment', groups: [['trackChanged', 'nextProblem'], ['note']] },
  frames: { title: 'timeline', groups: [['goTo', 'note'], ['zoomToInterval', 'lanes', 'trackChanged']] },
  note: { title: 'note', groups: [['goTo', 'note', 'deleteNote']] },
};

/** One of a pair stands in a menu, the one that fits the frame. */
const FITS = { addKeyframe: () => !isKey(frame()), deleteKeyframe: () => isKey(frame()) };

/**
 * The entries of a thing's menu. about: what an action is done to, by its name; where that is not
 * what its key does, no key is shown.
 * @param {keyof typeof CONTEXTS} name
 * @param {Partial<Record<ActionId, unknown>>} about
 */
export function contextEntries(name, about = {}) {
  const groups = CONTEXTS[name].groups.map((ids) => ids.filter((id) => FITS[id]?.() ?? true));
  return groups.flatMap((ids, i) => [...(i > 0 ? [line] : []), ...ids.map((id) => entry(id, about[id]))]);
}

/** One entry: its key, or why it cannot be done. */
export function entry(id, about = undefined, looks = {}) {
  const why = whyNot(id, about);
  return menuItem(id, about, why ? { right: why, ...looks } : looks);
}

/** The menus an action is in: ["part", "picture"]. */
export const menusWith = (id) =>
  [...new Set(Object.values(CONTEXTS).filter(({ groups }) => groups.flat().includes(id)).map(({ title }) => title))];
