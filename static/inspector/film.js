// How the film was taken, where its file does not say so: its rate, its fields, what is up.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { checkbox, dropdown, iconButton, shortNumber } from '../controls/fields.js';
import { send } from '../store/link.js';
import { server, setUi } from '../store/state.js';
import { drawingButton, fact, line, measure, section } from './section.js';

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

const SLOWEST_FPS = 0.001;
const FASTEST_FPS = 1e6;

const readFilm = (change) => ({ do: 'read_film', ...change });

export function film() {
  const { fps, taken } = server.file;
  const spec = {
    key: 'recorded_fps', label: 'Recorded at', text: 'Recorded', value: fps, unit: '/s',
    decimals: Number.isInteger(fps) ? 0 : 2, step: 1, coarse: 10, min: SLOWEST_FPS, max: FASTEST_FPS,
    title: 'Frames per second at which it was recorded, such as 240 for slow motion. All times and speeds follow',
    edit: (value) => readFilm({ recorded_fps: value }),
  };
  const reset = iconButton({
    name: 'reset', label: 'Rate as the file says', act: () => send(readFilm({ recorded_fps: null })),
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
    label: 'Deinterlace', on: deinterlace, act: (on) => send(readFilm({ deinterlace: on })),
    title: 'The video is marked interlaced: each frame holds two moments. Switch off where it is progressive all the same',
  });
}

function imageNotes({ depth, numbering }) {
  return html`${depth === null ? nothing : note(`${depth} of 16 bits are used: they are spread to the full range.`)}
    ${numbering ? note(numbering) : nothing}`;
}

/** Without zeros at its end. @param {number} value */
const rounded = (value) => Number(value.toFixed(2));

const note = (words) => html`<p class="note">${words}</p>`;
