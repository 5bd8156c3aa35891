// Motion, films, pictures and reports as files.

import { server, setUi, ui } from '../../store/state.js';
import { words } from '../../store/clip.js';
import {
  askWhatIsMissing, FILTER_HZ, hasMotion, saveMotion, saveReport, usualOptions,
} from '../exporting.js';

/** @typedef {import('./action.js').Action} Action */

/** The file formats of motion; what writes them is in `app/export/motion_formats.py`. Those that are rigged have bones;
 * what some need is an extra of the same name. */
export const MOTION = {
  saveBvh: {
    ...motion('bvh', 'bone', 'Blender, MotionBuilder, Daz', 'The file cannot say where in the video it begins'), rigged: true,
    also: 'export motion blender maya motionbuilder unreal unity animation mocap fbx', alone: 'Export BVH',
  },
  saveGlb: {
    ...motion('glb', 'both', 'Blender, Unreal, Unity, web'), rigged: true,
    also: 'export motion blender gltf unreal unity three web 3d animation rig armature skeleton mixamo metahuman vrm fbx', alone: 'Export GLB',
  },
  saveUsd: {
    ...motion('usd', 'both', 'Omniverse, Houdini, Maya', 'In Blender, set the frame rate to the video’s'), rigged: true, needs: 'usd-core',
    also: 'export motion usdz usdc openusd universal scene description omniverse houdini maya unreal animation', alone: 'Export USD',
  },
  saveTrc: { ...motion('trc', 'trail', 'OpenSim'), also: 'export motion opensim markers biomechanics', alone: 'Export TRC' },
  saveMot: { ...motion('mot', 'rot', 'OpenSim joint angles'), alone: 'Export joint angles as MOT' },
  saveC3d: {
    ...motion('c3d', 'ghost', 'motion laboratories'), needs: 'ezc3d',
    also: 'export motion vicon qualisys biomechanics lab markers', alone: 'Export C3D',
  },
  saveCsv: {
    ...motion('csv', 'copy', 'joints, angles, verdicts'),
    also: 'export motion table excel spreadsheet angles positions data', alone: 'Export CSV tables',
  },
  saveNpz: { ...motion('npz', 'quad', 'NumPy'), also: 'export motion numpy python arrays data', alone: 'Export NPZ' },
  saveAmass: {
    ...motion('amass', 'ghost', 'SMPL, motion research'),
    also: 'export motion smpl smplh smplx research npz poses', alone: 'Export AMASS, SMPL poses',
  },
  saveCamera: {
    ...motion('camera', 'camcorder', 'rotomation, JSON'), label: 'Camera',
    also: 'export camera rotomation matchmove json lens', alone: 'Export the camera as JSON',
  },
  saveChan: {
    ...motion('chan', 'camcorder', 'the camera for Nuke'),
    also: 'export camera nuke rotomation matchmove compositing', alone: 'Export the camera for Nuke',
  },
};

/** @satisfies {Record<string, Action>} */
export const EXPORT = {
  saveAllMotion: {
    also: 'everything zip download',
    label: 'All formats, ZIP', icon: 'exp',
    off: () => (hasMotion() ? '' : `${words().verb} first: there is no motion yet`), run: () => saveMotion('all'),
  },
  exportFilm: { ...exportDialog('film', 'Film…', 'film'), also: 'video movie mp4 gif webm render overlay clip' },
  exportImages: { ...exportDialog('pictures', 'Images of all keyframes…', 'img'), also: 'pictures stills frames png jpg' },
  exportSheet: { ...exportDialog('sheet', 'Keyframe sheet…', 'quad'), also: 'contact sheet overview poses print' },
  exportMotion: {
    ...exportDialog('motion', 'With options…', 'track'),
    also: 'options unit rig fps rate scale up axis fbx retarget character skeleton',
  },
  filterMotion: {
    also: 'smooth butterworth noise jitter export', alone: 'Low-pass filter in exports',
    label: `Low-pass filter, ${FILTER_HZ} Hz`,
    title: 'Removes faster motion without delay; keyframes move a little',
    on: () => ui.filterMotion === true, run: () => setUi('filterMotion', ui.filterMotion !== true),
  },
  saveReport: {
    also: 'export html pdf print summary results', alone: 'Export the report as HTML',
    label: 'Report, HTML', icon: 'film', run: saveReport,
    off: () => (server.keys?.frames.length ? '' : 'Add a keyframe first'),
  },
};

function motion(format, icon, reader, remark = '') {
  const off = () => (hasMotion() ? '' : `${words().verb} first: there is no motion yet`);
  return { label: format.toUpperCase(), icon, reader, remark, off, run: () => saveMotion(format) };
}

function exportDialog(what, label, icon) {
  const off = () => (server.keys?.frames.length ? '' : 'Add a keyframe first');
  return { label, icon, off, run: () => openExport(what) };
}

function openExport(what) {
  askWhatIsMissing();
  setUi('exporting', { ...usualOptions(), what, ...(ui.exportJob ? { what: ui.exportJob.what } : {}) });
}
