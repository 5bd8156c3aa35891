// The lens and how the film was taken: focal length, field of view, distortion; rate, fields, up.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { perform, whyNot } from '../actions/actions.js';
import { actionButton } from '../actions/buttons.js';
import {
  degrees,
  fileWords,
  FOCAL_MM,
  focalSpec,
  isFileOther,
  millimetres,
  sourceWords,
  useFile,
} from '../actions/lens.js';
import { keyFrames } from '../actions/playhead.js';
import { liftWords, whyNotLift } from '../actions/standing.js';
import {
  button,
  checkbox,
  dropdown,
  iconButton,
  numberField,
  segmented,
  shortNumber,
  slider,
} from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';
import { drawingButton, fact, line, measure, section } from './section.js';

export function upright() {
  const { tilt_deg: tilt, roll_deg: roll, up_origin: origin, up_off_deg: off, up_is_sure: isSure } = server.camera;
  return section(
    'Up direction',
    html`${line(
      'Set by',
      dropdown({
        label: 'Up direction set by',
        value: origin,
        act: setBy,
        options: [
          { id: 'camera', label: 'Not known' },
          { id: 'level', label: 'Level camera' },
          { id: 'drawn', label: 'By hand' },
          { id: 'feet', label: 'Pinned feet' },
          ...(origin === 'found' ? [{ id: 'found', label: 'Found' }] : []),
        ],
        title: 'Which way is up in the top, side and front views',
      }),
    )}
    ${fact('Tilt', `${shortNumber(tilt, 1)}°`, 'How far the camera looks down')}
    ${fact('Roll', `${shortNumber(roll, 1)}°`, 'How far the camera leans to one side')}
    ${
      off == null
        ? nothing
        : html`<p class="note icons ${isSure ? 'good' : 'warned'}">${icon(isSure ? 'check' : 'warn')}<span>${doubtWords(off)}</span></p>`
    }
    ${actionButton('findUp', undefined, { name: undefined, kind: 'full' })}
    ${drawingButton('vertical', {
      name: 'mid',
      label: 'Draw verticals in the image',
      busy: 'Drag along something upright',
      title: 'Drag along a door frame, a wall’s edge, a lamp post. One shows the roll, a second one the tilt as well',
    })}
    ${drawingButton('horizon', {
      name: 'floor',
      label: 'Draw the horizon',
      busy: 'Drag along the horizon',
      title: 'Where level ground ends far away: gives tilt and roll, and with a standing foot the floor',
    })}
    ${lifted()}`,
  );
}

/** Such as "Known to ± 2°", or what makes it surer. @param {number} off */
function doubtWords(off) {
  const known = `Known to ± ${off}°`;
  return server.camera.up_is_sure ? known : `${known}. Draw the horizon to be surer`;
}

/** Drafts were found for another up direction than there is by now. */
function lifted() {
  if (whyNotLift()) return nothing;
  return html`<p class="note warned icons">${icon('warn')}<span>The drafts were found for another up direction. ${liftWords()}.</span></p>
    ${actionButton('lift', undefined, { name: undefined, kind: 'full' })}`;
}

function setBy(id) {
  if (id === 'camera') send({ do: 'reset_up' });
  else if (id === 'level') send({ do: 'level_camera' });
  else if (id === 'feet') send({ do: 'up_from_feet' });
  else if (id === 'found') perform('findUp');
  else setUi('tool', 'horizon');
}

const SLOWEST_FPS = 0.001;
const FASTEST_FPS = 1e6;

const readFilm = (change) => ({ do: 'read_film', ...change });

export function film() {
  const { fps, taken } = server.file;
  const spec = {
    key: 'recorded_fps',
    label: 'Recorded at',
    text: 'Recorded',
    value: fps,
    unit: '/s',
    decimals: Number.isInteger(fps) ? 0 : 2,
    step: 1,
    coarse: 10,
    min: SLOWEST_FPS,
    max: FASTEST_FPS,
    title: 'Frames per second at which it was recorded, such as 240 for slow motion. All times and speeds follow',
    edit: (value) => readFilm({ recorded_fps: value }),
  };
  const reset = iconButton({
    name: 'reset',
    label: 'Rate as the file says',
    act: () => send(readFilm({ recorded_fps: null })),
    off: taken.recorded_fps === null ? 'The rate is the file’s' : '',
  });
  return section('Video', html`${measure(spec)}${rateNote(fps, taken)}${fields(taken)}${imageNotes(taken)}`, reset);
}

/** @param {number} fps  @param {import('../store/shapes.js').Taken} taken */
function rateNote(fps, { file_fps: fileFps, recorded_fps: recorded }) {
  if (fileFps === null) return recorded === null ? note(`Images keep no rate: ${rounded(fps)} is assumed.`) : nothing;
  const factor = fps / fileFps;
  if (recorded === null || Math.abs(factor - 1) < 0.001) return nothing;
  const words = factor > 1 ? `${rounded(factor)} times slower` : `${rounded(1 / factor)} times faster`;
  return note(`The file shows it at ${rounded(fileFps)} fps, ${words}.`);
}

function fields({ interlaced, deinterlace }) {
  if (!interlaced) return nothing;
  return checkbox({
    label: 'Deinterlace',
    on: deinterlace,
    act: (on) => send(readFilm({ deinterlace: on })),
    title:
      'The video is marked interlaced: each frame holds two moments. Switch off where it is progressive all the same',
  });
}

function imageNotes({ depth, numbering }) {
  return html`${depth === null ? nothing : note(`${depth} of 16 bits are used: they are spread to the full range.`)}
    ${numbering ? note(numbering) : nothing}`;
}

/** Without zeros at its end. @param {number} value */
const rounded = (value) => Number(value.toFixed(2));

const note = (words) => html`<p class="note">${words}</p>`;

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
    label: 'Known by',
    value: known,
    act: (id) => setUi('lens', id),
    options: [
      { id: 'lens', label: 'Lens', title: 'The focal length on 35 mm film, as phones and cameras state it' },
      { id: 'view', label: 'Field', title: 'How wide the camera sees' },
      { id: 'intrinsics', label: 'Pixels', title: 'Focal lengths and centre from a calibration' },
    ],
  });
  const ways = { lens: focal, view: fieldOfView, intrinsics: () => INTRINSICS.map(intrinsic) };
  return section('Lens', html`${line('Known by', choice)}${ways[known]()}${telephoto()}${source()}`);
}

function focal() {
  const [min, max] = FOCAL_MM;
  const spec = focalSpec();
  return html`<div class="f w"><label class="cut" title=${spec.label}>35 mm eq.</label>${slider({
    ...spec,
    min,
    max,
    zero: min,
    tick: false,
    log: true,
  })}${numberField(spec)}</div>
    ${fact('Across', `${shortNumber(degrees('across'), 1)}°`, 'How wide the camera sees')}
    ${fact('Down', `${shortNumber(degrees('down'), 1)}°`, 'How high the camera sees')}
    ${fact(
      'Depth',
      `+${shortNumber(100 / server.camera.focal_mm, 1)} % per mm`,
      'A lens 1 mm longer puts everything so much farther away',
    )}`;
}

/** What the lens rests on, and what may make it better. */
function source() {
  const { lens_is_guess: isGuess } = server.camera;
  const words = sourceWords();
  if (!words) return nothing;
  return html`<p class="note icons ${isGuess ? 'warned' : 'good'}">${icon(isGuess ? 'warn' : 'check')}<span>${words}</span></p>
    ${
      isFileOther()
        ? button({
            name: 'film',
            label: `File says ${millimetres(server.file.lens.focal_mm)}: use it`,
            title: fileWords(),
            kind: 'full',
            act: useFile,
          })
        : nothing
    }
    ${
      isGuess && keyFrames().length > 1
        ? button({
            name: 'wand',
            label: 'Fit sizes and focal length',
            kind: 'full',
            off: whyNot('fitSizes'),
            act: () => perform('fitSizes'),
            title: 'Estimate the focal length and the body’s sizes from all keyframes',
          })
        : nothing
    }`;
}

function fieldOfView() {
  const { fov_deg: deg, fx, width, height } = server.camera;
  const side = width >= height ? 'width' : 'height';
  const spec = {
    key: 'fov',
    label: 'Angle',
    text: 'Angle',
    value: deg,
    unit: '°',
    step: 0.5,
    coarse: 5,
    min: 1,
    max: 170,
    title: `Angle across the image’s ${side}. Main phone cameras: about 65°`,
    edit: (value) => ({ do: 'field_of_view', deg: value }),
  };
  return html`${measure(spec, [10, 120])}${fact('Focal', `${shortNumber(fx, 1)} px`, 'What the angle amounts to')}`;
}

/** @param {{ key: string, label: string, min?: number }} one */
function intrinsic({ key, label, min }) {
  return measure({
    key: `camera.${key}`,
    label,
    value: server.camera[key],
    unit: 'px',
    step: 1,
    coarse: 10,
    min,
    edit: (value) => ({ do: 'camera', [key]: value }),
  });
}

function telephoto() {
  if (server.camera.projection !== 'telephoto') return nothing;
  const metres = shortNumber(server.camera.telephoto_distance_m, 1);
  return html`<p class="note">Telephoto: depth cannot be seen. The scale is exact at ${metres} m.</p>`;
}

/** Of the lens. */
export function distortion() {
  const ideal = server.camera.distortion.every((value) => value === 0);
  const reset = () => send({ do: 'distortion', ...Object.fromEntries(COEFFICIENTS.map((k) => [k, 0])) });
  return section(
    'Distortion',
    html`${COEFFICIENTS.map((key, i) => coefficient(key, server.camera.distortion[i]))}`,
    iconButton({
      name: 'reset',
      label: 'Reset distortion',
      act: reset,
      off: ideal ? 'There is no distortion' : '',
    }),
  );
}

function coefficient(key, value) {
  return measure({
    key: `camera.${key}`,
    label: key,
    value,
    decimals: 4,
    step: 0.001,
    coarse: 0.01,
    perPixel: 0.0005,
    min: -1000,
    max: 1000,
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
