// The tools, their keys, and what to say about them in the status bar.

import { hold } from './hold.js';

export const TOOLS = [
  { name: 'select', icon: 'sel', label: 'Select', key: 'V' },
  { name: 'rotate', icon: 'rot', label: 'Rotate', key: 'R' },
  { name: 'move', icon: 'move', label: 'Move the body', key: 'G' },
  { name: 'ends', icon: 'ik', label: 'Drag hands and feet', key: 'E' },
  { name: 'size', icon: 'size', label: 'Sizes', key: 'S' },
];

export const PAN = { name: 'pan', icon: 'hand', label: 'Pan and zoom', key: 'Space' };

const FINE = ['Shift', 'fine, one tenth'];
const BACK = ['Esc', 'take back'];
const DEPTH = ['D', 'nearer or farther'];
const DEGREES = ['Ctrl', '5° steps'];
const CENTIMETRES = ['Ctrl', '1 cm steps'];
const FREE = ['U', 'limits off'];
const LIMB = ['Double-click', 'the limb'];

const RESTING = {
  select: [['Click', 'select, again: what is behind'], LIMB, ['Drag', 'turn a part, carry the waist']],
  rotate: [['Drag', 'turn about its joint'], FINE, DEGREES, FREE],
  move: [['Drag', 'move in the picture plane'], FINE, DEPTH, BACK],
  ends: [['Drag', 'pull a hand or foot, the limb follows'], DEPTH, FINE, CENTIMETRES],
  size: [['Drag', 'cap: length, rim: radius, cross: joint'], FINE, CENTIMETRES, BACK],
  pan: [['Drag', 'push the picture'], ['Wheel', 'zoom at the pointer'], ['0', 'fit']],
  mask: [['Click', 'corner'], ['Enter', 'close'], ['Backspace', 'last corner away'], ['Esc', 'leave']],
  vertical: [['Drag', 'along something upright'], ['Esc', 'leave']],
};

const HOLDING = {
  ring: (axis) => [['Drag', `turn about ${axis}`], FINE, DEGREES, FREE, BACK],
  turn: () => [['Drag', 'turn about its joint'], ['X Y Z', 'one axis'], FINE, DEGREES, FREE, BACK],
  root: () => [['Drag', 'move in the picture plane'], FINE, DEPTH, CENTIMETRES, BACK],
  end: () => [['Drag', 'pull, the limb follows'], DEPTH, FINE, CENTIMETRES, BACK],
  joint: () => [['Drag', 'swing the joint, its end stays'], FINE, BACK],
  size: () => [['Drag', 'longer or thicker'], FINE, CENTIMETRES, BACK],
  mask: () => [['Drag', 'move'], FINE, BACK],
  pan: () => [['Drag', 'push the picture']],
};

/** Keys and words for the status bar: [[key, words], …]. */
export function hintsFor(tool, dragging) {
  const kind = dragging ? (hold.panning ? 'pan' : hold.drag?.hint) : null;
  if (HOLDING[kind]) return HOLDING[kind]((hold.drag?.axis ?? '').toUpperCase());
  return RESTING[tool] ?? RESTING.select;
}

/** What a drag on a part's surface does with a tool. */
export function surfaceTool(tool, isRoot) {
  if (tool === 'move' || tool === 'ends') return tool;
  // One picks up a body by its middle and a limb to turn it.
  return tool === 'select' && isRoot ? 'move' : 'rotate';
}
