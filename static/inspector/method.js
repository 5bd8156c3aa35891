// How to track.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { checkbox, dropdown, numberField, segmented, slider } from '../controls/fields.js';
import { start } from './start.js';
import { line, section } from './section.js';

const MOST_PASSES = 50;

const METHODS = [
  { id: 'keypose', label: 'Keypose', note: 'best' },
  { id: 'paper', label: 'As in the paper', note: 'to compare' },
];

const QUALITIES = [
  { id: 'full', label: 'Full', title: 'The best that can be had' },
  { id: 'fast', label: 'Fast', title: 'A little less exact, much sooner' },
  { id: 'preview', label: 'Preview', title: 'A first look' },
];

export function method() {
  const { method: name, static_camera: still } = server.settings;
  return section(
    'Method',
    html`${line('Method', dropdown({
      label: 'Method', value: name, options: METHODS, act: (id) => send({ do: 'settings', method: id }),
    }))}
    ${qualityLine(name === 'paper' ? 'The method of the paper knows one quality' : '')}
    ${start()}${passes()}
    ${checkbox({
      label: 'The camera stands still', on: still,
      title: 'A picture of the empty scene keeps other people and things out',
      act: (on) => send({ do: 'settings', static_camera: on }),
    })}
    ${checkbox({
      label: 'Track live while I pose', on: server.view.live, key: 'L',
      title: 'Track the neighbouring segments each time a keyframe changes',
      act: (on) => send({ do: 'live', on }),
    })}`,
  );
}

/** How much work is done; off: why it cannot be chosen. */
export function qualityLine(off = '') {
  return line('Quality', segmented({
    label: 'Quality', value: off ? null : server.settings.quality, options: QUALITIES, off,
    act: (id) => send({ do: 'settings', quality: id }),
  }));
}

function passes() {
  const { passes: chosen, default_passes: usual } = server.settings;
  const spec = {
    key: 'passes', label: 'Passes', value: chosen ?? usual, decimals: 0, step: 1, coarse: 5, perPixel: 0.2,
    min: 1, max: MOST_PASSES, zero: 1, tick: false,
    title: 'How often each segment is gone over; the best pass is kept',
    edit: (value) => ({ do: 'settings', passes: Math.round(value) }),
  };
  const automatic = segmented({
    label: 'Passes', value: chosen === null ? 'auto' : 'own',
    options: [
      { id: 'auto', label: 'Automatic', title: `The method’s own number, ${usual}` },
      { id: 'own', label: 'Own', title: 'Choose how many' },
    ],
    act: (id) => send({ do: 'settings', passes: id === 'auto' ? null : usual }),
  });
  const bar = slider({ ...spec, max: Math.max(20, chosen) });
  const own = html`<div class="f w"><label></label>${bar}${numberField(spec)}</div>`;
  return html`${line('Passes', automatic)}${chosen === null ? nothing : own}`;
}
