// The camera of a session about surfaces: nobody filmed with it.

import { html } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { shortNumber } from '../controls/fields.js';
import { fact, section } from './section.js';

export function virtualCamera() {
  const { width, height, fov_deg: deg } = server.camera;
  return section(
    'Virtual camera',
    html`${fact('Picture', `${width} × ${height}`, 'Pixels')}
      ${fact('Angle', `${shortNumber(deg, 1)}°`, 'How much of the scene its longer side sees')}
      <p class="note">
        No camera filmed this. The picture is drawn as one would see it that stands in front of the
        first surface; the fit does not depend on it.
      </p>`,
  );
}
