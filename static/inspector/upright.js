// What is up: as the camera holds it, by a line drawn on the picture, or so that feet stand level.

import { html } from '../vendor/lit-html/lit-html.js';
import { server, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { dropdown, shortNumber } from '../controls/fields.js';
import { drawingButton, fact, line, section } from './section.js';

export function upright() {
  const { tilt_deg: tilt, roll_deg: roll, up_origin: origin } = server.camera;
  return section(
    'Up direction',
    html`${line('Set by', dropdown({
      label: 'Up direction set by', value: origin, act: setBy,
      options: [{ id: 'camera', label: 'Camera' }, { id: 'drawn', label: 'Drawn line' },
        { id: 'feet', label: 'Pinned feet' }],
      title: 'Which way is up in the top, side and front views',
    }))}
    ${fact('Tilt', `${shortNumber(tilt, 1)}°`, 'How far the camera looks down')}
    ${fact('Roll', `${shortNumber(roll, 1)}°`, 'How far the camera leans to one side')}
    ${drawingButton('vertical', {
      name: 'mid', label: 'Draw a vertical in the image', busy: 'Drag along something upright',
      title: 'Drag along a door frame, a wall’s edge, a lamp post. Shows the roll: draw the horizon where the camera looks down',
    })}
    ${drawingButton('horizon', {
      name: 'floor', label: 'Draw the horizon', busy: 'Drag along the horizon',
      title: 'Where level ground ends far away: gives tilt and roll, and with a standing foot the floor',
    })}`,
  );
}

function setBy(id) {
  if (id === 'camera') send({ do: 'reset_up' });
  else if (id === 'feet') send({ do: 'up_from_feet' });
  else setUi('tool', 'horizon');
}
