// How to track.

import { html } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { actionBox } from '../actions/buttons.js';
import { send } from '../store/link.js';
import { checkbox, dropdown, segmented } from '../controls/fields.js';
import { line, section } from './section.js';

const METHODS = [
  { id: 'keypose', label: 'Keypose', note: 'best' },
  { id: 'paper', label: 'As published', note: 'for comparison' },
];

const QUALITIES = [
  { id: 'full', label: 'Full', title: 'Best accuracy' },
  { id: 'preview', label: 'Preview', title: 'A quick look' },
];

export function method() {
  const { method: name } = server.settings;
  return section(
    'Method',
    html`${line(
      'Method',
      dropdown({
        label: 'Method',
        value: name,
        options: METHODS,
        act: (id) => send({ do: 'settings', method: id }),
      }),
    )}
    ${qualityLine(name === 'paper' ? 'The published method has only one quality' : '')}
    ${smooth()}
    ${actionBox('live')}`,
  );
}

function smooth() {
  return checkbox({
    label: 'Smooth in space',
    on: server.settings.smooth,
    title: 'Motion as smooth as bodies move, as far as the pictures allow. Keyframes are kept',
    act: (on) => send({ do: 'settings', smooth: on ? true : null }),
  });
}

/** How much work is done; off: why it cannot be chosen. */
export function qualityLine(off = '') {
  return line(
    'Quality',
    segmented({
      label: 'Quality',
      value: off ? null : server.settings.quality,
      options: QUALITIES,
      off,
      act: (id) => send({ do: 'settings', quality: id }),
    }),
  );
}
