// The Live switch and the Track button with its menu.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { isOn, keyOf, perform, titleOf, whyNot } from '../actions/actions.js';
import { menuItem } from '../actions/buttons.js';
import { frame, segmentAt } from '../actions/playhead.js';
import { changedSegments, isFirstTrack, namesOf, whyNotTrack } from '../actions/tracking.js';
import { icon } from '../controls/icons.js';
import { line, menuHolder, toggleMenu } from '../controls/menu.js';
import { range } from '../controls/words.js';
import { chosenFrames, words } from '../store/clip.js';
import { server } from '../store/state.js';

export function liveSwitch() {
  return html`<button
    class="switch"
    role="switch"
    aria-checked=${isOn('live')}
    title=${titleOf('live')}
    data-key=${keyOf('live')}
    @click=${() => perform('live')}
  >
    Live<i></i>
  </button>`;
}

export function trackButton() {
  return menuHolder('track', split, items, 'right');
}

function split(open) {
  const { verb } = words();
  const off = whyNotTrack();
  const idle = whyNot('trackChanged');
  const choices = `${verb} this segment, changed segments, or all`;
  return html`<span class="split">
    <button
      class="btn pri"
      aria-disabled=${idle ? 'true' : nothing}
      title=${idle || titleOf('trackChanged')}
      data-key=${idle ? nothing : keyOf('trackChanged')}
      @click=${() => idle || perform('trackChanged')}
    >
      ${icon('track')}${label(verb)}<kbd>${keyOf('trackChanged')}</kbd>
    </button>
    <button
      class="btn pri"
      aria-label=${choices}
      aria-haspopup="menu"
      aria-expanded=${open}
      aria-disabled=${off ? 'true' : nothing}
      title=${off || choices}
      @click=${() => off || toggleMenu('track')}
    >
      ${icon('chev')}
    </button>
  </span>`;
}

/** As wide with each label, so that nothing beside it moves when the first track begins or the last ends. */
function label(verb) {
  const chosen = chosenFrames();
  if (chosen) return html`${verb} <span class="num">${range(...chosen)}</span>`;
  const now = whatIsLeft();
  const one = (text, when) =>
    html`<span class=${now === when ? 'shown' : ''} aria-hidden=${now !== when}>${text}</span>`;
  return html`<span class="either">${one(verb, 'all')}${one(`${verb} changed`, 'changed')}${one(`All ${words().done}`, 'none')}</span>`;
}

/** Of what there is to track. @returns {'all' | 'changed' | 'none'} */
function whatIsLeft() {
  if (isFirstTrack()) return 'all';
  return changedSegments().length || server.job?.state === 'running' ? 'changed' : 'none';
}

/** Which segments each of them means stands beside it. */
function items() {
  const here = segmentAt(frame());
  const { verb } = words();
  return [
    menuItem('trackChanged', undefined, { label: html`${verb} changed${tail(namesOf(changedSegments()))}` }),
    menuItem('trackThis', here, { label: html`${verb} this${tail(here && range(here.first, here.last))}` }),
    menuItem('trackAll'),
    line,
    menuItem('review'),
    menuItem('trackAhead'),
    menuItem('trackBack'),
  ];
}

const tail = (frames) => (frames ? html` <span class="dim num">${frames}</span>` : nothing);
