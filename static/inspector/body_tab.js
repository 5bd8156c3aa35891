// The Body tab: the whole body's preset and height, and every part's sizes at a glance.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { actionButton, actionIcon } from '../actions/buttons.js';
import { fitsFocal } from '../actions/lens.js';
import { server, setUi } from '../store/state.js';
import { isSurface } from '../store/subject.js';
import { send } from '../store/link.js';
import { checkbox, dropdown, iconButton, numberField } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { toast } from '../controls/toasts.js';
import { line, measure, partName, section } from './section.js';
import { partNamed } from '../store/parts.js';
import { sizeSpec } from './size.js';
import { sizesPreview } from './sizes_preview.js';

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
    html`${line('Preset', dropdown({
      label: 'Preset', value: body.edited ? null : body.preset,
      text: body.edited ? `${name}, edited` : name,
      options: body.presets.map((one) => ({
        id: one.name, label: one.label, group: one.is_object ? 'Objects' : 'People',
      })),
      act: (id) => send({ do: 'preset', name: id }),
      title: 'Use the sizes of a preset body. Keyframes are kept',
    }))}${height()}${hasPairs() ? link() : nothing}${clavicles()}${fitSizesRow()}`,
    html`${fromFile()}${iconButton({
      name: 'reset', label: 'Reset to preset', act: () => send({ do: 'reset_body' }),
      off: preset && body.edited ? '' : unedited,
    })}`,
  );
}

/** A body of one's own, as a file of `keypose schema body` describes it. */
function fromFile() {
  const title = 'Use a body from a JSON file. Keyframes keep the parts that it has too';
  return html`<label class="ib s filebtn" title=${title}>
    ${icon('folder')}<input type="file" accept=".json,application/json" aria-label="Body from a file" @change=${takeBody} />
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
      key: 'height', label: 'Height', value: server.body.height_cm, unit: 'cm', step: 0.5, coarse: 5,
      min: 1, max: 10000, edit: (cm) => ({ do: 'height', cm }),
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
    label: 'Movable shoulders', on, act: (wanted) => send({ do: 'clavicles', on: wanted }),
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
    label: 'Same sizes left and right', on: server.view.link, act: (on) => send({ do: 'link', on }),
  });
}

/** Fit the sizes to the images of all keyframes; surfaces have none. */
function fitSizesRow() {
  if (isSurface()) return nothing;
  return html`<div class="fitsizes">
    ${actionButton('fitSizes')}
    ${checkbox({
      label: 'With focal length', on: fitsFocal(), act: (on) => setUi('fitFocal', on),
      title: 'Estimate the focal length as well, if it is only a guess',
    })}
  </div>`;
}

/** A row per part with its two leading sizes; while left and right change together, one for both. */
function table() {
  return html`<div class="sizes" role="group" aria-label="Sizes in centimetres">
    <div class="size dim head"><span>Part</span><span>Length</span><span>Width</span></div>
    ${rows().map(row)}
  </div>`;
}

/** The length, and the first width; the Part tab has all sizes. */
function leading(part) {
  const along = part.sizes.find(({ role }) => role === 'length') ?? part.sizes[0];
  const rest = part.sizes.filter((one) => one !== along);
  return [along, rest.find(({ role }) => role === 'width') ?? rest[0]].filter(Boolean);
}

/** The parts that have a row. A pair has one, at its first part's place, where both go together. */
function rows() {
  const { parts } = server.body;
  if (!server.view.link) return parts;
  const place = (part) => parts.findIndex((other) => other.name === part.name);
  const firsts = parts.filter((part) => !part.mirror || place(part) < place(partNamed(part.mirror)));
  return firsts.map((part) => (part.mirror ? rowOfPair(part, partNamed(part.mirror)) : part));
}

/** Of a pair the selected side stands for both, else the right one. */
function rowOfPair(one, other) {
  const selected = [one, other].find((part) => part.name === server.view.selected);
  return selected ?? (one.side === 'R' ? one : other);
}

function row(part) {
  const both = server.view.link && Boolean(part.mirror);
  return html`<div class="size ${part.name === server.view.selected ? 'sel' : ''}">
    ${partName(part, both)}${leading(part).map((one) => {
      const spec = sizeSpec(part, one);
      return numberField({ ...spec, title: `${part.label}, ${spec.label.toLowerCase()}: drag sideways or type` });
    })}
  </div>`;
}
