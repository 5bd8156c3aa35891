// How the body is fitted to observed surfaces, which of them moves with it, and how their files are
// read: what the Track tab shows instead of what only films need.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { icon } from '../controls/icons.js';
import { button, checkbox, dropdown, segmented, shortNumber } from '../controls/fields.js';
import { qualityLine } from './method.js';
import { fact, line, measure, section } from './section.js';

const WEIGHTS = [
  { id: 'both', label: 'Contact and cameras', note: 'best' },
  { id: 'contact', label: 'Contact', note: 'no images needed' },
  { id: 'photo', label: 'Cameras' },
  { id: 'none', label: 'Nothing', note: 'plain fit' },
];

const DISTANCES = [
  { id: 'plane', label: 'To the surface', title: 'Along the surface’s normal: quicker to settle' },
  { id: 'point', label: 'To points', title: 'To the nearest point of the surface' },
];

const BINDINGS = [
  { id: 'nearest', label: 'One part', title: 'Every place of the surface moves with the nearest part' },
  { id: 'smooth', label: 'Blended', title: 'Places near a joint move with both its parts' },
];

const UNITS = [
  ['m', 'Metres'], ['dm', 'Decimetres'], ['cm', 'Centimetres'], ['mm', 'Millimetres'],
  ['in', 'Inches'], ['ft', 'Feet'],
].map(([id, label]) => ({ id, label }));

const AXES = ['+y', '+z', '+x', '-y', '-z', '-x'].map((id) => ({
  id, label: id.replace('-', '−').toUpperCase(),
}));

const observe = (change) => send({ do: 'observe', ...change });

export function surfaces() {
  return html`${fitting()}${moving()}${files()}`;
}

function fitting() {
  const { weights, distance, binding } = server.surface;
  return section(
    'Fit',
    html`${line('Doubt by', dropdown({
      label: 'Doubt by', value: weights, options: WEIGHTS, act: (id) => observe({ weights: id }),
      title: 'What makes a place of the surface count less: nearness of other parts, cameras that do not agree',
    }))}
    ${line('Distance', segmented({
      label: 'Distance', value: distance, options: DISTANCES, act: (id) => observe({ distance: id }),
    }))}
    ${line('Bound to', segmented({
      label: 'Bound to', value: binding, options: BINDINGS, act: (id) => observe({ binding: id }),
    }))}
    ${qualityLine()}
    ${checkbox({
      label: 'Fit live while I pose', on: server.view.live, key: 'L',
      title: 'Fit the neighbouring segments each time a keyframe changes',
      act: (on) => send({ do: 'live', on }),
    })}`,
  );
}

/** The surface of one keyframe is what moves with the body. */
function moving() {
  const { model_frame: model, rims } = server.surface;
  const { frame } = server.view;
  const isKey = server.keys?.frames.includes(frame);
  const off = frame === model ? 'It is this frame’s already' : isKey ? '' : 'Make this frame a keyframe first: press K';
  if (model === null) {
    return section('Moving surface', html`<p class="note">
      Pose the body in one surface that is whole, and press K: that surface then moves with it.
    </p>`);
  }
  return section('Moving surface', html`
    ${fact('The surface that moves is that of', `frame ${model}`, 'Bound to the body as it is posed there')}
    ${rims ? holes(model, rims) : nothing}
    ${button({
      name: 'flag', label: frame === model ? 'Use another frame' : `Use frame ${frame}`, kind: 'full', off,
      title: 'Let the surface of this keyframe move with the body',
      act: () => observe({ model_frame: frame }),
    })}`);
}

function holes(model, rims) {
  return warning(html`The surface of frame ${model} is not whole: ${rims} edges are open. What is
    missing in it is missed at every frame. Better use a keyframe whose surface has no holes.`);
}

const warning = (words) => html`<p class="note warned" role="status">${icon('warn')}<span>${words}</span></p>`;

function files() {
  const { units, up, fps, middle, cameras, faces, unusable } = server.surface;
  const rate = {
    key: 'surface.fps', label: 'Rate', value: fps, unit: '/s', step: 1, coarse: 5, min: 0.01, max: 10000,
    title: 'Surfaces a second', edit: (value) => ({ do: 'observe', fps: value }),
  };
  return section(
    'Files',
    html`${unusable ? warning(unusable) : nothing}
    ${line('Units', dropdown({
      label: 'Units', value: units, options: UNITS, act: (id) => observe({ units: id }),
      title: 'What one unit of the files is; poses go along',
    }))}
    ${line('Upward', dropdown({
      label: 'Upward', value: up, options: AXES, title: 'The axis of the files that is up',
      act: (id) => observe({ up: id, ...(middle ? { about: middle } : {}) }),
    }))}
    ${measure(rate)}
    ${cameras ? fact('Cameras', cameras, 'Their images tell what is to be believed') : nothing}
    ${faces ? fact('Here', `${shortNumber(faces, 0)} faces`, 'Of the surface at this frame') : nothing}`,
  );
}
