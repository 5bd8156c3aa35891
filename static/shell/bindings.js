// The keys of the page, in one table: what they are called, and what they do. The keyboard and the
// sheet of keys are both made from it.

import { send } from '../store/link.js';
import { server, setUi } from '../store/state.js';
import { TOOLS } from '../handles/tools.js';
import * as inspector from '../inspector/inspector.js';
import { frame } from '../timeline/edit/head.js';
import { deleteKey, setKey } from '../timeline/edit/keying.js';
import * as timeline from '../timeline/timeline.js';
import { copyPicture, savePicture } from './export.js';
import { toggleSheet } from '../controls/dialogs.js';
import { fitLarge, showLarge } from './layout.js';
import { toggleLive, track } from './track.js';

const MODES = ['wire', 'solid', 'both'];

/** keys: [chord, action]; without an action the key is shown, and others see to it. */
const row = (label, ...keys) => ({ label, keys: keys.map(([chord, run, more]) => ({ chord, run, ...more })) });
const REPEATS = { repeats: true };
const ALIAS = { alias: true }; // works, and is not shown
const ALWAYS = { always: true }; // also without a file
const large = (name) => () => showLarge(name);
const display = (change) => send({ do: 'display', ...change });

const FRAMES = [
  row('One frame', ['ArrowLeft', () => timeline.step(-1), REPEATS], ['ArrowRight', () => timeline.step(1), REPEATS]),
  row('Ten frames', ['Shift ArrowLeft', () => timeline.step(-10), REPEATS], ['Shift ArrowRight', () => timeline.step(10), REPEATS]),
  row('First, last', ['Home', () => timeline.toFirst()], ['End', () => timeline.toLast()]),
  row('Play, stop', ['Space', null]),
  row('Previous, next keyframe', [',', () => timeline.toKey(-1), REPEATS], ['.', () => timeline.toKey(1), REPEATS]),
  row('Middle of this interval', ['/', () => timeline.middle()]),
  row('Next frame to key', ['N', () => timeline.next()]),
  row('Zoom to this interval', ['Z', () => timeline.zoomToInterval()]),
];

const POSE = [
  row('Keep the pose as a keyframe', ['K', setKey]),
  row('Fit the pose to what is seen', ['F', () => inspector.fitHere()]),
  row('Delete the keyframe', ['Delete', () => deleteKey()]),
  row('Copy, paste', ['Ctrl C', () => send({ do: 'copy_pose' })], ['Ctrl V', () => paste(false)]),
  row('Paste mirrored', ['Ctrl Shift V', () => paste(true)]),
  row('Copy previous keyframe', ['P', copyPrevious]),
  row('Reset part, pose', ['Backspace', resetPart], ['Shift Backspace', () => send({ do: 'reset_pose' })]),
  row(
    'Undo, redo',
    ['Ctrl Z', () => send({ do: 'undo' }), REPEATS],
    ['Ctrl Shift Z', () => send({ do: 'redo' }), REPEATS],
    ['Ctrl Y', () => send({ do: 'redo' }), { ...REPEATS, ...ALIAS }],
  ),
];

const TRACK = [
  row('Track changed segments', ['T', () => track('changed')]),
  row('Track this segment', ['Shift T', () => track('this')]),
  row('Cancel', ['Escape', null]),
  row('Live on, off', ['L', toggleLive]),
  row('Next problem', ['Shift N', () => timeline.nextProblem()]),
  row('Keys and help', ['?', toggleSheet, ALWAYS]),
];

const TOOL_KEYS = [
  ...TOOLS.map(({ name, label, key }) => row(label, [key, () => setUi('tool', name)])),
  row('Other side of the body', ['Q', () => inspector.otherSide()]),
  row('Along the limb', ['[', () => inspector.alongChain(-1)], [']', () => inspector.alongChain(1)]),
];

const VIEWS = [
  row('Camera, top, side, front', ['1', large('main')], ['2', large('top')], ['3', large('side')], ['4', large('front')]),
  row('All four', ['5', large('quad')]),
  row('Wire, solid, both', ['W', nextMode]),
  row(
    'Ghosts, trail, lanes',
    ['O', () => display({ ghosts: !server.view.ghosts })],
    ['M', () => display({ trail: !server.view.trail })],
    ['I', () => timeline.foldLanes()],
  ),
  row('Fit the picture', ['0', fitLarge]),
  row('Pan, zoom', ['Space drag', null], ['Wheel', null]),
  row('Save, copy the picture', ['Shift E', () => savePicture()], ['Shift C', copyPicture]),
];

const DRAGGING = [
  row('Fine, one tenth', ['Shift', null]),
  row('5° or 1 cm steps', ['Ctrl', null]),
  row('Nearer or farther', ['D', null]),
  row('Joint limits off', ['U', null]),
  row('Keep to one axis', ['X', null], ['Y', null], ['Z', null]),
  row('Take back', ['Escape', null]),
];

/** The groups of the sheet, in its order. */
export const GROUPS = [
  { title: 'Frames', rows: FRAMES },
  { title: 'Pose', rows: POSE },
  { title: 'Track', rows: TRACK },
  { title: 'Tools', rows: TOOL_KEYS },
  { title: 'Views', rows: VIEWS },
  { title: 'While dragging', rows: DRAGGING },
];

/** What each chord does. */
export const BY_CHORD = new Map(
  GROUPS.flatMap((group) => group.rows)
    .flatMap((each) => each.keys)
    .filter((key) => key.run)
    .map((key) => [key.chord, key]),
);

function nextMode() {
  const at = MODES.indexOf(server.view.mode);
  display({ mode: MODES[(at + 1) % MODES.length] });
}

function paste(mirrored) {
  send({ do: 'paste_pose', mirrored });
}

function copyPrevious() {
  const before = (server.keys?.frames ?? []).filter((key) => key < frame());
  if (before.length) send({ do: 'copy_key', from_frame: before.at(-1) });
}

function resetPart() {
  if (server.view.selected) send({ do: 'reset_part', part: server.view.selected });
}
