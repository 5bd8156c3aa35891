// The lens: by its field of view or by its intrinsics, and its distortion; of surfaces the virtual
// camera that nobody filmed with.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { iconButton, segmented, shortNumber } from '../controls/fields.js';
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
  const known = ui.lens ?? (server.camera.origin === 'intrinsics' ? 'intrinsics' : 'view');
  const choice = segmented({
    label: 'Defined by', value: known, act: (id) => setUi('lens', id),
    options: [
      { id: 'view', label: 'Field of view', title: 'How wide the camera sees. Enough for most videos' },
      { id: 'intrinsics', label: 'Intrinsics', title: 'Focal lengths and centre from a calibration' },
    ],
  });
  return html`${section('Lens', html`
    ${line('Defined by', choice)}${known === 'view' ? fieldOfView() : INTRINSICS.map(intrinsic)}${telephoto()}
  `)}${distortion()}`;
}

function fieldOfView() {
  const { fov_deg: deg, fx, width, height, origin } = server.camera;
  const side = width >= height ? 'width' : 'height';
  const spec = {
    key: 'fov', label: 'Angle', text: 'Angle', value: deg, unit: '°', step: 0.5, coarse: 5, min: 1, max: 170,
    title: `Angle across the image’s ${side}. Main phone cameras: about 65°`,
    edit: (value) => ({ do: 'field_of_view', deg: value }),
  };
  return html`${measure(spec, [10, 120])}${fact('Focal', `${shortNumber(fx, 1)} px`, 'What the angle amounts to')}
    ${origin === 'guess' ? html`<p class="note">A guess. Better numbers give better depth.</p>` : nothing}`;
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
