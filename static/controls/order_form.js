// The form of an order: its options as fields, what is wrong with them, and the order itself.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { dropdown, segmented, textField } from './fields.js';

/** @typedef {import('../store/orders.js').Option} Option */
/** @typedef {Record<string, any>} Values  By option the text of its value; '' where nothing is chosen. */

/**
 * What a dialog knows of an option besides: other choices or words, a field of its own, whether it is
 * left out here or has to be chosen.
 * @typedef {object} Further
 * @property {boolean} [out]
 * @property {boolean} [needed]
 * @property {string} [empty]
 * @property {string} [note]
 * @property {{ id: string, label: string, note?: string, off?: string }[]} [options]
 * @property {() => unknown} [field]
 */

const MOST_SIDE_BY_SIDE = 3;

/** What a form starts with. @param {Option[]} options @returns {Values} */
export const usualOf = (options) =>
  Object.fromEntries(options.map(({ name, usual, kind }) => [name, kind === 'places' ? {} : (usual ?? '')]));

/**
 * The fields of a form.
 * @param {Option[]} options
 * @param {Values} values
 * @param {(changed: Values) => void} change
 * @param {Record<string, Further>} [further]  By the names of options.
 */
export function orderFields(options, values, change, further = {}) {
  const needed = options.filter(({ name }) => further[name]?.needed);
  return [...needed, ...options.filter((one) => !needed.includes(one))].map((one) => {
    const more = further[one.name] ?? {};
    if (more.out) return nothing;
    const known = { ...one, ...more };
    const set = (text) => change({ [one.name]: text });
    const chosen = known.options?.find(({ id }) => id === values[one.name]);
    const note = [chosen?.note, known.note].filter(Boolean).join('; ');
    const content = more.field
      ? more.field()
      : (known.options ? choice : (FIELDS[known.kind] ?? text))(known, values[one.name], set);
    return field(one.label, content, note);
  });
}

/** A label and what stands right of it. */
export const field = (label, content, note = '') =>
  html`<label class="exlabel">${label}</label><div class="exfield">${content}${
    note ? html`<span class="dim">${note}</span>` : nothing
  }</div>`;

const unitOf = (unit) => (unit ? html`<span class="dim">${unit}</span>` : nothing);

const text = ({ label, empty = '', unit, kind }, value, act) =>
  html`${textField({ label, value, placeholder: empty, most: kind === 'frames' ? 2000 : 9, act })}${unitOf(unit)}`;

function range({ label }, value, act) {
  const [first = '', last = ''] = value.split('-');
  const name = label.toLowerCase().replace(/s$/, '');
  return html`${textField({ label: `First ${name}`, value: first, most: 9, act: (one) => act(`${one}-${last}`) })}
    <span class="dim">to</span>${textField({
      label: `Last ${name}`,
      value: last,
      most: 9,
      act: (one) => act(`${first}-${one}`),
    })}`;
}

function choice({ label, options, empty, usual }, value, act) {
  if (usual && options.length <= MOST_SIDE_BY_SIDE && !options.some(({ note }) => note)) {
    return segmented({ label, value, options, act });
  }
  const all = usual || options.some(({ id }) => !id) ? options : [{ id: '', label: empty }, ...options];
  return dropdown({ label, value, text: all.find(({ id }) => id === value)?.label, kind: 'field', options: all, act });
}

const toggle = ({ label, labels }, value, act) =>
  segmented({
    label,
    value: value || 'false',
    act,
    options: [
      { id: 'false', label: labels[0] },
      { id: 'true', label: labels[1] },
    ],
  });

const FIELDS = { range, switch: toggle };

/**
 * What is wrong with the values, a sentence, or ''.
 * @param {Option[]} options
 * @param {Values} values
 * @param {number} count  Of the video's frames.
 * @param {Record<string, Further>} [further]
 */
export function whyNotOrder(options, values, count, further = {}) {
  for (const one of options) {
    const more = further[one.name] ?? {};
    const value = values[one.name];
    if (more.out) continue;
    const off =
      more.needed && !value
        ? `Choose: ${one.label}.`
        : value
          ? WRONG[one.kind]?.({ ...one, ...more }, value, count)
          : '';
    if (off) return off;
  }
  return '';
}

const FAR = 1e5; // bounds beyond are not worth saying
const isWhole = (word) => /^\d{1,9}$/.test(word.trim());

function bounds({ label, least, most, unit }) {
  const upTo = most === null || most >= FAR ? ` from ${least} on` : ` from ${least} to ${most}`;
  return `${label} is a number${least <= -FAR ? '' : upTo}${unit ? ` ${unit}` : ''}.`;
}

const isWithin = ({ least, most }, value) => value >= least && value <= (most ?? Infinity);

function whyNotFrames(words, count) {
  const beyond = words.find((word) => Number(word) >= count);
  return beyond ? `There is no frame ${beyond}. The last frame of the video is ${count - 1}.` : '';
}

const WRONG = {
  number: (one, value) =>
    /^[+-]?\d{1,7}(\.\d{0,20})?$/.test(value) && isWithin(one, Number(value)) ? '' : bounds(one),
  whole: (one, value) =>
    /^[+-]?\d{1,7}$/.test(value) && isWithin(one, Number(value))
      ? ''
      : bounds(one).replace('a number', 'a whole number'),
  range: (_, value, count) => {
    const ends = value.split('-');
    if (ends.length !== 2 || !ends.every(isWhole) || Number(ends[0]) > Number(ends[1])) {
      return 'The frames are two numbers, the first one not after the last.';
    }
    return whyNotFrames(ends, count);
  },
  frames: (_, value, count) => {
    const words = value.split(',').map((word) => word.trim());
    return words.every(isWhole)
      ? whyNotFrames(words, count)
      : 'Frames are numbers with commas between, such as 0, 24, 48.';
  },
};

/**
 * The order that the server takes: of all that is chosen the text.
 * @param {Option[]} options
 * @param {Values} values
 * @param {Record<string, Further>} [further]
 */
export function orderOf(options, values, further = {}) {
  /** @type {Record<string, string | string[]>} */
  const order = {};
  for (const { name, kind } of options) {
    const value = values[name];
    if (further[name]?.out || !value) continue;
    if (kind === 'places') order[name] = Object.entries(value).map(([theirs, place]) => `${theirs}=${place}`);
    else order[name] = String(value);
  }
  return order;
}
