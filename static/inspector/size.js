// Shape and sizes of the selected part, and where it hangs on its parent, in centimetres.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { icon } from '../controls/icons.js';
import { dropdown, numberField, textField } from '../controls/fields.js';
import { line, measure, section } from './section.js';
import { otherSideWord, partNamed } from '../store/parts.js';

const SMALLEST_CM = 0.2;
const LARGEST_CM = 1000;
const LETTER_PX = 6.3;

export function size(part) {
  const rows = part.sizes.map((one) => measure(sizeSpec(part, one), [one.min, one.max]));
  const longest = Math.max(...part.sizes.map((one) => one.label.length));
  const where = part.parent ? joint(part) : nothing;
  const named = server.body.is_persons ? nothing : name(part);
  const list = html`<div class="wordy" style="--label:${longest * LETTER_PX}px">${rows}</div>`;
  return section('Size', html`${named}${shape(part)}${list}${where}`, linkButton(part));
}

/** A person's parts keep their names, by which keypoints are known. */
function name(part) {
  const rename = (text) => text && send({ do: 'rename_part', part: part.name, name: text });
  return line(
    'Name',
    textField({ label: `Name of ${part.label.toLowerCase()}`, value: part.name, act: rename, most: 60 }),
  );
}

function shape(part) {
  return line(
    'Shape',
    dropdown({
      label: 'Shape',
      value: part.shape,
      options: server.body.shapes.map((one) => ({ id: one.kind, label: one.label })),
      act: (kind) => send({ do: 'shape', part: part.name, kind }),
      title: 'Another shape, about as large as this one',
    }),
  );
}

/** The number field of one size; the table of the Body tab has it too. */
export function sizeSpec(part, one) {
  return {
    key: `${part.name}.${one.key}`,
    label: one.label,
    value: one.cm,
    unit: 'cm',
    step: 0.1,
    coarse: 1,
    perPixel: 0.1,
    min: SMALLEST_CM,
    max: LARGEST_CM,
    edit: (cm) => ({ do: 'size', part: part.name, key: one.key, cm }),
  };
}

/** Left and right together: a button on parts that come in pairs. */
function linkButton(part) {
  if (!part.mirror) return nothing;
  const side = otherSideWord(part);
  const other = partNamed(part.mirror)?.label.toLowerCase() ?? '';
  const title = server.view.link ? `Sizes change on the ${other} too` : `Sizes change on this side only`;
  return html`<button
    type="button"
    class="lk word ${server.view.link ? 'on' : ''}"
    aria-pressed=${server.view.link}
    title=${title}
    @click=${() => send({ do: 'link', on: !server.view.link })}
  >
    ${icon('link')}${side} too
  </button>`;
}

function joint(part) {
  const on = partNamed(part.parent)?.label.toLowerCase() ?? '';
  const one = (axis, i) =>
    numberField({
      key: `${part.name}.joint.${axis}`,
      label: `Joint ${axis.toUpperCase()}`,
      title: `Joint on the ${on}, along its ${axis.toUpperCase()} axis: drag sideways or type`,
      mark: { text: axis.toUpperCase(), color: `var(--g${axis})` },
      value: part.joint_cm[i],
      step: 0.1,
      coarse: 1,
      perPixel: 0.1,
      edit: (cm) => ({ do: 'joint', part: part.name, [axis]: cm }),
    });
  return html`<div class="tri">
    <label title=${`Where the joint is on the ${on}`}>Joint, cm</label>${['x', 'y', 'z'].map(one)}
  </div>`;
}
