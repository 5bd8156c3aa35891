// New sizes as they were found: how much better they fit, what changes, and the answer to them.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { goTo } from '../actions/playhead.js';
import { applySizes, discardSizes, lookBack } from '../actions/preview.js';
import { signedNumber } from '../controls/arithmetic.js';
import { checkbox } from '../controls/fields.js';
import { send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';
import { section } from './section.js';

const LEAST_CM = 0.5;

export function sizesPreview() {
  const found = server.sizes_preview;
  const large = found.changes.filter(isLarge);
  const small = found.changes.filter((one) => !isLarge(one));
  const basis = found.keyframes === 1 ? '1 keyframe' : `${found.keyframes} keyframes`;
  return section('Fit sizes', html`
    ${error(found.error)}
    <div class="newsizes" role="table" aria-label="New sizes in centimetres">
      <div class="row dim head" role="row"><span>cm</span><span>Before</span><i></i><span>After</span><span>Change</span></div>
      ${row({ part: 'Height', ...found.height }, 'whole')}
      ${large.map((one) => row(one))}
      ${found.unseen.map(unseen)}
      ${ui.allSizes ? small.map((one) => row(one)) : nothing}
    </div>
    ${small.length ? more(small.length) : nothing}
    ${poses(found)}
    ${answer()}`, html`<span class="dim num">${basis}</span>`);
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
function row({ part, what, pair, before, after }, kind = '') {
  const name = what === 'width' ? `${part} width` : part;
  return html`<div class="row ${kind}" role="row">
    <span class="cut" role="cell" title=${name}><span class="dot ${pair ? 'both' : ''}"></span>${name}</span>
    <span class="num mut" role="cell">${before.toFixed(1)}</span><i class="dim">→</i>
    <b class="num" role="cell">${after.toFixed(1)}</b>
    <span class="num by ${Math.abs(after - before) < LEAST_CM ? 'tiny' : ''}" role="cell">${signedNumber(after - before, 1)}</span>
  </div>`;
}

const unseen = (part) => html`<div class="row dim" role="row">
  <span class="cut" role="cell"><span class="dot"></span>${part}</span><span class="notseen" role="cell">not seen</span></div>`;

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
      label: 'Also adjust keyframe poses', on: found.poses, off,
      act: (on) => send({ do: 'preview_poses', on }), title: 'Turn limbs so that they fit with the new sizes',
    })}
    <div class="row dim"><span>at most ${Math.ceil(most)}°, in ${found.turns.length} of ${found.keyframes} keyframes</span>
      <span class="sp"></span>
      <button type="button" class="link" title="Go to the next of these keyframes" @click=${() => goTo(nextOf(found.turns))}>Show</button></div>
    ${here ? html`<p class="turns dim">${here.parts.map(({ part, deg }) => `${part} ${deg.toFixed(0)}°`).join(' · ')}</p>` : nothing}
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
    <button class="btn sm before" aria-pressed=${back} data-keeps-focus data-while-held title="Hold to see the body as it is"
      @pointerdown=${(event) => event.button === 0 && lookBack(true)} @blur=${() => lookBack(false)}>Before<kbd>B</kbd></button>
    <span class="sp"></span>
    <button class="btn sm ghost" @click=${discardSizes}>Discard<kbd>Esc</kbd></button>
    <button class="btn sm pri" @click=${applySizes}>Apply<kbd>Enter</kbd></button>
  </div>`;
}
