// Whose keys they are, and the elements that are there for as long as the page is. A control reached
// with Tab keeps the keys it needs until Esc; one that was clicked gives the focus back to the page,
// so that keys always reach the frame.

/**
 * Make an element over everything else, where sheets, menus and messages are drawn.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {string} id
 * @param {Tag} tag
 */
export function addOnTop(id, tag) {
  const place = document.getElementById('screens');
  if (!place) throw new Error('The page has no #screens');
  const element = document.createElement(tag);
  element.id = id;
  place.append(element);
  return element;
}

const OWN = new Set([
  ...['Space', 'Enter', 'Home', 'End', 'PageUp', 'PageDown', 'ArrowLeft', 'ArrowRight'],
  ...['ArrowUp', 'ArrowDown', 'Shift ArrowLeft', 'Shift ArrowRight'],
]);
const NO_TEXT = new Set(['checkbox', 'radio', 'button', 'range', 'color', 'file', 'submit']);

let byKey = false;

/** Whether the focus was last moved with Tab. */
export const reachedByKey = () => byKey;

/** Whether what is typed goes into this element as text. */
function takesText(element) {
  if (element instanceof HTMLInputElement) return !NO_TEXT.has(element.type);
  return element instanceof HTMLTextAreaElement || Boolean(element?.isContentEditable);
}

/** Whether the focused control wants this key for itself. */
export function keepsKey(chord) {
  const element = document.activeElement;
  if (takesText(element)) return true;
  if (!isControl(element)) return false;
  if (element instanceof HTMLSelectElement) return chord !== 'Escape';
  return byKey && OWN.has(chord);
}

/** Take the focus off a control, so that all keys reach the page; returns whether it had it. */
export function leaveControl() {
  const element = document.activeElement;
  if (!isControl(element)) return false;
  element.blur();
  return true;
}

/**
 * What stands for a button without being one is pressed with Enter and Space.
 * @param {() => void} act
 */
export const onEnter = (act) => (/** @type {KeyboardEvent} */ event) => {
  if (event.key !== 'Enter' && event.key !== ' ') return;
  event.preventDefault();
  event.stopPropagation();
  act();
};

export function mountFocus() {
  addEventListener('keydown', (event) => event.key === 'Tab' && (byKey = true), true);
  addEventListener('pointerdown', () => (byKey = false), true);
  for (const kind of ['pointerup', 'click', 'change']) addEventListener(kind, giveBack);
}

function giveBack(event) {
  const clicked = document.activeElement;
  // After everybody has dealt with the click: an editor may have opened by it.
  requestAnimationFrame(() => {
    const element = document.activeElement;
    // What has got the focus since then keeps it: a slow page may take long to the next frame.
    if (element !== clicked) return;
    if (byKey || !isControl(element) || takesText(element)) return;
    if (element.closest('dialog, .menu, [data-keeps-focus]')) return;
    // A list that was just opened would close again.
    if (element instanceof HTMLSelectElement && event.type !== 'change') return;
    element.blur();
  });
}

/**
 * @param {Element | null} element
 * @returns {element is HTMLElement | SVGElement}
 */
function isControl(element) {
  const takesFocus = element instanceof HTMLElement || element instanceof SVGElement;
  return takesFocus && element !== document.body && element !== document.documentElement;
}
