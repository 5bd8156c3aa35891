// The pieces a tab is laid out with.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { numberField, slider } from '../controls/fields.js';

/** A titled block; right: what stands at the right end of its heading. */
export function section(title, body, right = nothing) {
  return html`<section class="sec" aria-label=${title}>
    <div class="hd"><span class="cut">${title}</span><span class="sp"></span>${right}</div>
    ${body}
  </section>`;
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

/** A number that is only told. */
export function fact(label, words, title = '') {
  return html`<div class="f told" title=${title}>
    <label>${label}</label><span></span><output class="num">${words}</output>
  </div>`;
}
