// What is up: as the camera holds it, or along a line drawn on the picture.

import { html } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { button, dropdown, shortNumber } from '../controls/fields.js';
import { leaveSketch } from '../handles/sketch.js';
import { fact, line, section } from './section.js';

export function upright() {
  const { tilt_deg: tilt, roll_deg: roll, up_origin: origin } = server.camera;
  const drawing = ui.tool === 'vertical';
  return section(
    'Up direction',
    html`${line('Set by', dropdown({
      label: 'Up direction set by', value: origin, act: setBy,
      options: [{ id: 'camera', label: 'Camera' }, { id: 'drawn', label: 'Drawn vertical' }],
      title: 'Top, side and front stand upright along it',
    }))}
    ${fact('Tilt', `${shortNumber(tilt, 1)}°`, 'How far the camera looks down')}
    ${fact('Roll', `${shortNumber(roll, 1)}°`, 'How far the camera leans to one side')}
    ${button({
      name: 'mid', label: drawing ? 'Drag along something upright' : 'Draw a vertical on the picture',
      kind: drawing ? 'full on' : 'full',
      title: drawing ? 'Stop drawing' : 'Drag along a door frame, a wall’s edge, a lamp post',
      key: drawing ? 'Esc' : '',
      act: () => (drawing ? leaveSketch() : setUi('tool', 'vertical')),
    })}`,
  );
}

function setBy(id) {
  if (id === 'camera') send({ do: 'reset_up' });
  else setUi('tool', 'vertical');
}
