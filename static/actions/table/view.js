// Views and what is drawn in them.

import { server, setUi, ui } from '../../store/state.js';
import { fitLarge, showLarge, VIEW_KEYS, VIEW_NAMES } from '../../views/views.js';
import { copyPicture, savePicture } from '../export.js';
import { ringsAreShown } from '../keypoints.js';
import { foldLanes } from '../lanes.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const VIEW = {
  mainView: large('main'),
  topView: large('top'),
  sideView: large('side'),
  frontView: large('front'),
  allViews: { label: 'All four views', keys: ['5'], run: () => showLarge('quad') },
  freeView: { label: 'Free view', keys: ['6'], run: () => showLarge('free') },
  orbitView: { label: 'Orbit the free view', keys: ['Right drag'], handledBy: 'pointer' },
  wire: mode('Wire'),
  solid: mode('Solid'),
  both: mode('Both'),
  nextMode: {
    label: 'Wire, solid, both', keys: ['W'],
    message: () => ({ do: 'display', mode: nextOf(['wire', 'solid', 'both'], server.view.mode) }),
  },
  ghosts: {
    label: 'Ghosts of the neighbouring keyframes', icon: 'ghost', keys: ['O'], row: 'Ghosts, trail, lanes',
    on: () => Boolean(server.view?.ghosts), message: () => ({ do: 'display', ghosts: !server.view.ghosts }),
  },
  trail: {
    label: 'Motion trail', icon: 'trail', keys: ['M'], row: 'Ghosts, trail, lanes',
    on: () => Boolean(server.view?.trail), message: () => ({ do: 'display', trail: !server.view.trail }),
  },
  rings: {
    label: 'Show rings', icon: 'rings', title: 'Keypoints on the picture: drag one to correct it',
    on: ringsAreShown, run: () => setUi('rings', !ringsAreShown()),
  },
  floor: {
    label: 'Floor', icon: 'floor', title: 'Floor in the camera view, cells of 25 cm',
    on: () => Boolean(server.view?.floor), message: () => ({ do: 'display', floor: !server.view.floor }),
  },
  lanes: {
    label: () => (ui.lanes ? 'Collapse the lanes' : 'Show all lanes'), icon: 'chev', keys: ['I'],
    row: 'Ghosts, trail, lanes', run: foldLanes,
  },
  fitView: { label: 'Fit view', keys: ['0'], run: fitLarge },
  panView: { label: 'Pan', keys: ['Space drag'], row: 'Pan, zoom', handledBy: 'pointer' },
  zoomView: { label: 'Zoom', keys: ['Wheel'], row: 'Pan, zoom', handledBy: 'pointer' },
  saveImage: { label: 'This view, PNG', icon: 'img', keys: ['Shift E'], row: 'Save, copy image', run: () => savePicture() },
  copyImage: { label: 'Copy this view', icon: 'clip', keys: ['Shift C'], row: 'Save, copy image', run: copyPicture },
  saveAllImages: { label: 'All four views, PNG', icon: 'quad', run: () => savePicture('all') },
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
