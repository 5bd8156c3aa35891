// The keyframes as diamonds, and with them drafts that stand alone.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { menuItem } from '../../actions/buttons.js';
import { contextEntries } from '../../actions/context_menus.js';
import { placeForCopy } from '../../actions/keying.js';
import { partKeyAt } from '../../actions/parts.js';
import { isSoft } from '../../actions/pins.js';
import { draftFrames, frame, goTo, isKey, keyFrames, stopPlaying } from '../../actions/playhead.js';
import { chooseOnly, clearSelection, extendTo, isSelected, selectedKeys, toggleKey } from '../../actions/selection.js';
import { clamp } from '../../controls/arithmetic.js';
import { line, openMenuAt } from '../../controls/menu.js';
import { clampFrame, lastFrame } from '../../store/clip.js';
import { send } from '../../store/link.js';
import { server } from '../../store/state.js';
import { frameAt, GUTTER, hitNear, right, seenOf, x } from '../draw/scale.js';
import { diamond, named, plate } from '../draw/glyphs.js';
import { onTheWay, putBack } from '../pointer.js';
import { singleDrafts } from './drafts.js';
import { chosenKeys, grabKeys, openSelectionMenu } from './selection.js';

const RADIUS = 6.5;
const CURRENT = 8;
const CLOSE_PX = 10;

const isAmongSelected = (at) => isSelected(at) && selectedKeys().length > 1;

/** @type {import('../mark.js').Mark} */
export const keyframe = {
  kind: 'key',
  row: 'keys',
  layers: [
    {
      group: 'frames',
      z: 130,
      from: () => [server.keys, server.segments, String(onTheWay()), chosenKeys()],
      draw: ({ rows }) => drawKeys(rows.keys),
    },
    {
      group: 'frames',
      z: 170,
      from: () => [frame(), server.keys, String(onTheWay()), chosenKeys()],
      draw: ({ rows }) => drawCurrent(rows.keys),
    },
  ],
  /** Ticks stand close: they are caught within 3 px only. */
  hit({ x: px }) {
    if (px < GUTTER || px > right() + CURRENT) return null;
    const { diamonds, ticks } = marksOf(seenOf(keyFrames()));
    return hitNear(framesOf(diamonds), px, 11) ?? hitNear(framesOf(ticks), px, 3);
  },
  cursor: 'grab',
  edits: true,
  grab: ({ frame: at }, start) => (isAmongSelected(at) ? grabKeys(at, start) : grabKey(at, start)),
  /** With Shift it extends the selection, with Ctrl it toggles the keyframe. */
  click({ frame: at }, { ctrl, shift }) {
    if (ctrl) return toggleKey(at);
    if (shift) return extendTo(at);
    chooseOnly(at);
    return goTo(at);
  },
  menu: ({ frame: at }, { page }) => (isAmongSelected(at) ? openSelectionMenu(page) : openKeyMenu(at, page)),
  tip: ({ frame: at }, rows) =>
    svg`<path class="hover" d=${diamond(x(at), rows.keys.middle, 9.5)} />${named(`Keyframe ${at}`, x(at), rows)}`,
  drag({ from, to, copy, taken, refused }, { keys: { middle } }) {
    const words = taken ? `${to} is a ${partKeyAt(to) ? 'part ' : ''}keyframe` : `${from} ${copy ? '+' : '→'} ${to}`;
    return svg`${copy ? nothing : svg`<path class="home" d=${diamond(x(from), middle, 5)} />`}
      <g class=${refused ? 'shake' : ''}><path class=${`moving${taken ? ' taken' : ''}`} d=${diamond(x(to), middle, 8)}
        /></g>
      ${plate(words, x(to), middle + 22)}`;
  },
};

/**
 * Grab the keyframe at a frame, with Shift or Alt a copy of it. The edit is sent when the diamond is released:
 * on its way over other frames it would do nothing but outdate results.
 * @returns {import('../mark.js').Gesture}
 */
function grabKey(from, start) {
  const offset = x(from) - start.x;
  stopPlaying();
  return {
    move(place) {
      const to = clampFrame(frameAt(place.x + offset));
      const taken = to !== from && (isKey(to) || Boolean(partKeyAt(to)));
      return { kind: 'key', frames: [from], from, to, copy: place.shift || place.alt, taken, refused: false };
    },
    end(held) {
      clearSelection();
      if (held.taken) return putBack(held);
      if (held.to === from) return null;
      send({ do: held.copy ? 'duplicate_key' : 'move_key', frame: from, to: held.to });
      return goTo(held.to);
    },
  };
}

/** What both menus of a keyframe have. */
export const duplicate = (at) =>
  menuItem('duplicateKeyframe', at, { ask: { value: placeForCopy(at), last: lastFrame(), answer: 'Duplicate' } });
/** A key acts at the playhead: for what lies elsewhere none is shown. */
export const elsewhere = (isHere) => (isHere ? {} : { right: '' });
export const remove = (at) => menuItem('deleteKeyframe', at, { icon: 'trash', ...elsewhere(at === frame()) });

export function openKeyMenu(at, page) {
  openMenuAt(
    `Keyframe ${at}`,
    [
      menuItem('goTo', at),
      duplicate(at),
      menuItem('softKey', at),
      ...(isSoft(at) ? [menuItem('ownPose', at)] : []),
      ...contextEntries('keyframe', { copyKeyHere: at, note: at }),
      line,
      remove(at),
    ],
    page,
  );
}

/** Keys as diamonds, and as ticks where their nearest neighbour is closer than 10 px: [{frame, room}, ...]. */
function marksOf(frames) {
  const at = frames.map(x);
  const marks = at.map((here, i) => ({
    frame: frames[i],
    room: Math.min(here - (at[i - 1] ?? -1e9), (at[i + 1] ?? 1e9) - here),
  }));
  return { diamonds: marks.filter(({ room }) => room >= CLOSE_PX), ticks: marks.filter(({ room }) => room < CLOSE_PX) };
}

const framesOf = (marks) => marks.map((mark) => mark.frame);

/** The frames of those keys that have room for a diamond. */
export const withRoom = (frames) => framesOf(marksOf(frames).diamonds);

function drawKeys({ middle }) {
  const [gone, chosen] = [new Set(onTheWay()), new Set(chosenKeys())];
  const { diamonds, ticks } = marksOf(seenOf(keyFrames()));
  const here = (marks) => marks.filter(({ frame: at }) => !gone.has(at));
  const isChosen = ({ frame: at }) => chosen.has(at);
  // Diamonds shrink, and ticks get thinner, so that the bars between them are still seen.
  const large = (marks) =>
    marks.map(({ frame: at, room }) => diamond(x(at), middle, clamp(room * 0.27, 3.5, RADIUS))).join('');
  const small = (marks) =>
    marks
      .map(({ frame: at, room }) => {
        const wide = clamp(room / 3, 0.5, 3);
        return `M${(x(at) - wide / 2).toFixed(1)} ${middle - 8}h${wide}v16h${-wide}z`;
      })
      .join('');
  return svg`<path class="keymark" d=${large(here(diamonds).filter(({ frame: at }) => !isSoft(at)))} />
    <path class="keymark soft" d=${large(here(diamonds).filter(({ frame: at }) => isSoft(at)))} />
    <path class="keymark tick" d=${small(here(ticks))} />
    <path class="keymark chosen" d=${large(here(diamonds).filter(isChosen))} />
    <path class="keymark tick chosen" d=${small(here(ticks).filter(isChosen))} />
    <path class="draft" d=${seenOf(singleDrafts())
      .map((at) => diamond(x(at), middle, RADIUS))
      .join('')} />`;
}

/** The key under the playhead, in the accent; hollow while it is a draft, outlined while it is chosen. */
function drawCurrent({ middle }) {
  const at = frame();
  if (onTheWay().includes(at)) return nothing;
  if (isKey(at)) {
    return svg`<path class=${`keymark current${isSoft(at) ? ' soft' : ''}${chosenKeys().includes(at) ? ' chosen' : ''}`}
      d=${diamond(x(at), middle, CURRENT)} />`;
  }
  return draftFrames().includes(at)
    ? svg`<path class="draft current" d=${diamond(x(at), middle, CURRENT - 1)} />`
    : nothing;
}
