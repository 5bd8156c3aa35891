// Everything a pointer does on the four views: handles, rings, selection, drawing, the bars.

import { ui, setUi, watch } from '../store/state.js';
import { ALL_VIEWS, onViews, view as viewNamed } from '../views/views.js';
import { mountBars } from './bars.js';
import { letterOf, mountOffline, onKeys, sendSoon, watchKeys } from './drag.js';
import { mountFloating } from './floating.js';
import { interaction, onInteraction, redrawSoon } from './interaction.js';
import { leave, refresh, renameHandle } from './hover.js';
import { deleteMask } from './masks.js';
import { paint } from './paint.js';
import { cancelPress, isPressed, listenTo } from './press.js';
import { selectBehind } from './select.js';
import { prepareSketch, sketchKey } from './sketch.js';
import { listenForMenuKey } from './viewmenu.js';

/** @type {import('../store/shapes.js').Watched[]} */
const SECTIONS = [
  'file',
  'pose',
  'body',
  'view',
  'views',
  'trail',
  'masks',
  'keys',
  'camera',
  'keypoints',
  'pins',
  'joint_angle',
  'background',
  'people',
  'up',
];

export function mount() {
  watchKeys();
  mountOffline();
  onKeys(key);
  for (const name of ALL_VIEWS) listenTo(viewNamed(name));
  onInteraction(paint);
  onViews(paint);
  watch(
    [
      ...SECTIONS,
      'u:limb',
      'u:mask',
      'u:box',
      'u:personHover',
      'u:layout',
      'u:dragging',
      'u:tab',
      'u:rings',
      'u:keypointHover',
      'u:review',
      'u:connected',
      'u:playing',
    ],
    paint,
  );
  watch(['pose'], refresh);
  watch(['u:tool'], changeTool);
  watch(['u:playing', 'file'], () => ui.playing && leave());
  listenForMenuKey();
  mountBars();
  mountFloating();
}

function changeTool() {
  prepareSketch();
  redrawSoon();
}

/**
 * Keys that concern a gesture or a drawing do not reach the other rooms. Only presses
 * are stopped: a room that saw a key go down must see it come up.
 */
function key(event) {
  const name = letterOf(event);
  if (interaction.drag && name !== 'escape') sendSoon();
  if (event.type !== 'keydown' || isTyping(event)) return;
  if (isPressed() && name !== ' ') {
    if (name === 'escape') cancelPress();
    stop(event);
  } else if (sketchKey(event, name) || maskKey(name) || (name === 'tab' && tabKey())) {
    stop(event);
  }
}

/** While the keys are with the views, Tab goes through handles that lie over each other under the pointer. */
function tabKey() {
  const { pointer } = interaction;
  if (!pointer || document.activeElement !== document.body) return false;
  if (!selectBehind(pointer.view, pointer.x, pointer.y)) return false;
  renameHandle();
  return true;
}

function maskKey(name) {
  if (ui.mask == null) return false;
  if (name === 'delete' || name === 'backspace') deleteMask();
  else if (name === 'escape') setUi('mask', null);
  else return false;
  return true;
}

const isTyping = ({ target }) => target.matches?.('input:not([type=range]), textarea, select, [contenteditable]');

function stop(event) {
  event.preventDefault();
  event.stopImmediatePropagation();
}
