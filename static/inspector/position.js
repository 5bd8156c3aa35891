// Where the root stands before the camera, in metres: across and up in the picture, and depth.

import { html } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { iconButton } from '../controls/fields.js';
import { measure, section } from './section.js';

const NEAREST_M = 0.05;

export function position() {
  // The camera's y runs down; people say how high.
  const rows = [
    { label: 'Across', axis: 'x', sign: 1, title: 'To the right of the image centre' },
    { label: 'Up', axis: 'y', sign: -1, title: 'Above the image centre' },
    { label: 'Depth', axis: 'z', sign: 1, title: 'Away from the camera', min: NEAREST_M },
  ];
  return section(
    'Position',
    html`${rows.map(place)}`,
    iconButton({
      name: 'reset', label: 'Move to the image centre',
      act: () => send({ do: 'root', x: 0, y: 0 }),
      off: server.pose ? '' : 'No pose at this frame',
    }),
  );
}

/** @param {{ label: string, axis: string, sign: number, title: string, min?: number }} row */
function place({ label, axis, sign, title, min }) {
  const value = server.pose ? sign * server.pose.root['xyz'.indexOf(axis)] : null;
  return measure({
    key: `${server.view.frame}.root.${axis}`,
    label,
    value,
    unit: 'm',
    decimals: 2,
    step: 0.01,
    coarse: 0.1,
    min,
    title: `${title}: drag sideways or type`,
    edit: (metres) => ({ do: 'root', [axis]: sign * metres }),
    off: server.pose ? '' : 'No pose at this frame',
  });
}
