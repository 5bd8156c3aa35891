// Notes: standing on the line below the ruler, their point down.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { perform } from '../../actions/actions.js';
import { contextEntries } from '../../actions/context_menus.js';
import { allNotes, noteAsOneLine, noteAt } from '../../actions/keying.js';
import { goTo, stopPlaying } from '../../actions/playhead.js';
import { heading, openMenuAt } from '../../controls/menu.js';
import { clampFrame } from '../../store/clip.js';
import { send } from '../../store/link.js';
import { server } from '../../store/state.js';
import { frameAt, hitNear, RULER, seenOf, x } from '../draw/scale.js';
import { plate } from '../draw/glyphs.js';
import { held } from '../pointer.js';

const HIGH = 8;
const REACH_PX = 7;
/** Letters of a note that are shown where it is pointed at. */
export const HOVERED = 90;

/** @type {import('../mark.js').Mark} */
export const note = {
  kind: 'note',
  layers: [{ group: 'frames', z: 200, from: () => [server.notes, held('note')?.from], draw: drawNotes }],
  hit({ x: px, y }) {
    if (y < RULER - HIGH - 3 || y > RULER + 1) return null;
    return hitNear(
      allNotes().map(({ frame }) => frame),
      px,
      REACH_PX,
    );
  },
  cursor: 'grab',
  edits: true,
  /** It is sent where it is let go, unless another one is there. */
  grab({ frame: from }, start) {
    const offset = x(from) - start.x;
    stopPlaying();
    return {
      move(place) {
        const to = clampFrame(frameAt(place.x + offset));
        return { from, to, taken: to !== from && Boolean(noteAt(to)) };
      },
      end: ({ to, taken }) => taken || to === from || send({ do: 'move_note', frame: from, to }),
    };
  },
  click: ({ frame: at }) => goTo(at),
  open: ({ frame: at }) => perform('note', at),
  menu({ frame: at }, { page }) {
    const here = noteAt(at);
    if (!here) return;
    openMenuAt(
      `Note at ${at}`,
      [
        heading(`Frame ${at} · ${noteAsOneLine(here)}`),
        ...contextEntries('note', { goTo: at, note: at, deleteNote: at }),
      ],
      page,
    );
  },
  tip({ frame: at }) {
    const here = noteAt(at);
    return here ? drawLarge('hover', at, `${at}  ${noteAsOneLine(here, HOVERED)}`) : nothing;
  },
  drag: ({ from, to, taken }) =>
    drawLarge(`moving${taken ? ' taken' : ''}`, to, taken ? `${to} has a note` : `${from} → ${to}`),
};

const shape = (at, half, high) =>
  `M${(at - half).toFixed(1)} ${RULER - 1 - high}h${2 * half}v${high - half}l${-half} ${half}l${-half} ${-half}z`;

function drawNotes() {
  const seen = seenOf(allNotes()).filter(({ frame }) => frame !== held('note')?.from);
  if (!seen.length) return nothing;
  const marks = (notes) => notes.map(({ frame }) => shape(x(frame), 3.5, HIGH)).join('');
  return svg`<path class="note" d=${marks(seen.filter(({ text }) => text))} />
    <path class="note bare" d=${marks(seen.filter(({ text }) => !text))} />`;
}

const drawLarge = (looks, at, words) =>
  svg`<path class=${`note ${looks}`} d=${shape(x(at), 5, 10)} />${plate(words, x(at), RULER + 12)}`;
