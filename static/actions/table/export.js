// Motion, films, pictures and reports as files.

import { server, setUi, ui } from '../../store/state.js';
import { words } from '../../store/clip.js';
import { FORMATS } from '../../store/orders.js';
import {
  askWhatIsMissing,
  FILTER_HZ,
  hasMotion,
  saveMotion,
  saveReport,
  usualExport,
  whyNoMatte,
} from '../exporting.js';

/** @typedef {import('./action.js').Action} Action */

/** @typedef {import('../../store/orders.js').FormatName} FormatName */

/** The action that saves a format. @param {string} format */
export const motionAction = (format) =>
  /** @type {`save${Capitalize<FormatName>}`} */ (`save${format[0].toUpperCase()}${format.slice(1)}`);

/** Saves the motion in each of the formats: saveBvh and so on. */
export const MOTION = /** @type {Record<`save${Capitalize<FormatName>}`, Action>} */ (
  Object.fromEntries(
    Object.entries(FORMATS).map(([format, { label, icon, also, alone }]) => [
      motionAction(format),
      { label, icon, also, alone, off: whyNoMotion, run: () => saveMotion(format) },
    ]),
  )
);

/** @satisfies {Record<string, Action>} */
export const EXPORT = {
  saveAllMotion: {
    also: 'everything zip download',
    label: 'All formats, ZIP',
    icon: 'exp',
    off: whyNoMotion,
    run: () => saveMotion('all'),
  },
  exportFilm: { ...exportDialog('film', 'Film…', 'film'), also: 'video movie mp4 gif webm render overlay clip' },
  exportImages: {
    ...exportDialog('pictures', 'Images of all keyframes…', 'img'),
    also: 'pictures stills frames png jpg',
  },
  exportSheet: { ...exportDialog('sheet', 'Keyframe sheet…', 'quad'), also: 'contact sheet overview poses print' },
  exportMatte: {
    ...exportDialog('matte', 'Matte of the person…', 'crop'),
    off: whyNoMatte,
    also: 'alpha mask cutout transparent background removal roto silhouette webm prores png sequence',
  },
  exportMotion: {
    ...exportDialog('motion', 'With options…', 'track'),
    also: 'options unit rig fps rate scale up axis fbx retarget character skeleton',
  },
  filterMotion: {
    also: 'smooth butterworth noise jitter export',
    alone: 'Low-pass filter in exports',
    label: `Low-pass filter, ${FILTER_HZ} Hz`,
    title: 'Removes faster motion without delay; keyframes move a little',
    on: () => ui.filterMotion === true,
    run: () => setUi('filterMotion', ui.filterMotion !== true),
  },
  saveReport: {
    also: 'export html pdf print summary results',
    alone: 'Export the report as HTML',
    label: 'Report, HTML',
    icon: 'film',
    run: saveReport,
    off: () => (server.keys?.frames.length ? '' : 'Add a keyframe first'),
  },
};

function whyNoMotion() {
  return hasMotion() ? '' : `${words().verb} first: there is no motion yet`;
}

function exportDialog(what, label, icon) {
  const off = () => (server.keys?.frames.length ? '' : 'Add a keyframe first');
  return { label, icon, off, run: () => openExport(what) };
}

function openExport(what) {
  askWhatIsMissing();
  setUi('exporting', { ...usualExport(), what, ...(ui.exportJob ? { what: ui.exportJob.what } : {}) });
}
