// The Body tab: preset, height and sizes of the body, what is tracked, new sizes to apply.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { actionButton, actionIcon } from '../actions/buttons.js';
import { fitsFocal } from '../actions/lens.js';
import { goTo } from '../actions/playhead.js';
import { applySizes, discardSizes, lookBack } from '../actions/proposals.js';
import { signedNumber } from '../controls/arithmetic.js';
import { checkbox, dropdown, iconButton, numberField } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { toast } from '../controls/toasts.js';
import { send } from '../store/link.js';
import { partNamed, selectedPart } from '../store/parts.js';
import { server, setUi, ui } from '../store/state.js';
import { isSurface } from '../store/clip.js';
import { firstOfMore, SHELVES } from './bodies.js';
import { line, measure, partName, section } from './section.js';
import { sizeSpec } from './size.js';

const LEAST_CM = 0.5;

export function sizesPreview() {
  const found = server.sizes_preview;
  const large = found.changes.filter(isLarge);
  const small = found.changes.filter((one) => !isLarge(one));
  const basis = found.keyframes === 1 ? '1 keyframe' : `${found.keyframes} keyframes`;
  return section(
    'Fit sizes',
    html`
    ${found.error ? error(found.error) : nothing}
    <div class="newsizes" role="table" aria-label="New sizes in centimetres">
      <div class="row dim head"
        role="row"><span>cm</span><span>Before</span><i></i><span>After</span><span>Change</span></div>
      ${previewRow({ part: 'Height', ...found.height }, 'whole')}
      ${large.map((one) => previewRow(one))}
      ${found.unseen.map(unseen)}
      ${ui.allSizes ? small.map((one) => previewRow(one)) : nothing}
    </div>
    ${small.length ? more(small.length) : nothing}
    ${found.note ? html`<p class="note">${found.note}</p>` : nothing}
    ${poses(found)}
    ${answer()}`,
    html`<span class="dim num">${basis}</span>`,
  );
}

const isLarge = ({ before, after }) => Math.abs(after - before) >= LEAST_CM;

function error({ before, after }) {
  const share = Math.round(100 * (after / before - 1));
  return html`<div class="row outline-error"><span class="mut">Outline error</span><span class="sp"></span>
    <span class="num mut">${before.toFixed(1)}</span><span class="dim">→</span>
    <b class="num">${after.toFixed(1)} px</b>
    <b class="num ${share < 0 ? 'better' : 'worse'}">${signedNumber(share, 0)} %</b></div>`;
}

/** @param {{ part: string, before: number, after: number, what?: string, pair?: boolean }} one */
function previewRow({ part, what, pair, before, after }, kind = '') {
  const name = what === 'width' ? `${part} width` : part;
  return html`<div class="row ${kind}" role="row">
    <span class="cut" role="cell" title=${name}><span class="dot ${pair ? 'both' : ''}"></span>${name}</span>
    <span class="num mut" role="cell">${before.toFixed(1)}</span><i class="dim">→</i>
    <b class="num" role="cell">${after.toFixed(1)}</b>
    <span class="num by ${Math.abs(after - before) < LEAST_CM ? 'tiny' : ''}"
      role="cell">${signedNumber(after - before, 1)}</span>
  </div>`;
}

const unseen = (part) => html`<div class="row dim" role="row">
  <span class="cut" role="cell"><span class="dot"></span>${part}</span><span class="notseen"
    role="cell">not seen</span></div>`;

function more(count) {
  return html`<button type="button" class="link morelines" aria-expanded=${Boolean(ui.allSizes)}
    @click=${() => setUi('allSizes', !ui.allSizes)}>${count} more, all under 0.5 cm</button>`;
}

/** Other poses are never taken without a tick; what they turn is listed part by part. */
function poses(found) {
  if (!found.turns.length) return nothing;
  const most = Math.max(...found.turns.map(({ parts }) => parts[0].deg));
  const here = found.turns.find(({ frame }) => frame === server.view.frame);
  const off = found.choice ? '' : 'Without other poses these sizes do not fit better';
  return html`<div class="adjust">
    ${checkbox({
      label: 'Also adjust keyframe poses',
      on: found.poses,
      off,
      act: (on) => send({ do: 'preview_poses', on }),
      title: 'Turn limbs so that they fit with the new sizes',
    })}
    <div class="row dim"><span>at most ${Math.ceil(most)}°, in ${found.turns.length} of ${found.keyframes} keyframes</span>
      <span class="sp"></span>
      <button type="button" class="link" title="Go to the next of these keyframes"
        @click=${() => goTo(nextOf(found.turns))}>Show</button></div>
    ${
      here
        ? html`<p class="turns dim">${here.parts.map(({ part, deg }) => `${part} ${deg.toFixed(0)}°`).join(' · ')}</p>`
        : nothing
    }
  </div>`;
}

/** The next keyframe that is posed anew, after the last the first again. */
function nextOf(turns) {
  const frames = turns.map(({ frame }) => frame);
  return frames.find((frame) => frame > server.view.frame) ?? frames[0];
}

function answer() {
  const { looking_back: back } = server.sizes_preview;
  return html`<div class="row answer">
    <button class="btn sm before" aria-pressed=${back} data-keeps-focus data-while-held
      title="Hold to see the body as it is"
      @pointerdown=${(event) => event.button === 0 && lookBack(true)}
        @blur=${() => lookBack(false)}>Before<kbd>B</kbd></button>
    <span class="sp"></span>
    <button class="btn sm ghost" @click=${discardSizes}>Discard<kbd>Esc</kbd></button>
    <button class="btn sm pri" @click=${applySizes}>Apply<kbd>Enter</kbd></button>
  </div>`;
}

const TURNS = ['rx', 'ry', 'rz'];
const MOVES = ['tx', 'ty', 'tz'];
const MOVE_WORDS = { tx: 'Across', ty: 'Down', tz: 'Depth' };

export function freedom() {
  const part = selectedPart();
  const all = ui.allFreedoms === true;
  const parts = all ? server.body.parts : part ? [part] : [];
  return section(
    'Tracked motions',
    html`${parts.map((one) => freedoms(one, !all))}
      ${parts.length ? nothing : html`<p class="note">Select a part to choose its tracked motions.</p>`}
      <p class="note">Whole body: ${server.body.dof_count} of ${server.body.dof_total}</p>`,
    iconButton({
      name: 'more',
      label: all ? 'The selected part only' : 'All parts',
      pressed: all,
      act: () => setUi('allFreedoms', !all),
    }),
  );
}

function freedoms(part, wordy) {
  return html`<div class="listrow free ${part.name === server.view.selected && !wordy ? 'sel' : ''}">
      ${partName(part)}${toggles(part, TURNS, wordy)}
    </div>
    ${part.parent ? nothing : place(part, wordy)}`;
}

/** Only the root may move as well as turn. */
function place(part, wordy) {
  return html`<div class="listrow free"><span class="mut indent">Position</span>${toggles(part, MOVES, wordy)}</div>`;
}

function toggles(part, dofs, wordy) {
  return html`<div class="seg" role="group" aria-label=${`Motions of ${part.label}`}>
    ${dofs.map((dof) => motion(part, dof, wordy))}
  </div>`;
}

function motion(part, dof, wordy) {
  const axis = dof[1];
  const on = part.tracked.includes(dof);
  const word = MOVE_WORDS[dof] ?? part.words?.[axis] ?? axis.toUpperCase();
  const next = [...MOVES, ...TURNS].filter((each) => (each === dof ? !on : part.tracked.includes(each)));
  const title = on ? `${word} is tracked. Click to keep it as posed` : `${word} stays as posed. Click to track it`;
  return html`<button
    type="button"
    aria-pressed=${on}
    title=${title}
    @click=${() => send({ do: 'tracked', part: part.name, dofs: next })}
  >
    <b style="color:var(--g${axis})">${axis.toUpperCase()}</b>${wordy && on ? html`<span>${word}</span>` : nothing}
  </button>`;
}

const HEIGHTS_CM = [100, 220];

export function bodyTab() {
  if (server.sizes_preview) return sizesPreview();
  return html`${whole()}${section('Parts', table(), html`${actionIcon('addPart')}${actionIcon('deletePart')}`)}`;
}

function whole() {
  const { body } = server;
  const preset = body.presets.find((one) => one.name === body.preset);
  const name = preset?.label ?? body.name.charAt(0).toUpperCase() + body.name.slice(1);
  const unedited = preset ? 'These are the preset’s own sizes' : 'This body comes from no preset';
  return section(
    'Body',
    html`${line(
      'Preset',
      dropdown({
        label: 'Preset',
        value: body.edited ? null : body.preset,
        text: body.edited ? `${name}, edited` : name,
        options: body.presets.map((one) => ({
          id: one.name,
          label: one.label,
          group: SHELVES[one.kind],
        })),
        act: (id) => send({ do: 'preset', name: id }),
        title: 'Use the sizes of a preset body. Keyframes are kept',
      }),
    )}${height()}${hasPairs() ? link() : nothing}${clavicles()}${fitSizesRow()}${firstOfMore()}`,
    html`${fromFile()}${iconButton({
      name: 'reset',
      label: 'Reset to preset',
      act: () => send({ do: 'reset_body' }),
      off: preset && body.edited ? '' : unedited,
    })}`,
  );
}

/** A body of one's own, as a file of `keypose schema body` describes it. */
function fromFile() {
  const title = 'Use a body from a JSON file. Keyframes keep the parts that it has too';
  return html`<label class="ib s filebtn" title=${title}>
    ${icon('folder')}<input type="file" accept=".json,application/json" aria-label="Body from a file"
      @change=${takeBody} />
  </label>`;
}

async function takeBody({ target }) {
  const [file] = target.files;
  target.value = '';
  if (!file) return;
  try {
    send({ do: 'body', body: JSON.parse(await file.text()) });
  } catch {
    toast({ kind: 'check', words: `${file.name} is no JSON. Choose a body as keypose schema body describes it.` });
  }
}

function height() {
  const person = server.body.height_cm > HEIGHTS_CM[0] && server.body.height_cm < HEIGHTS_CM[1];
  return measure(
    {
      key: 'height',
      label: 'Height',
      value: server.body.height_cm,
      unit: 'cm',
      step: 0.5,
      coarse: 5,
      min: 1,
      max: 10000,
      edit: (cm) => ({ do: 'height', cm }),
      title: 'From the soles to the top of the head. Scales the whole body',
    },
    person ? HEIGHTS_CM : null,
  );
}

/** Two more parts, for people whose shoulders rise or reach forward. */
function clavicles() {
  const on = server.body.clavicles;
  if (on === null) return nothing;
  return checkbox({
    label: 'Movable shoulders',
    on,
    act: (wanted) => send({ do: 'clavicles', on: wanted }),
    title: on
      ? 'Remove the clavicles. Arms keep their directions'
      : 'Add a clavicle on each side, which lifts the shoulder and swings it forward. Poses stay as they are',
  });
}

function hasPairs() {
  return server.body.parts.some((part) => part.mirror);
}

function link() {
  return checkbox({
    label: 'Same sizes left and right',
    on: server.view.link,
    act: (on) => send({ do: 'link', on }),
  });
}

/** Fit the sizes to the images of all keyframes; surfaces have none. */
function fitSizesRow() {
  if (isSurface()) return nothing;
  return html`<div class="row fitsizes">
    ${actionButton('fitSizes')}
    ${checkbox({
      label: 'With focal length',
      on: fitsFocal(),
      act: (on) => setUi('fitFocal', on),
      title: 'Estimate the focal length as well, if it is only a guess',
    })}
  </div>`;
}

/** A row per part with its two leading sizes; while left and right change together, one for both. */
function table() {
  return html`<div class="sizes" role="group" aria-label="Sizes in centimetres">
    <div class="listrow size dim head"><span>Part</span><span>Length</span><span>Width</span></div>
    ${rows().map(row)}
  </div>`;
}

/** The length, and the first width; the Part tab has all sizes. */
function leading(part) {
  const along = part.sizes.find(({ role }) => role === 'length') ?? part.sizes[0];
  const rest = part.sizes.filter((one) => one !== along);
  return [along, rest.find(({ role }) => role === 'width') ?? rest[0]].filter(Boolean);
}

/** The parts that have a row. A pair has one, at its first part's placeFields, where both go together. */
function rows() {
  const { parts } = server.body;
  if (!server.view.link) return parts;
  const placeOf = (part) => parts.findIndex((other) => other.name === part.name);
  const firsts = parts.filter((part) => !part.mirror || placeOf(part) < placeOf(partNamed(part.mirror)));
  return firsts.map((part) => (part.mirror ? rowOfPair(part, partNamed(part.mirror)) : part));
}

/** Of a pair the selected side stands for both, else the right one. */
function rowOfPair(one, other) {
  const selected = [one, other].find((part) => part.name === server.view.selected);
  return selected ?? (one.side === 'R' ? one : other);
}

function row(part) {
  const both = server.view.link && Boolean(part.mirror);
  return html`<div class="listrow size ${part.name === server.view.selected ? 'sel' : ''}">
    ${partName(part, both)}${leading(part).map((one) => {
      const spec = sizeSpec(part, one);
      return numberField({ ...spec, title: `${part.label}, ${spec.label.toLowerCase()}: drag sideways or type` });
    })}
  </div>`;
}
