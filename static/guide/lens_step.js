// The guide's first question: which lens took this film. Six kinds of camera with keys 1 to 6, the
// focal length on a slider, what the file says.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import {
  addForStabiliser, chooseKind, fileWords, FOCAL_MM, focalSpec, isFileOther, kindHere, KINDS, millimetres, useFile,
} from '../actions/lens.js';
import { numberField, slider } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { server } from '../store/state.js';

export function lensCard() {
  const here = kindHere();
  const [min, max] = FOCAL_MM;
  return html`<div class="lenses" role="radiogroup" aria-label="Kind of camera">
      ${KINDS.map((kind, i) => kindButton(kind, kind === here, i))}
    </div>
    <div class="row focal">
      <label class="mut">35 mm equivalent</label>
      ${slider({ ...focalSpec(), min, max, zero: min, tick: false, log: true, rolls: true })}${numberField(focalSpec())}
    </div>
    ${fileLine()}${stabilised()}`;
}

/** @param {import('../actions/lens.js').Kind} kind */
function kindButton(kind, isHere, i) {
  return html`<button type="button" class="lens ${isHere ? 'on' : ''}" role="radio" aria-checked=${isHere}
    title=${kind.mm ? `${kind.label} (${i + 1})` : `Fitted with the first two keyframes (${i + 1})`} @click=${() => chooseKind(kind)}>
    <b>${icon(kind.icon)}${kind.label}</b><span>${kind.detail}</span>
  </button>`;
}

function fileLine() {
  const { lens } = server.file;
  if (!lens) return nothing;
  if (isFileOther()) {
    return html`<div class="row filesays">
      <span class="mut">File says ${millimetres(lens.focal_mm)}</span><span class="sp"></span>
      <button type="button" class="btn sm" @click=${useFile}>Use</button>
    </div>`;
  }
  return html`<div class="row filesays good">${icon('check')}<span><b>From the file</b> ${fileWords()}</span></div>`;
}

/** Where the file or a person named the lens itself, not what the film shows of it. */
function stabilised() {
  const { lens_source: source } = server.camera;
  const isNamed = source === 'file' || KINDS.some(({ mm }) => mm === Math.round(server.camera.focal_mm));
  if (!isNamed || server.camera.lens_is_guess) return nothing;
  return html`<div class="row filesays">
    <span class="mut">Stabilised film shows less than the lens. Add about 10 %.</span><span class="sp"></span>
    <button type="button" class="btn sm" @click=${addForStabiliser}>Add</button>
  </div>`;
}

/** Keys 1 to 6; whether it was one. */
export function lensKey(key) {
  const kind = KINDS[Number(key) - 1];
  if (kind) chooseKind(kind);
  return Boolean(kind);
}
