// The films of the motion, a strip each: when it was taken, and in it which film sees the selected part, or
// the body, and where films disagree of it. A strip is dragged to move its film's clock; small triangles
// are where it may begin as well.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { perform } from '../../actions/actions.js';
import { filmEntries } from '../../actions/context_menus.js';
import { clockMessage, enlargeFilm, signed } from '../../actions/films.js';
import { settle, stopPlaying } from '../../actions/playhead.js';
import { Stroke } from '../../controls/gesture.js';
import { heading, openMenuAt } from '../../controls/menu.js';
import { films } from '../../store/films.js';
import { selectedPart } from '../../store/parts.js';
import { server } from '../../store/state.js';
import { held } from '../pointer.js';
import { plate } from '../draw/glyphs.js';
import { frameAt, GUTTER, isIn, seenOf, snapped, x } from '../draw/scale.js';

/** @typedef {import('../../store/shapes.js').Film} Film */

/** Heights of the first film's line and of each strip, and what is between them, px. */
const LINE = 4;
const STRIP = 10;
const GAP = 4;
const REACH_PX = 7;
const NAME_LETTERS = 15;

/** What the row takes, px. */
export const filmsHeight = () => (films().length ? GAP + LINE + films().length * (GAP + STRIP) + GAP : 0);

/** Where a film may begin as well. @type {import('../mark.js').Mark} */
export const filmMinimum = {
  kind: 'film_minimum',
  row: 'films',
  hit(place, { rows }) {
    for (const [at, film] of films().entries()) {
      const isHere = isIn(stripOf(rows.films, at), place.y);
      const begins = film.also.find((each) => Math.abs(x(each) - place.x) <= REACH_PX);
      if (isHere && begins !== undefined) return { id: film.id, begins };
    }
    return null;
  },
  cursor: 'pointer',
  grab: () => ({ move: () => null }),
  click({ id, begins }) {
    stopPlaying();
    const film = filmNamed(id);
    if (film) perform('filmBegins', { ...film, at: begins });
  },
  menu: ({ id }, { page }) => openMenu(id, page),
  tip: ({ begins }, rows) => plate(`May as well begin at ${signed(begins)}`, x(begins), below(rows)),
};

/** @type {import('../mark.js').Mark} */
export const filmStrip = {
  kind: 'film',
  row: 'films',
  layers: [
    {
      group: 'frames',
      z: 46,
      from: () => [server.films, server.films_seen, held('film')],
      draw: ({ rows }) => (rows.films ? drawStrips(rows.films) : nothing),
    },
    {
      group: 'above',
      z: 46,
      from: () => [server.films],
      draw: ({ rows }) => (rows.films ? drawNames(rows.films) : nothing),
    },
  ],
  hit(place, { rows }) {
    if (place.x < GUTTER) return null;
    const at = films().findIndex((film, i) => {
      const [from, to] = endsOf(film);
      return isIn(stripOf(rows.films, i), place.y) && place.x >= from && place.x <= to;
    });
    return at < 0 ? null : { id: films()[at].id };
  },
  cursor: 'ew-resize',
  edits: true,
  grab({ id }, start) {
    const film = filmNamed(id);
    if (!film) return null;
    const { begins } = film;
    const stroke = new Stroke('film', (frame) => clockMessage(film, frame));
    stopPlaying();
    return {
      move(place) {
        const moved = x(begins) + place.x - start.x;
        stroke.move(place.alt ? frameAt(moved) : snapped(moved, [begins, ...film.also]));
        return { id, from: begins };
      },
      end: () => stroke.end(),
      cancel: () => stroke.cancel(),
    };
  },
  click: settle,
  open({ id }) {
    const film = filmNamed(id);
    if (film) enlargeFilm(film);
  },
  menu: ({ id }, { page }) => openMenu(id, page),
  tip({ id }, rows) {
    const film = filmNamed(id);
    const words = `${film?.name} begins at ${signed(film?.begins ?? 0)}`;
    return film ? plate(words, x(film.begins), below(rows), ` · ${legend()}`) : nothing;
  },
  drag({ id, from }, rows) {
    const film = filmNamed(id);
    if (!film) return nothing;
    return plate(`begins at ${signed(film.begins)}`, x(film.begins), below(rows), ` was ${signed(from)}`);
  },
};

/** What the colours say. */
const legend = () => `green sees ${selectedPart()?.label.toLowerCase() ?? 'the body'}, magenta: films disagree`;

const filmNamed = (id) => films().find((film) => film.id === id);
const below = ({ films: row }) => row.y + row.h + 8;

function openMenu(id, page) {
  const film = filmNamed(id);
  if (film) openMenuAt(film.name, [heading(film.name), ...filmEntries(film)], page);
}

/** Of the film with this number, the first one being shown as a line. */
const stripOf = (row, at) => ({ y: row.y + GAP + LINE + GAP + at * (STRIP + GAP), h: STRIP });

/** Where a film begins and ends, px. @param {Film} film @returns {[number, number]} */
const endsOf = ({ begins, frames, rate }) => [x(begins), x(begins + (frames - 1) / rate)];

function drawStrips(row) {
  const line = { y: row.y + GAP, h: LINE };
  return svg`<g class="filmstrips">
    ${drawStrip(line, [x(0), x(server.file.frames - 1)], firstId())}
    ${films().map((film, at) => drawFilm(film, stripOf(row, at)))}
    ${(server.films_seen?.disagree ?? []).map((run) => drawDisagreement(run, row))}</g>`;
}

const drawFilm = (film, strip) => [drawStrip(strip, endsOf(film), film.id), drawMinima(film, strip)];

/** The first film is the one that is none of the others. */
const firstId = () => Object.keys(server.films_seen?.seen ?? {}).find((id) => !filmNamed(id)) ?? '';

function drawStrip({ y, h }, [from, to], id) {
  const runs = seenOf((server.films_seen?.seen[id] ?? []).map(([first, last]) => ({ first, last })));
  return svg`<rect class="filmstrip" x=${from} y=${y} width=${Math.max(1, to - from)} height=${h} rx="2" />
    ${runs.map(({ first, last }) => {
      const [left, right] = [Math.max(x(first - 0.5), from), Math.min(x(last + 0.5), to)];
      return right > left
        ? svg`<rect class="filmseen" x=${left} y=${y} width=${right - left} height=${h} rx="2" />`
        : nothing;
    })}`;
}

function drawDisagreement([first, last], row) {
  return svg`<rect class="filmapart" x=${x(first - 0.5)} y=${row.y + 1} width=${x(last + 0.5) - x(first - 0.5)}
    height=${row.h - 2} />`;
}

/** @param {Film} film */
function drawMinima({ also, begins }, { y, h }) {
  const mark = (at, kind) => svg`<path class=${kind} d=${`M${x(at) - 4} ${y + h + 3}h8l-4 -7z`} />`;
  return [...also.map((at) => mark(at, 'filmalso')), mark(begins, 'filmbegins')];
}

function drawNames(row) {
  const cut = (name) => (name.length > NAME_LETTERS ? `${name.slice(0, NAME_LETTERS - 1)}…` : name);
  return films().map(
    ({ name }, at) => svg`<text class="lbl" x="12" y=${stripOf(row, at).y + STRIP - 1}>${cut(name)}</text>`,
  );
}
