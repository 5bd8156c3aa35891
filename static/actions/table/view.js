// Views and what is drawn in them.

import { server, setUi, ui } from '../../store/state.js';
import { fitLarge, showLarge, VIEW_KEYS, VIEW_NAMES } from '../../views/views.js';
import { copyPicture, savePicture } from '../export.js';
import { ringsAreShown } from '../keypoints.js';
import { foldLanes } from '../lanes.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const VIEW = {
  mainView: { ...large('main'), also: 'picture video image camera' },
  topView: { ...large('top'), also: 'above bird plan' },
  sideView: { ...large('side'), also: 'profile left right' },
  frontView: { ...large('front'), also: 'face' },
  allViews: { also: 'quad four split', label: 'All four views', keys: ['5'], run: () => showLarge('quad') },
  freeView: { also: '3d perspective orbit space turntable', label: 'Free view', keys: ['6'], run: () => showLarge('free') },
  orbitView: { also: '3d rotate view turntable', label: 'Orbit the free view', keys: ['Right drag'], handledBy: 'pointer' },
  wire: { ...mode('Wire'), also: 'wireframe lines display skeleton', alone: 'Show the body as wire' },
  solid: { ...mode('Solid'), also: 'shaded display mesh', alone: 'Show the body as solid' },
  both: { ...mode('Both'), also: 'display overlay', alone: 'Show the body as wire and solid' },
  nextMode: {
    also: 'display shading wireframe toggle',
    label: 'Wire, solid, both', keys: ['W'],
    message: () => ({ do: 'display', mode: nextOf(['wire', 'solid', 'both'], server.view.mode) }),
  },
  ghosts: {
    also: 'onion skin neighbours keyframes',
    label: 'Ghosts of the neighbouring keyframes', icon: 'ghost', keys: ['O'], row: 'Ghosts, trail, lanes',
    on: () => Boolean(server.view?.ghosts), message: () => ({ do: 'display', ghosts: !server.view.ghosts }),
  },
  trail: {
    also: 'path arc trajectory motion curve',
    label: 'Motion trail', icon: 'trail', keys: ['M'], row: 'Ghosts, trail, lanes',
    on: () => Boolean(server.view?.trail), message: () => ({ do: 'display', trail: !server.view.trail }),
  },
  rings: {
    also: 'keypoints detection landmarks dots joints',
    label: 'Show rings', icon: 'rings', title: 'Keypoints on the picture: drag one to correct it',
    on: ringsAreShown, run: () => setUi('rings', !ringsAreShown()),
  },
  floor: {
    also: 'ground grid plane',
    label: 'Floor', icon: 'floor', title: 'Floor in the camera view, cells of 25 cm',
    on: () => Boolean(server.view?.floor), message: () => ({ do: 'display', floor: !server.view.floor }),
  },
  lanes: {
    also: 'rows timeline visibility collapse expand',
    label: () => (ui.lanes ? 'Collapse the lanes' : 'Show all lanes'), icon: 'chev', keys: ['I'],
    row: 'Ghosts, trail, lanes', run: foldLanes,
  },
  fitView: { also: 'zoom reset frame all home', label: 'Fit view', keys: ['0'], run: fitLarge },
  panView: { also: 'scroll move view', label: 'Pan', keys: ['Space drag'], row: 'Pan, zoom', handledBy: 'pointer' },
  zoomView: { also: 'magnify scale view', label: 'Zoom', keys: ['Wheel'], row: 'Pan, zoom', handledBy: 'pointer' },
  saveImage: {
    label: 'This view, PNG', icon: 'img', keys: ['Shift E'], row: 'Save, copy image', run: () => savePicture(),
    also: 'screenshot export picture frame still', alone: 'Save this view as PNG',
  },
  copyImage: {
    label: 'Copy this view', icon: 'clip', keys: ['Shift C'], row: 'Save, copy image', run: copyPicture,
    also: 'screenshot clipboard picture', alone: 'Copy this view as an image',
  },
  saveAllImages: {
    label: 'All four views, PNG', icon: 'quad', run: () => savePicture('all'),
    also: 'screenshot export four quad picture', alone: 'Save all four views as PNG',
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
