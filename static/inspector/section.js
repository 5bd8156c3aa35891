// The pieces of a tab.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { button, numberField, slider } from '../controls/fields.js';
import { leaveSketch } from '../handles/interaction.js';
import { select } from '../store/parts.js';
import { setUi, ui } from '../store/state.js';

/** A titled block; right: what stands at the right end of its heading. */
export function section(title, body, right = nothing) {
  return html`<section class="sec" aria-label=${title}>
    <div class="row hd"><span class="cut">${title}</span><span class="sp"></span>${right}</div>
    ${body}
  </section>`;
}

/** The name of a part with the colour of its side; a click selects it. `both`: it stands for its pair. */
export function partName(part, both = false) {
  return html`<button type="button" class="row name" title=${`Select ${part.label.toLowerCase()}`}
    @click=${() => select(part.name)}>
    <span class="dot ${both ? 'both' : ''}" style="background:var(--${part.side})"></span>
    <span class="cut">${both ? part.short : part.label}</span>
  </button>`;
}

/**
 * A button that takes up a drawing tool, or puts it away; `busy` is its label meanwhile; off: why it cannot be
 * used, or ''.
 */
export function drawingButton(tool, { name, label, busy, title, off = '' }) {
  const drawing = ui.tool === tool;
  return button({
    name,
    label: drawing ? busy : label,
    kind: drawing ? 'full on' : 'full',
    title: drawing ? 'Stop drawing' : title,
    key: drawing ? 'Esc' : '',
    off: drawing ? '' : off,
    act: () => (drawing ? leaveSketch() : setUi('tool', tool)),
  });
}

/** A label and whatever it is of. */
export function line(label, control) {
  return html`<div class="f two"><label class="cut">${label}</label>${control}</div>`;
}

/** A number with its label; with a slider between them where `track` gives its ends. */
export function measure(spec, track) {
  const bar = track
    ? slider({ ...spec, min: track[0], max: track[1], zero: track[0], tick: false })
    : html`<span></span>`;
  return html`<div class="f w ${track ? '' : 'bare'}"><label class="cut" title=${spec.label}>${
    spec.text ?? spec.label
  }</label>${bar}${numberField(spec)}</div>`;
}

/** A number that is only shown. */
export function fact(label, words, title = '') {
  return html`<div class="f fact" title=${title}>
    <label>${label}</label><span></span><output class="num">${words}</output>
  </div>`;
}
