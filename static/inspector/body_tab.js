// The Body tab: the whole body's preset and height, and every part's sizes at a glance.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { checkbox, dropdown, iconButton, numberField } from '../controls/fields.js';
import { fitSizesRow } from './fitting.js';
import { line, measure, section } from './section.js';
import { partNamed, select, shortLabel } from './parts.js';
import { sizeSpec } from './size.js';

const HEIGHTS_CM = [100, 220];

export function bodyTab() {
  return html`${whole()}${section('Sizes', table())}`;
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
      options: body.presets.map((one) => ({ id: one.name, label: one.label })),
      act: (id) => send({ do: 'preset', name: id }),
      title: 'Start from the sizes of another body; keyframes stay',
    }))}${height()}${mirrored() ? link() : nothing}${fitSizesRow()}`,
    iconButton({
      name: 'reset', label: 'Back to the preset', act: () => send({ do: 'reset_body' }),
      off: preset && body.edited ? '' : unedited,
    }),
  );
}

function height() {
  const person = server.body.height_cm > HEIGHTS_CM[0] && server.body.height_cm < HEIGHTS_CM[1];
  return measure(
    {
      key: 'height', label: 'Height', value: server.body.height_cm, unit: 'cm', step: 0.5, coarse: 5,
      min: 1, max: 10000, edit: (cm) => ({ do: 'height', cm }),
      title: 'Sole to head top at rest; all sizes change with it',
    },
    person ? HEIGHTS_CM : null,
  );
}

function mirrored() {
  return server.body.parts.some((part) => part.mirror);
}

function link() {
  return checkbox({
    label: 'Same size left and right', on: server.view.link, act: (on) => send({ do: 'link', on }),
  });
}

/** A row per part with its two leading sizes; while left and right change together, one for both. */
function table() {
  return html`<div class="sizes" role="group" aria-label="Sizes in centimetres">
    <div class="size dim head"><span>Part</span><span>Length</span><span>Thickness</span></div>
    ${rows().map(row)}
  </div>`;
}

/** The length, and one size across it; the Part tab has them all. */
function leading(part) {
  const along = part.sizes.find((one) => one.label === 'Length') ?? part.sizes[0];
  const rest = part.sizes.filter((one) => one !== along);
  return [along, rest.find((one) => /^(Width|At|Radius)/.test(one.label)) ?? rest[0]].filter(Boolean);
}

/** The parts that have a row. A pair has one, at its first part's place, where both go together. */
function rows() {
  const { parts } = server.body;
  if (!server.view.link) return parts;
  const place = (part) => parts.findIndex((other) => other.name === part.name);
  const firsts = parts.filter((part) => !part.mirror || place(part) < place(partNamed(part.mirror)));
  return firsts.map((part) => (part.mirror ? standing(part, partNamed(part.mirror)) : part));
}

/** Of a pair the selected side stands for both, else the right one. */
function standing(one, other) {
  const selected = [one, other].find((part) => part.name === server.view.selected);
  return selected ?? (one.side === 'R' ? one : other);
}

function row(part) {
  const both = server.view.link && part.mirror;
  return html`<div class="size ${part.name === server.view.selected ? 'sel' : ''}">
    <button
      type="button"
      class="name"
      title=${`Select ${part.label.toLowerCase()}`}
      @click=${() => select(part.name)}
    >
      <span class="dot ${both ? 'both' : ''}" style="background:var(--${part.side})"></span>
      <span class="cut">${both ? shortLabel(part) : part.label}</span>
    </button>
    ${leading(part).map((one) => {
      const title = `${part.label}, ${one.label.toLowerCase()}: drag sideways or type`;
      return numberField({ ...sizeSpec(part, one), title });
    })}
  </div>`;
}
