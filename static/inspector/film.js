// How the film was taken, where its file does not say so: its rate of recording, its fields, what its images lack.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { checkbox, iconButton } from '../controls/fields.js';
import { measure, section } from './section.js';

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
