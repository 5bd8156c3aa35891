// Motion, films, pictures and reports as files.

import { server, setUi, ui } from '../../store/state.js';
import { words } from '../../store/subject.js';
import { askWhatIsMissing, usualOptions } from '../exporting.js';
import { FILTER_HZ, hasMotion, saveMotion, saveReport } from '../export.js';

/** @typedef {import('./action.js').Action} Action */

/** The file formats of motion; what writes them is in `app/export/motion_formats.py`. Those that are rigged have bones;
 * what some need is an extra of the same name. */
export const MOTION = {
  saveBvh: { ...motion('bvh', 'bone', 'Blender, MotionBuilder, Daz', 'The file cannot say where in the video it begins'), rigged: true },
  saveGlb: { ...motion('glb', 'both', 'Blender, Unreal, Unity, web'), rigged: true },
  saveUsd: { ...motion('usd', 'both', 'Omniverse, Houdini, Maya', 'In Blender, set the frame rate to the video’s'), rigged: true, needs: 'usd-core' },
  saveTrc: motion('trc', 'trail', 'OpenSim'),
  saveMot: motion('mot', 'rot', 'OpenSim joint angles'),
  saveC3d: { ...motion('c3d', 'ghost', 'motion laboratories'), needs: 'ezc3d' },
  saveCsv: motion('csv', 'copy', 'joints, angles, verdicts'),
  saveNpz: motion('npz', 'quad', 'NumPy'),
  saveAmass: motion('amass', 'ghost', 'SMPL, motion research'),
  saveCamera: { ...motion('camera', 'camcorder', 'rotomation, JSON'), label: 'Camera' },
  saveChan: motion('chan', 'camcorder', 'the camera for Nuke'),
};

/** @satisfies {Record<string, Action>} */
export const EXPORT = {
  saveAllMotion: {
    label: 'All formats, ZIP', icon: 'exp',
    off: () => (hasMotion() ? '' : `${words().verb} first: there is no motion yet`), run: () => saveMotion('all'),
  },
  exportFilm: exportDialog('film', 'Film…', 'film'),
  exportImages: exportDialog('pictures', 'Images of all keyframes…', 'img'),
  exportSheet: exportDialog('sheet', 'Keyframe sheet…', 'quad'),
  exportMotion: exportDialog('motion', 'With options…', 'track'),
  filterMotion: {
    label: `Low-pass filter, ${FILTER_HZ} Hz`,
    title: 'Removes faster motion without delay; keyframes move a little',
    on: () => ui.filterMotion === true, run: () => setUi('filterMotion', ui.filterMotion !== true),
  },
  saveReport: {
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
