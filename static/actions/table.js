// Everything that one can do at the page, in one table: what it is called, its keys, when it can be
// done and how. The keyboard, the sheet of keys, menus, buttons and their tips are made from it. Here
// it is put together: a module for each kind of action stands in `table/`.

import { words } from '../store/clip.js';
import { ANGLES, DRAGGING, TOOLS, VIEW } from './table/view.js';
import { BODIES } from './table/bodies.js';
import { CAMERA } from './table/camera.js';
import { EXPORT, MOTION } from './table/export.js';
import { FILMS } from './table/films.js';
import { FRAMES } from './table/frames.js';
import { HISTORY, SESSION, THEME } from './table/session.js';
import { KEYFRAMES, NOTES, PINS } from './table/keyframes.js';
import { POSE } from './table/pose.js';
import { REVIEW, TRACK } from './table/track.js';

const FILE = { ...SESSION, ...MOTION, ...EXPORT, ...THEME };

/** In the order of the sheet of keys; without a title a group is not on it. */
export const GROUPS = [
  { title: () => 'Frames', actions: { ...FRAMES, ...NOTES } },
  { title: () => 'Pose', actions: { ...KEYFRAMES, ...POSE, ...HISTORY, ...PINS, ...BODIES } },
  { title: () => words().verb, actions: { ...TRACK, ...REVIEW, ...CAMERA, ...FILMS } },
  { title: () => 'Tools', actions: TOOLS },
  { title: () => 'Views', actions: { ...VIEW, ...ANGLES } },
  { title: () => 'While dragging', actions: DRAGGING },
  { title: null, actions: FILE },
];

export const ACTIONS = {
  ...FRAMES,
  ...NOTES,
  ...KEYFRAMES,
  ...POSE,
  ...HISTORY,
  ...PINS,
  ...BODIES,
  ...TRACK,
  ...REVIEW,
  ...CAMERA,
  ...FILMS,
  ...TOOLS,
  ...VIEW,
  ...ANGLES,
  ...DRAGGING,
  ...FILE,
};

/** @typedef {keyof typeof ACTIONS} ActionId */
