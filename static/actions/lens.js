// The lens of a film: by what kind of camera it is known, what is sent, and what it rests on.

import { shortNumber } from '../controls/arithmetic.js';
import { send } from '../store/link.js';
import { server, ui } from '../store/state.js';

/** Width of a frame of 35 mm film, by which lenses are compared. */
const FILM_MM = 36;

/** Focal lengths that are offered, mm on 35 mm film. */
export const FOCAL_MM = [10, 300];

/** What a stabiliser cuts off at the edges, about. */
const STABILISED = 1.1;

/**
 * @typedef {object} Kind  A kind of camera. Without `mm` nobody knows its lens.
 * @property {string} icon
 * @property {string} label
 * @property {string} detail
 * @property {number} [mm]  The usual one.
 * @property {[number, number]} [range]  The focal lengths that it is known by.
 * @property {boolean} [bent]  It bends straight edges.
 */

/** @type {Kind[]} */
export const KINDS = [
  { icon: 'phone', label: 'Phone, main', detail: '26 mm · usual', mm: 26, range: [20, 36] },
  { icon: 'phone', label: 'Phone, tele', detail: '48–120 mm · 2–5 ×', mm: 77, range: [37, 120] },
  { icon: 'phone', label: 'Ultrawide', detail: '13 mm · 0.5 ×', mm: 13, range: [4, 19] },
  { icon: 'camcorder', label: 'Camcorder', detail: '30–300 mm zoom', mm: 38, range: [121, 2000] },
  { icon: 'action', label: 'Action cam', detail: '16 mm, bent edges', mm: 16, bent: true },
  { icon: 'help', label: 'Don’t know', detail: 'guess from a pose' },
];

/** The kind that the present lens is taken for: as chosen here, else by its focal length. */
export function kindHere() {
  if (server.camera.lens_is_guess) return KINDS.find(({ mm }) => !mm);
  if (isBent()) return KINDS.find(({ bent }) => bent);
  const mm = Math.round(server.camera.focal_mm);
  const chosen = KINDS[ui.lensKind ?? -1];
  if (chosen?.mm && !chosen.bent) return chosen;
  return KINDS.find(({ range }) => range && range[0] <= mm && mm <= range[1]);
}

const isBent = () => server.camera.distortion.some((value) => value !== 0);

/** @param {Kind} kind */
export function chooseKind(kind) {
  ui.lensKind = KINDS.indexOf(kind);
  send(kind.mm ? { do: 'lens', mm: kind.mm, bent: Boolean(kind.bent) } : { do: 'lens', bent: false });
}

/** The lens that the file names. */
export const useFile = () => send({ do: 'lens', mm: server.file.lens.focal_mm, known: 'file' });

/** A stabilised film shows less than its lens. */
export const addForStabiliser = () => send({ do: 'lens', mm: rounded(server.camera.focal_mm * STABILISED) });

/** Nobody knows: kept as a guess, so that it is not asked again. */
export function keepLens() {
  if (server.camera.lens_source === null) send({ do: 'lens' });
}

/** The focal length as a number that is dragged or typed: for a field or a slider. */
export const focalSpec = () => ({
  key: 'lens',
  label: '35 mm equivalent',
  value: server.camera.focal_mm,
  unit: 'mm',
  decimals: 0,
  step: 1,
  coarse: 10,
  min: 4,
  max: 2000,
  edit: (mm) => ({ do: 'lens', mm: rounded(mm) }),
  title: 'The focal length that shows as much on 35 mm film',
});

const rounded = (mm) => Math.round(10 * mm) / 10;

/** Degrees that the picture shows across or down. */
export function degrees(side, focalMm = server.camera.focal_mm) {
  const { width, height } = server.camera;
  const share = { across: width, down: height }[side] / Math.max(width, height);
  return (360 / Math.PI) * Math.atan((FILM_MM / 2 / focalMm) * share);
}

/** "26 mm" */
export const millimetres = (mm) => `${shortNumber(mm, mm < 20 && mm % 1 ? 1 : 0)} mm`;

/** What the lens rests on, in words. */
export function sourceWords() {
  const { lens_source: source, lens_is_guess: isGuess, depth_share: share } = server.camera;
  if (isGuess) return `A guess. Distances rest on it: ± ${Math.round(100 * share)} %.`;
  const words = {
    file: `From the file: ${fileWords()}`,
    person: 'As you set it.',
    calibration: 'From a calibration.',
    fitted: 'Fitted to the keyframes.',
    turns: 'Estimated from how the camera moves.',
  };
  return words[source] ?? '';
}

/** "26 mm, Google Pixel 7" */
export function fileWords() {
  const { focal_mm: mm, device } = server.file.lens ?? { focal_mm: server.camera.focal_mm, device: '' };
  return `${millimetres(mm)}${device ? `, ${device}` : ''}`;
}

/** Whether the file names a lens and another is set. */
export const isFileOther = () => Boolean(server.file.lens && server.camera.lens_source !== 'file');

/** Whether fitting the sizes finds the focal length too: as chosen, else where it is a guess. */
export const fitsFocal = () => ui.fitFocal ?? Boolean(server.camera?.lens_is_guess);
