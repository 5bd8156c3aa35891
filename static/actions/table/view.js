// Views, tools and the part that is selected; keys pressed during a drag.

import { partNamed, selectedPart } from '../../store/parts.js';
import { server, setUi, ui } from '../../store/state.js';
import { togglePainted, whyPainted } from '../../views/figure.js';
import { fitLarge, showLarge, VIEW_KEYS, VIEW_NAMES } from '../../views/views.js';
import { isCharted, toggleAngle, whyNoAngle } from '../angles.js';
import { copyPicture, savePicture } from '../exporting.js';
import { ringsAreShown } from '../keypoints.js';
import { alongChain, endOfChain, otherSide, outward } from '../parts.js';
import { hasNoChild, isRoot, noOtherSide } from '../tracking.js';
import { foldLanes } from '../window.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const TOOLS = {
  select: {
    also: 'pointer cursor tool arrow',
    alone: 'Select tool',
    label: 'Select',
    icon: 'sel',
    keys: ['V'],
    ...tool('select'),
  },
  rotate: {
    also: 'turn spin tool rings gizmo',
    alone: 'Rotate tool',
    label: 'Rotate',
    icon: 'rot',
    keys: ['R'],
    ...tool('rotate'),
  },
  move: {
    label: 'Move body',
    title: 'Move or turn the whole body, hands and feet go along',
    icon: 'move',
    keys: ['G'],
    ...tool('move'),
    also: 'translate position root grab whole body',
  },
  ends: {
    also: 'ik inverse kinematics pull limbs tool',
    label: 'Drag hands and feet',
    icon: 'ik',
    keys: ['E'],
    ...tool('ends'),
  },
  size: {
    also: 'scale resize lengths tool bones',
    alone: 'Sizes tool',
    label: 'Sizes',
    icon: 'size',
    keys: ['S'],
    ...tool('size'),
  },
  pan: { also: 'hand scroll tool', alone: 'Pan tool', label: 'Pan and zoom', icon: 'hand', ...tool('pan') },
  otherSide: {
    also: 'mirror opposite left right select',
    label: 'Other side of the body',
    icon: 'mirror',
    keys: ['Q'],
    repeats: true,
    off: noOtherSide,
    run: otherSide,
  },
  inward: {
    also: 'parent up chain select',
    label: () => towards('body', partNamed(selectedPart()?.parent)),
    icon: 'sb',
    keys: ['['],
    row: 'Along the limb',
    repeats: true,
    off: isRoot,
    run: () => alongChain(-1),
  },
  outward: {
    also: 'child down chain select',
    label: outwardLabel,
    icon: 'sf',
    keys: [']'],
    row: 'Along the limb',
    repeats: true,
    off: hasNoChild,
    run: () => alongChain(1),
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

/** The chart of a joint's angle. @param {string} joint @param {string} label @param {string} also */
function angle(joint, label, also) {
  return {
    label: `${label} angle`,
    icon: 'rot',
    also: `joint angle curve chart graph degrees clinical biomechanics coach range of motion flexion extension ${also}`,
    title: 'Over time, left and right, with its value at the joint; again: close',
    on: () => isCharted(joint),
    off: whyNoAngle,
    run: () => toggleAngle(joint),
  };
}

/** @satisfies {Record<string, Action>} */
export const ANGLES = {
  kneeAngle: angle('knee', 'Knee', 'leg bend'),
  hipAngle: angle('hip', 'Hip', 'thigh adduction abduction rotation'),
  ankleAngle: angle('ankle', 'Ankle', 'foot dorsiflexion plantarflexion'),
  shoulderAngle: angle('shoulder', 'Shoulder', 'arm adduction abduction'),
  elbowAngle: angle('elbow', 'Elbow', 'arm bend pronation'),
  trunkAngle: angle('trunk', 'Trunk', 'spine back bend lean'),
};

/** @satisfies {Record<string, Action>} */
export const VIEW = {
  mainView: { ...large('main'), also: 'picture video image camera' },
  topView: { ...large('top'), also: 'above bird plan' },
  sideView: { ...large('side'), also: 'profile left right' },
  frontView: { ...large('front'), also: 'face' },
  allViews: { also: 'quad four split', label: 'All four views', keys: ['5'], run: () => showLarge('quad') },
  freeView: {
    also: '3d perspective orbit space turntable',
    label: 'Free view',
    keys: ['6'],
    run: () => showLarge('free'),
  },
  orbitView: {
    also: '3d rotate view turntable',
    label: 'Orbit the free view',
    keys: ['Right drag'],
    handledBy: 'pointer',
  },
  wire: { ...mode('Wire'), also: 'wireframe lines display skeleton', alone: 'Show the body as wire' },
  solid: { ...mode('Solid'), also: 'shaded display mesh', alone: 'Show the body as solid' },
  both: { ...mode('Both'), also: 'display overlay', alone: 'Show the body as wire and solid' },
  nextMode: {
    also: 'display shading wireframe toggle',
    label: 'Wire, solid, both',
    keys: ['W'],
    message: () => ({ do: 'display', mode: nextOf(['wire', 'solid', 'both'], server.view.mode) }),
  },
  ghosts: {
    also: 'onion skin neighbours keyframes',
    label: 'Ghosts of the neighbouring keyframes',
    icon: 'ghost',
    keys: ['O'],
    row: 'Ghosts, trail, lanes',
    on: () => Boolean(server.view?.ghosts),
    message: () => ({ do: 'display', ghosts: !server.view.ghosts }),
  },
  trail: {
    also: 'path arc trajectory motion curve',
    label: 'Motion trail',
    icon: 'trail',
    keys: ['M'],
    row: 'Ghosts, trail, lanes',
    on: () => Boolean(server.view?.trail),
    message: () => ({ do: 'display', trail: !server.view.trail }),
  },
  rings: {
    also: 'keypoints detection landmarks dots joints',
    label: 'Show rings',
    icon: 'rings',
    title: 'Keypoints on the picture: drag one to correct it',
    on: ringsAreShown,
    run: () => setUi('rings', !ringsAreShown()),
  },
  personMask: {
    also: 'silhouette alpha matte segmentation outline overlay',
    label: 'Show the mask of the person',
    icon: 'person',
    title: 'Where the network sees the person, as the matte has it',
    on: () => ui.personMask === true,
    run: () => setUi('personMask', !ui.personMask),
  },
  floor: {
    also: 'ground grid plane',
    label: 'Floor',
    icon: 'floor',
    title: 'Floor in the camera view, cells of 25 cm',
    on: () => Boolean(server.view?.floor),
    message: () => ({ do: 'display', floor: !server.view.floor }),
  },
  paintBody: {
    also: 'webgl 3d 2d hardware acceleration gpu software slow speed canvas',
    label: 'Draw the body without 3D',
    title: 'Camera view: quicker where the browser’s 3D is done by software',
    off: whyPainted,
    on: () => ui.painted === true,
    run: togglePainted,
  },
  lanes: {
    also: 'rows timeline visibility collapse expand',
    label: () => (ui.lanes ? 'Collapse the lanes' : 'Show all lanes'),
    icon: 'chev',
    keys: ['I'],
    row: 'Ghosts, trail, lanes',
    run: foldLanes,
  },
  fitView: { also: 'zoom reset frame all home', label: 'Fit view', keys: ['0'], run: fitLarge },
  panView: { also: 'scroll move view', label: 'Pan', keys: ['Space drag'], row: 'Pan, zoom', handledBy: 'pointer' },
  zoomView: { also: 'magnify scale view', label: 'Zoom', keys: ['Wheel'], row: 'Pan, zoom', handledBy: 'pointer' },
  saveImage: {
    label: 'This view, PNG',
    icon: 'img',
    keys: ['Shift E'],
    row: 'Save, copy image',
    run: () => savePicture(),
    also: 'screenshot export picture frame still',
    alone: 'Save this view as PNG',
  },
  copyImage: {
    label: 'Copy this view',
    icon: 'clip',
    keys: ['Shift C'],
    row: 'Save, copy image',
    run: copyPicture,
    also: 'screenshot clipboard picture',
    alone: 'Copy this view as an image',
  },
  saveAllImages: {
    label: 'All four views, PNG',
    icon: 'quad',
    run: () => savePicture('all'),
    also: 'screenshot export four quad picture',
    alone: 'Save all four views as PNG',
  },
};

function large(name) {
  const keys = [VIEW_KEYS[name]];
  return { label: `${VIEW_NAMES[name]} view`, keys, row: 'Camera, top, side, front', run: () => showLarge(name) };
}

function mode(label) {
  const name = label.toLowerCase();
  return { label, icon: name, on: () => server.view?.mode === name, message: () => ({ do: 'display', mode: name }) };
}

const nextOf = (all, one) => all[(all.indexOf(one) + 1) % all.length];

/** @satisfies {Record<string, Action>} */
export const DRAGGING = {
  fine: { also: 'slow precise precision', label: 'Fine, one tenth', keys: ['Shift'], handledBy: 'drag' },
  snapAngle: {
    also: 'snap step degrees increments',
    label: '5° steps',
    keys: ['Ctrl'],
    row: '5° or 1 cm steps',
    handledBy: 'drag',
  },
  snapLength: {
    also: 'snap step grid increments',
    label: '1 cm steps',
    keys: ['Ctrl'],
    row: '5° or 1 cm steps',
    handledBy: 'drag',
  },
  depth: { also: 'distance z push pull', label: 'Nearer or farther', keys: ['D'], handledBy: 'drag' },
  carry: { also: 'unlock release ends follow', label: 'Take the rest along', keys: ['Alt'], handledBy: 'drag' },
  free: { also: 'unlock limits joint range', label: 'Ignore joint limits', keys: ['U'], handledBy: 'drag' },
  oneAxis: { also: 'constrain lock axis xyz', label: 'One axis', keys: ['X', 'Y', 'Z'], handledBy: 'drag' },
  cancelDrag: { alone: 'Cancel the drag', label: 'Cancel', keys: ['Escape'], handledBy: 'drag' },
};
