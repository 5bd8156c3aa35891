// What the tools do, as the status bar says it.

import { keyOf, labelOf } from '../actions/actions.js';
import { server } from '../store/state.js';
import { view as viewNamed } from '../views/views.js';
import { boxCornersIn } from './boxcorners.js';
import { interaction } from './interaction.js';
import { DRAWING } from './sketch.js';

/** A key of the table pressed during a drag, with its words. */
const hint = (id) => [keyOf(id), lower(labelOf(id))];
const lower = (words) => words.charAt(0).toLowerCase() + words.slice(1);

const FINE = hint('fine');
const BACK = hint('cancelDrag');
const DEPTH = hint('depth');
const DEGREES = hint('snapAngle');
const CENTIMETRES = hint('snapLength');
const FREE = hint('free');
const CARRY = hint('carry');
/** With it the corners that were placed before do not stay. */
const LET_GO = [keyOf('carry'), 'let go of the other corners'];
const LIMB = ['Double-click', 'select the limb'];

const IDLE_TOOL_HINTS = {
  select: [['Click', 'select; click again for what is behind'], LIMB, ['Drag', 'rotate a part, move the waist'], CARRY],
  rotate: [['Drag', 'rotate about its joint'], FINE, DEGREES, FREE],
  move: [['Drag', 'move the whole body in the image plane'], FINE, DEPTH, BACK],
  ends: [['Drag', 'pull a hand or foot, the limb follows'], DEPTH, FINE, CENTIMETRES],
  size: [['Drag', 'cap: length, rim: radius, cross: joint'], FINE, CENTIMETRES, BACK],
  pan: [
    ['Drag', 'pan'],
    ['Wheel', 'zoom at the pointer'],
    ['0', 'fit'],
  ],
};

/** Of a body without hands and feet: a thing. */
const RESTING_ON_THING = [
  ['Click', 'select; click again for what is behind'],
  ['Drag', 'move the body, rotate a part'],
];
const RESTING_ON_BOX = [
  ['Drag', 'a corner to where you see it: four give the pose'],
  ['Drag', 'elsewhere, move the box'],
  LET_GO,
];

const HOLDING = {
  ring: (axis) => [['Drag', `rotate about ${axis}`], ...carrying(), FINE, DEGREES, FREE, BACK],
  turn: () => [['Drag', 'rotate about its joint'], ...carrying(), ['X Y Z', 'one axis'], FINE, DEGREES, FREE, BACK],
  root: () => [['Drag', 'move in the image plane'], ...carrying(), FINE, DEPTH, CENTIMETRES, BACK],
  end: () => [['Drag', 'pull, elbow or knee stays'], CARRY, DEPTH, FINE, CENTIMETRES, BACK],
  joint: () => [['Drag', 'swing the joint, its end stays'], CARRY, FINE, BACK],
  corner: () => [['Drag', 'the trunk follows, the limbs stay'], CARRY, DEPTH, FINE, BACK],
  box_corner: () => [['Drag', 'to where it is seen; placed corners stay'], LET_GO, FINE, BACK],
  size: () => [['Drag', 'longer or thicker'], FINE, CENTIMETRES, BACK],
  mask: () => [['Drag', 'move'], FINE, BACK],
  keypoint: () => [['Drag', 'to where the joint is seen; the pose stays'], FINE, BACK],
  pan: () => [['Drag', interaction.panning?.isOrbit ? 'orbit' : 'pan']],
};

const IN_FREE_VIEW = [
  ['Right drag', 'orbit'],
  ['Shift right drag', 'pan'],
  ['Wheel', 'nearer or farther'],
  ['6', 'back to the view before'],
  ['0', 'reset the view'],
];
/** Where hands and feet stay unless they are carried: the drag is of a part that they hang on. */
function carrying() {
  const { part } = interaction.drag?.target ?? {};
  const name = part?.name ?? part;
  const isOfLimb = ends().some(({ limb }) => limb.includes(name));
  return interaction.drag?.carries || isOfLimb ? [] : [CARRY];
}

const ends = () => server.body?.handles.filter(({ kind }) => kind === 'end') ?? [];

/** Keys and words for the status bar: [[key, words], …]. */
export function hintsFor(tool, dragging, layout) {
  const kind = dragging ? (interaction.panning ? 'pan' : interaction.drag?.hint) : null;
  if (!kind && layout === 'free') return IN_FREE_VIEW;
  const hints = HOLDING[kind]?.((interaction.drag?.axis ?? '').toUpperCase()) ?? restingHints(tool);
  return ends().length ? hints : hints.filter((one) => one !== CARRY);
}

function restingHints(tool) {
  if (tool !== 'select' || !server.body || ends().length) {
    return DRAWING[tool]?.hints ?? IDLE_TOOL_HINTS[tool] ?? IDLE_TOOL_HINTS.select;
  }
  return boxCornersIn(viewNamed('main')).length ? RESTING_ON_BOX : RESTING_ON_THING;
}

/** What a drag on a part's surface does with a tool. */
export function surfaceTool(tool, isRoot) {
  if (tool === 'move' || tool === 'ends') return tool;
  // One picks up a body by its middle and a limb to turn it.
  return tool === 'select' && isRoot ? 'move' : 'rotate';
}
