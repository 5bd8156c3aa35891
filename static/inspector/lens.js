// The lens: by its focal length, its field of view or its intrinsics, and its distortion; of surfaces the virtual
// camera that nobody filmed with.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import {
  degrees, fileWords, FOCAL_MM, focalSpec, isFileOther, millimetres, sourceWords, useFile,
} from '../actions/lens.js';
import { perform, whyNot } from '../actions/actions.js';
import { button, iconButton, numberField, segmented, shortNumber, slider } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { keyFrames } from '../actions/playhead.js';
import { fact, line, measure, section } from './section.js';

const COEFFICIENTS = ['k1', 'k2', 'p1', 'p2', 'k3'];

const INTRINSICS = [
  { key: 'fx', label: 'Focal x', min: 1 },
  { key: 'fy', label: 'Focal y', min: 1 },
  { key: 'cx', label: 'Centre x' },
  { key: 'cy', label: 'Centre y' },
];

export function lens() {
  // Until a person chooses, the way in which the camera came to be known.
  const known = ui.lens ?? (server.camera.origin === 'intrinsics' ? 'intrinsics' : 'lens');
  const choice = segmented({
    label: 'Known by', value: known, act: (id) => setUi('lens', id),
    options: [
      { id: 'lens', label: 'Lens', title: 'The focal length on 35 mm film, as phones and cameras state it' },
      { id: 'view', label: 'Field', title: 'How wide the camera sees' },
      { id: 'intrinsics', label: 'Pixels', title: 'Focal lengths and centre from a calibration' },
    ],
  });
  const ways = { lens: focal, view: fieldOfView, intrinsics: () => INTRINSICS.map(intrinsic) };
  return html`${section('Lens', html`
    ${line('Known by', choice)}${ways[known]()}${telephoto()}${source()}
  `)}${distortion()}`;
}

function focal() {
  const [min, max] = FOCAL_MM;
  const spec = focalSpec();
  return html`<div class="f w"><label class="cut" title=${spec.label}>35 mm eq.</label>${
    slider({ ...spec, min, max, zero: min, tick: false, log: true })}${numberField(spec)}</div>
    ${fact('Across', `${shortNumber(degrees('across'), 1)}°`, 'How wide the camera sees')}
    ${fact('Down', `${shortNumber(degrees('down'), 1)}°`, 'How high the camera sees')}
    ${fact('Depth', `+${shortNumber(100 / server.camera.focal_mm, 1)} % per mm`, 'A lens 1 mm longer puts everything so much farther away')}`;
}

/** What the lens rests on, and what may make it better. */
function source() {
  const { lens_is_guess: isGuess } = server.camera;
  const words = sourceWords();
  if (!words) return nothing;
  return html`<p class="note icons ${isGuess ? 'warned' : 'good'}">${icon(isGuess ? 'warn' : 'check')}<span>${words}</span></p>
    ${isFileOther() ? button({ name: 'film', label: `File says ${millimetres(server.file.lens.focal_mm)}: use it`, title: fileWords(), kind: 'full', act: useFile }) : nothing}
    ${isGuess && keyFrames().length > 1 ? button({
      name: 'wand', label: 'Fit sizes and focal length', kind: 'full', off: whyNot('fitSizes'), act: () => perform('fitSizes'),
      title: 'Estimate the focal length and the body’s sizes from all keyframes',
    }) : nothing}`;
}

function fieldOfView() {
  const { fov_deg: deg, fx, width, height } = server.camera;
  const side = width >= height ? 'width' : 'height';
  const spec = {
    key: 'fov', label: 'Angle', text: 'Angle', value: deg, unit: '°', step: 0.5, coarse: 5, min: 1, max: 170,
    title: `Angle across the image’s ${side}. Main phone cameras: about 65°`,
    edit: (value) => ({ do: 'field_of_view', deg: value }),
  };
  return html`${measure(spec, [10, 120])}${fact('Focal', `${shortNumber(fx, 1)} px`, 'What the angle amounts to')}`;
}

/** @param {{ key: string, label: string, min?: number }} one */
function intrinsic({ key, label, min }) {
  return measure({
    key: `camera.${key}`, label, value: server.camera[key], unit: 'px', step: 1, coarse: 10, min,
    edit: (value) => ({ do: 'camera', [key]: value }),
  });
}

function telephoto() {
  if (server.camera.projection !== 'telephoto') return nothing;
  const metres = shortNumber(server.camera.telephoto_distance_m, 1);
  return html`<p class="note">Telephoto: depth cannot be seen. The scale is exact at ${metres} m.</p>`;
}

function distortion() {
  const ideal = server.camera.distortion.every((value) => value === 0);
  const reset = () => send({ do: 'distortion', ...Object.fromEntries(COEFFICIENTS.map((k) => [k, 0])) });
  return section(
    'Distortion',
    html`${COEFFICIENTS.map((key, i) => coefficient(key, server.camera.distortion[i]))}`,
    iconButton({
      name: 'reset', label: 'Reset distortion', act: reset, off: ideal ? 'There is no distortion' : '',
    }),
  );
}

function coefficient(key, value) {
  return measure({
    key: `camera.${key}`, label: key, value, decimals: 4, step: 0.001, coarse: 0.01, perPixel: 0.0005,
    min: -1000, max: 1000,
    title: `${key[0] === 'k' ? 'Radial distortion' : 'Tangential distortion'}: drag sideways or type`,
    edit: (number) => ({ do: 'distortion', [key]: number }),
  });
}

export function virtualCamera() {
  const { width, height, fov_deg: deg } = server.camera;
  return section(
    'Virtual camera',
    html`${fact('Image', `${width} × ${height}`, 'Pixels')}
      ${fact('Angle', `${shortNumber(deg, 1)}°`, 'Field of view along the longer side')}
      <p class="note">
        A virtual camera in front of the first surface. The fit does not depend on it.
      </p>`,
  );
}
