// The dialog of imports: what was recognised, how to take it over, how far it is.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { beginImport, chooseImport, leaveImport, optionsOf, placesOfBody, whyNotBegin } from '../actions/importing.js';
import { mountDialog } from '../controls/dialogs.js';
import { dropdown } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { orderFields } from '../controls/order_form.js';
import { count, range } from '../controls/words.js';
import { frameCount } from '../store/clip.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { workUnderWay } from './job.js';

const KINDS = { motion: 'Recorded motion', keypoints: '2D keypoints', camera: 'Camera' };
const SIGNS = { motion: 'track', keypoints: 'ghost', camera: 'camcorder' };
export function mountImportDialog() {
  mountDialog({
    id: 'importing',
    label: 'Import',
    name: 'importing',
    names: ['file'],
    draw: () => (server.file ? dialog(ui.importing) : nothing),
  });
  watch(['file'], () => server.file || setUi('importing', null)); // what it was for is closed
}

function dialog(importing) {
  const { stage, name, found } = importing;
  return html`<form class="in" @submit=${submit} @keydown=${onKey}>
    <div class="row sheethead">
      <span class="title cut">Import ${name}</span><span class="sp"></span>
      <button type="button" class="ib" title="Close" data-key="Esc" aria-label="Close"
        @click=${leaveImport}>${icon('x')}</button>
    </div>
    ${
      found
        ? html`${recognised(found)}<div class="exfields"
      ?inert=${stage === 'importing'}>${fields(importing)}</div>`
        : empty(importing)
    }
    ${stage === 'importing' || stage === 'reading' ? progress(importing) : foot(importing)}
  </form>`;
}

/** @param {import('../controls/order_form.js').Values} changed */
const change = (changed) =>
  setUi('importing', { ...ui.importing, words: '', choices: { ...ui.importing.choices, ...changed } });

function submit(event) {
  event.preventDefault();
  const { stage, found, choices } = ui.importing;
  if (stage === 'choosing' && !whyNotBegin(found, choices, frameCount())) beginImport();
}

/** Enter in a field takes its text over first, with which it loses the focus. */
function onKey(event) {
  if (event.key === 'Enter' && event.target.matches('input.text')) requestAnimationFrame(() => submit(event));
}

// --- what was recognised

const empty = ({ stage, words }) => html`<div class="imempty">
  ${
    stage === 'failed'
      ? html`${icon('warn')}<span role="alert">${words}</span>`
      : html`<span class="dim">Looking at what it holds…</span>`
  }
</div>`;

function recognised({ kind, program, facts }) {
  return html`<div class="imfound">
    <span class="sign">${icon(SIGNS[kind])}</span>
    <div>
      <b>${KINDS[kind]}</b><span class="mut"> · ${program}</span>
      <div class="num">${SAID[kind](facts)}</div>
      ${kind === 'camera' ? nothing : names(facts)}
      ${(facts.notes ?? []).map((words) => html`<div class="checkword">${words}</div>`)}
    </div>
  </div>`;
}

const rateOf = (fps) => (fps ? ` at ${Number(fps.toFixed(2))} frames/s` : '');

const SAID = {
  motion: ({ frames, seconds, fps }) =>
    seconds === null
      ? `${count(frames, 'pose')}, one for each frame of the video`
      : `${count(frames, 'frame')}, ${seconds.toFixed(2)} s${rateOf(fps)}`,
  keypoints: ({ frames, first, last, fps, people }) => {
    const several = people > 1 ? `, up to ${people} people: the surest in each frame counts` : '';
    return `${count(frames, 'frame')} with keypoints, ${first === last ? first : range(first, last)}${rateOf(fps)}${several}`;
  },
  camera: ({ focal_mm: focal, across_deg: across, turned_deg: turned, floor_m: floor }) =>
    [
      `${focal.toFixed(1)} mm on 35 mm film, ${across.toFixed(1)}° across`,
      turned > 0.001 ? `up turned by ${turned.toFixed(1)}°` : 'up as it is',
      ...(floor === null ? [] : [`floor ${floor.toFixed(2)} m below the camera`]),
    ].join(' · '),
};

function names({ matched, left_out: left, convention }) {
  const known = Object.keys(matched).length;
  return html`<div class=${known ? '' : 'checkword'}>${known} of ${known + left.length} names known${
    known ? html`<span class="mut"> (${convention})</span>` : nothing
  }</div>`;
}

// --- the fields

function fields({ found, choices }) {
  const { options, further } = optionsOf(found);
  if (found.kind === 'camera') {
    return html`${orderFields(
      options,
      choices,
      change,
      further,
    )}<span class="dim imnote">What was posed keeps its place and its size in the picture. Ctrl Z undoes it.</span>`;
  }
  further.places.field = () => unknownNames(found.facts.left_out, choices.places);
  return orderFields(options, choices, change, further);
}

/** What a person knows of names that are not known. */
function unknownNames(left, places) {
  const options = [{ id: '', label: 'Not used' }, ...placesOfBody(server.body.parts)];
  const act = (name) => (id) => {
    const others = Object.entries(places).filter(([one]) => one !== name);
    change({ places: Object.fromEntries(id ? [...others, [name, id]] : others) });
  };
  const rows = left.map(
    (name) => html`<span class="cut" title=${name}>${name}</span>
    ${dropdown({
      label: `What ${name} is`,
      kind: 'field',
      search: true,
      value: places[name] ?? '',
      options,
      act: act(name),
    })}`,
  );
  return html`<div class="imnames" tabindex="-1">${rows}</div>`;
}

const BECOMES = {
  motion: 'An initial guess for tracking. Keyframes stay.',
  keypoints: 'Draft poses to confirm. Keyframes stay.',
  camera: 'Replaces the lens, what is up and how the camera moves.',
};

// --- below the fields

function foot({ found, choices, words }) {
  if (!found) {
    return html`<div class="row sheetfoot"><span class="sp"></span>
      <button type="button" class="btn" @click=${again}>${icon('folder')}Choose another…</button></div>`;
  }
  const off = whyNotBegin(found, choices, frameCount());
  return html`<div class="row sheetfoot">
    <span class=${words ? 'checkword imwords' : 'dim'}
      role=${words ? 'alert' : 'status'}>${words || off || BECOMES[found.kind]}</span><span class="sp"></span>
    <button class="btn pri ${off ? 'off' : ''}" ?disabled=${Boolean(off)}>${icon('up')}Import</button>
  </div>`;
}

function again() {
  leaveImport();
  chooseImport();
}

function progress({ stage, done, of }) {
  const title = stage === 'reading' ? 'Reading' : 'Importing';
  return workUnderWay({
    label: title,
    title,
    words: of ? `Frame ${done} of ${of}` : 'Preparing…',
    done,
    of,
    cancel: leaveImport,
  });
}
