// Everything that one can do at the page, in one table: what it is called, its keys, when it can be
// done and how. The keyboard, the sheet of keys, menus, buttons and their tips are made from it. Here
// it is put together: a module for each kind of action stands in `table/`.

import { words } from '../store/subject.js';
import { DRAGGING } from './table/dragging.js';
import { EXPORT, MOTION } from './table/export.js';
import { FRAMES } from './table/frames.js';
import { HISTORY } from './table/history.js';
import { KEYFRAMES } from './table/keyframes.js';
import { NOTES } from './table/notes.js';
import { PINS } from './table/pins.js';
import { POSE } from './table/pose.js';
import { REVIEW } from './table/review.js';
import { SESSION } from './table/session.js';
import { THEME } from './table/theme.js';
import { TOOLS } from './table/tools.js';
import { TRACK } from './table/track.js';
import { VIEW } from './table/view.js';

const FILE = { ...SESSION, ...MOTION, ...EXPORT, ...THEME };

/** In the order of the sheet of keys; without a title a group is not on it. */
export const GROUPS = [
  { title: () => 'Frames', actions: { ...FRAMES, ...NOTES } },
  { title: () => 'Pose', actions: { ...KEYFRAMES, ...POSE, ...HISTORY, ...PINS } },
  { title: () => words().verb, actions: { ...TRACK, ...REVIEW } },
  { title: () => 'Tools', actions: TOOLS },
  { title: () => 'Views', actions: VIEW },
  { title: () => 'While dragging', actions: DRAGGING },
  { title: null, actions: FILE },
];

export const ACTIONS = {
  ...FRAMES, ...NOTES, ...KEYFRAMES, ...POSE, ...HISTORY, ...PINS, ...TRACK, ...REVIEW, ...TOOLS, ...VIEW, ...DRAGGING, ...FILE,
};

/** @typedef {keyof typeof ACTIONS} ActionId */
