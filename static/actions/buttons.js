// Buttons and menu entries that stand for an action: its icon, words, key, and why it cannot be done.

import { button, checkbox, iconButton } from '../controls/fields.js';
import { iconOf, isOn, keyOf, labelOf, perform, titleOf, whyNot } from './actions.js';

/** @typedef {import('./actions.js').ActionId} ActionId */

/**
 * An entry of a menu. `about` is what the action is done to; looks: what differs here, such as a
 * shorter label.
 * @param {ActionId} id
 */
export function menuItem(id, about = undefined, looks = {}) {
  return {
    icon: iconOf(id, about),
    label: labelOf(id, about),
    right: keyOf(id),
    off: whyNot(id, about),
    checked: isOn(id, about),
    run: (...more) => perform(id, ...(about === undefined ? more : [about, ...more])),
    ...looks,
  };
}

/**
 * A square button with the action's icon.
 * @param {ActionId} id
 */
export function actionIcon(id, about = undefined, looks = {}) {
  return iconButton({
    ...faceOf(id, about),
    name: iconOf(id, about),
    pressed: isOn(id, about),
    action: id,
    ...looks,
  });
}

/**
 * A button with the action's words.
 * @param {ActionId} id
 */
export function actionButton(id, about = undefined, looks = {}) {
  return button({ ...faceOf(id, about), name: iconOf(id, about), ...looks });
}

/**
 * A box to tick, for an action that switches something on and off.
 * @param {ActionId} id
 */
export function actionBox(id, about = undefined, looks = {}) {
  return checkbox({ ...faceOf(id, about), on: isOn(id, about), ...looks });
}

function faceOf(id, about) {
  return {
    label: labelOf(id, about),
    title: titleOf(id, about),
    key: keyOf(id),
    off: whyNot(id, about),
    act: () => perform(id, about),
  };
}
