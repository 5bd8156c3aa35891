// Everything a pointer does on the four views: handles, rings, selection, drawing, the bars.

import { ui, setUi, watch } from '../store/state.js';
import { VIEWS, onViews, view as viewNamed } from '../views/views.js';
import { mountBars } from './bars.js';
import { tellSoon } from './drag.js';
import { hold, onHold, touch } from './hold.js';
import { leave, refresh } from './hover.js';
import { letterOf, onKeys, watchKeys } from './keysheld.js';
import { deleteMask } from './masks.js';
import { paint } from './paint.js';
import { isPressed, listenTo, takeBack } from './press.js';
import { sketchKey, toolChanged } from './sketch.js';

/** @type {import('../store/shapes.js').Watched[]} */
const SECTIONS = ['file', 'pose', 'body', 'view', 'views', 'trail', 'masks', 'keys', 'camera'];

export function mount() {
  watchKeys();
  onKeys(key);
  for (const name of VIEWS) listenTo(viewNamed(name));
  onHold(paint);
  onViews(paint);
  watch([...SECTIONS, 'u:limb', 'u:mask', 'u:layout', 'u:dragging'], paint);
  watch(['pose'], refresh);
  watch(['u:tool'], changeTool);
  watch(['u:playing', 'file'], () => ui.playing && leave());
  mountBars();
}

function changeTool() {
  toolChanged();
  touch();
}

/**
 * Keys that concern a gesture or a drawing do not reach the other rooms. Only presses are kept
 * back: a room that saw a key go down must see it come up.
 */
function key(event) {
  const name = letterOf(event);
  if (hold.drag && name !== 'escape') tellSoon();
  if (event.type !== 'keydown' || isTyping(event)) return;
  if (isPressed() && name !== ' ') {
    if (name === 'escape') takeBack();
    keep(event);
  } else if (sketchKey(name) || maskKey(name)) {
    keep(event);
  }
}

function maskKey(name) {
  if (ui.mask == null) return false;
  if (name === 'delete' || name === 'backspace') deleteMask();
  else if (name === 'escape') setUi('mask', null);
  else return false;
  return true;
}

const isTyping = ({ target }) => target.matches?.('input:not([type=range]), textarea, select, [contenteditable]');

function keep(event) {
  event.preventDefault();
  event.stopImmediatePropagation();
}
