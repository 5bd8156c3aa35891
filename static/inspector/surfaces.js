// How the body is fitted to observed surfaces, which of them moves with it, and how their files are
// read: what the Track tab shows instead of what only films need.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { actionBox } from '../actions/buttons.js';
import { send } from '../store/link.js';
import { icon } from '../controls/icons.js';
import { button, dropdown, segmented, shortNumber } from '../controls/fields.js';
import { qualityLine } from './method.js';
import { fact, line, measure, section } from './section.js';

const WEIGHTS = [
  { id: 'both', label: 'Contact and cameras', note: 'best' },
  { id: 'contact', label: 'Contact', note: 'no images needed' },
  { id: 'photo', label: 'Cameras' },
  { id: 'none', label: 'None', note: 'plain fit' },
];

const DISTANCES = [
  { id: 'plane', label: 'To the surface', title: 'Along the surface normal. Converges faster' },
  { id: 'point', label: 'To points', title: 'To the nearest surface point' },
];

const BINDINGS = [
  { id: 'nearest', label: 'One part', title: 'Each surface point moves with the nearest part' },
  { id: 'smooth', label: 'Blended', title: 'Near a joint the surface moves with both parts' },
];

const UNITS = [
  ['m', 'Metres'],
  ['dm', 'Decimetres'],
  ['cm', 'Centimetres'],
  ['mm', 'Millimetres'],
  ['in', 'Inches'],
  ['ft', 'Feet'],
].map(([id, label]) => ({ id, label }));

const AXES = ['+y', '+z', '+x', '-y', '-z', '-x'].map((id) => ({
  id,
  label: id.replace('-', '−').toUpperCase(),
}));

const observe = (change) => send({ do: 'observe', ...change });

export function surfaces() {
  return html`${fitting()}${moving()}${files()}`;
}

function fitting() {
  const { weights, distance, binding } = server.surface;
  return section(
    'Fit',
    html`${line(
      'Weights',
      dropdown({
        label: 'Weights',
        value: weights,
        options: WEIGHTS,
        act: (id) => observe({ weights: id }),
        title: 'Where the surface counts less: near other parts, or where cameras disagree',
      }),
    )}
    ${line(
      'Distance',
      segmented({
        label: 'Distance',
        value: distance,
        options: DISTANCES,
        act: (id) => observe({ distance: id }),
      }),
    )}
    ${line(
      'Binding',
      segmented({
        label: 'Binding',
        value: binding,
        options: BINDINGS,
        act: (id) => observe({ binding: id }),
      }),
    )}
    ${qualityLine()}
    ${actionBox('live')}`,
  );
}

/** The surface of one keyframe is what moves with the body. */
function moving() {
  const { model_frame: model, rims } = server.surface;
  const { frame } = server.view;
  const isKey = server.keys?.frames.includes(frame);
  const off = frame === model ? 'This frame’s surface is used already' : isKey ? '' : 'Add a keyframe here first (K)';
  if (model === null) {
    return section(
      'Moving surface',
      html`<p class="note">
      Pose the body in a complete surface and press K. That surface then moves with the body.
    </p>`,
    );
  }
  return section(
    'Moving surface',
    html`
    ${fact('Surface of', `frame ${model}`, 'Moves with the body from its pose there')}
    ${rims ? holes(model, rims) : nothing}
    ${button({
      name: 'flag',
      label: frame === model ? 'Use another frame' : `Use frame ${frame}`,
      kind: 'full',
      off,
      title: 'Use the surface of this keyframe as the one that moves',
      act: () => observe({ model_frame: frame }),
    })}`,
  );
}

function holes(model, rims) {
  return warning(html`The surface of frame ${model} has holes (${rims} open edges), which are then missing at
    every frame. Use a keyframe with a complete surface.`);
}

const warning = (words) => html`<p class="note warned" role="status">${icon('warn')}<span>${words}</span></p>`;

function files() {
  const { units, up, fps, middle, cameras, faces, unusable } = server.surface;
  const rate = {
    key: 'surface.fps',
    label: 'Rate',
    value: fps,
    unit: '/s',
    step: 1,
    coarse: 5,
    min: 0.01,
    max: 10000,
    title: 'Surfaces per second',
    edit: (value) => ({ do: 'observe', fps: value }),
  };
  return section(
    'Files',
    html`${unusable ? warning(unusable) : nothing}
    ${line(
      'Units',
      dropdown({
        label: 'Units',
        value: units,
        options: UNITS,
        act: (id) => observe({ units: id }),
        title: 'The unit of the files. Poses are scaled too',
      }),
    )}
    ${line(
      'Up axis',
      dropdown({
        label: 'Up axis',
        value: up,
        options: AXES,
        title: 'The axis that points up in the files',
        act: (id) => observe({ up: id, ...(middle ? { about: middle } : {}) }),
      }),
    )}
    ${measure(rate)}
    ${cameras ? fact('Cameras', cameras, 'Their images show which parts of the surface can be trusted') : nothing}
    ${faces ? fact('Here', `${shortNumber(faces, 0)} faces`, 'Of the surface at this frame') : nothing}`,
  );
}
