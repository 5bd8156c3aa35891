// The Live switch and the Track button with its menu.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server } from '../store/state.js';
import { fewestKeys, tooFewWords, words } from '../store/subject.js';
import { frame } from '../timeline/edit/head.js';
import { menuHolder, toggleMenu } from '../controls/menu.js';
import { count, range } from '../controls/words.js';

const live = () => `${words().verb} the two neighbouring segments each time a keyframe changes   L`;

export const toggleLive = () => send({ do: 'live', on: !server.view?.live });

/** Start tracking or fitting, unless there is nothing to begin from. */
export function track(what) {
  if (!tooFew()) send({ do: 'track', what });
}

export function liveSwitch() {
  return html`<button
    class="switch"
    role="switch"
    aria-checked=${Boolean(server.view?.live)}
    title=${live()}
    @click=${toggleLive}
  >
    Live<i></i>
  </button>`;
}

export function trackButton() {
  return menuHolder('track', split, items, 'right');
}

function split(open) {
  const off = tooFew() ? tooFewWords() : '';
  const { verb } = words();
  const choices = `${verb} this segment, changed segments, or all`;
  const idle = off || (changed().length ? '' : nothingChanged());
  return html`<span class="split">
    <button
      class="btn pri"
      aria-disabled=${idle ? 'true' : nothing}
      title=${idle || `${verb} ${namesOf(changed())}   T`}
      @click=${() => idle || track('changed')}
    >
      ${icon('track')}${isFirst() ? verb : `${verb} changed`}<kbd>T</kbd>
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

function items() {
  const here = segmentHere();
  const all = server.segments?.length ?? 0;
  const { verb } = words();
  return [
    {
      icon: 'track',
      label: html`${verb} changed${tail(namesOf(changed()))}`,
      right: 'T',
      off: changed().length ? '' : nothingChanged(),
      run: () => track('changed'),
    },
    {
      icon: 'mid',
      label: html`${verb} this${tail(here && range(here.first, here.last))}`,
      right: 'Shift T',
      off: here ? '' : 'This frame lies outside the keyframes',
      run: () => track('this'),
    },
    { icon: 'reset', label: `${verb} all ${count(all, 'segment')}`, run: () => track('all') },
  ];
}

const tail = (said) => (said ? html` <span class="dim num">${said}</span>` : nothing);

const nothingChanged = () =>
  server.job?.state === 'running' ? `Being ${words().done}` : 'All segments are up to date';
const tooFew = () => (server.keys?.frames.length ?? 0) < fewestKeys();
const isDone = (s) => ['good', 'check', 'lost'].includes(s.state);
const isChanged = ({ state, unfinished }) => state === 'outdated' || state === 'none' || unfinished;
const changed = () => (server.segments ?? []).filter(isChanged);
const isFirst = () => !(server.segments ?? []).some((s) => isDone(s) || s.state === 'outdated' || s.percent);

/** "39–50, 50–61", or how many there are when that would be long. */
function namesOf(segments) {
  if (segments.length > 3) return count(segments.length, 'segment');
  return segments.map((s) => range(s.first, s.last)).join(', ');
}

/** The segment of the present frame; at a keyframe the one that begins there. */
function segmentHere() {
  const at = frame();
  const around = (server.segments ?? []).filter((s) => s.first <= at && at <= s.last);
  return around.at(-1);
}
