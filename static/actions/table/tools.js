// Tools, and the part that is selected.

import { partNamed, selectedPart } from '../../store/parts.js';
import { setUi, ui } from '../../store/state.js';
import { alongChain, endOfChain, otherSide, outward } from '../chain.js';
import { hasNoChild, isRoot, noOtherSide } from '../reasons.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const TOOLS = {
  select: { also: 'pointer cursor tool arrow', alone: 'Select tool', label: 'Select', icon: 'sel', keys: ['V'], ...tool('select') },
  rotate: { also: 'turn spin tool rings gizmo', alone: 'Rotate tool', label: 'Rotate', icon: 'rot', keys: ['R'], ...tool('rotate') },
  move: {
    label: 'Move body', title: 'Move or turn the whole body, hands and feet go along', icon: 'move', keys: ['G'], ...tool('move'),
    also: 'translate position root grab whole body',
  },
  ends: { also: 'ik inverse kinematics pull limbs tool', label: 'Drag hands and feet', icon: 'ik', keys: ['E'], ...tool('ends') },
  size: { also: 'scale resize lengths tool bones', alone: 'Sizes tool', label: 'Sizes', icon: 'size', keys: ['S'], ...tool('size') },
  pan: { also: 'hand scroll tool', alone: 'Pan tool', label: 'Pan and zoom', icon: 'hand', ...tool('pan') },
  otherSide: {
    also: 'mirror opposite left right select',
    label: 'Other side of the body', icon: 'mirror', keys: ['Q'], repeats: true, off: noOtherSide, run: otherSide,
  },
  inward: {
    also: 'parent up chain select',
    label: () => towards('body', partNamed(selectedPart()?.parent)), icon: 'sb', keys: ['['], row: 'Along the limb',
    repeats: true, off: isRoot, run: () => alongChain(-1),
  },
  outward: {
    also: 'child down chain select',
    label: outwardLabel, icon: 'sf', keys: [']'],
    row: 'Along the limb', repeats: true, off: hasNoChild, run: () => alongChain(1),
  },
};

function tool(name) {
  return { on: () => ui.tool === name, run: () => setUi('tool', name) };
}

const towards = (end, part) => `Towards the ${end}${part ? `: ${part.label.toLowerCase()}` : ''}`;

function outwardLabel() {
  const part = selectedPart();
  const child = part && outward(part);
  return child ? towards(endOfChain(part).short.toLowerCase(), child) : 'Towards the end of the limb';
}
