// The Export menu: pictures of this frame, the motion, and what is not to be trusted in it.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { server, ui } from '../store/state.js';
import { chosenFrames, words } from '../store/clip.js';
import { EXPORTS, FORMATS } from '../store/orders.js';
import { frame } from '../actions/playhead.js';
import { askWhatIsMissing, hasMotion, motionFrames, notInstalled, viewShown } from '../actions/exporting.js';
import { keyOf, perform } from '../actions/actions.js';
import { actionBox, menuItem } from '../actions/buttons.js';
import { motionAction } from '../actions/table/export.js';
import { isTracked } from '../actions/tracking.js';
import { goal, places } from '../actions/review.js';
import { count, joined, range } from '../controls/words.js';
import { content, heading, line, menuButton, menuHolder, note, toggleMenu } from '../controls/menu.js';

/** What a form asks for besides the format: the first of its options, "rig, unit, markers, origin". */
const OPTIONS = EXPORTS.motion
  .slice(0, 4)
  .map(({ label }) => label.toLowerCase())
  .join(', ');

/** The labels of the formats of which this holds. */
const labels = (holds) =>
  joined(
    Object.values(FORMATS)
      .filter(holds)
      .map(({ label }) => label),
  );
const GAPLESS = labels(({ gaps }) => !gaps);
const OWN_TIMES = labels(({ ownTimes }) => ownTimes);

export function exportButton() {
  const face = html`${icon('exp')}<span class="word">Export</span>${far()}${icon('chev')}`;
  const act = () => {
    askWhatIsMissing();
    if (ui.exportJob) {
      perform(/** @type {const} */ ('exportFilm'));
    } // which shows how far it is
    else toggleMenu('export');
  };
  const button = menuButton('export', {
    kind: 'btn ghost',
    title: 'Export films, images and motion',
    label: 'Export',
    face,
    act,
  });
  return menuHolder('export', () => button, items, 'right export');
}

/** How far the export under way is. */
function far() {
  const { done = 0, of = 0 } = ui.exportJob ?? {};
  return of ? html`<span class="num"> ${Math.round((100 * done) / of)} %</span>` : nothing;
}

function items() {
  const all = server.segments ?? [];
  const frames = all.length ? `, frames ${range(...motionFrames())}` : '';
  return [
    heading(`Image of frame ${frame()}`),
    menuItem('saveImage', undefined, { right: sizeAndKey() }),
    menuItem('saveAllImages'),
    menuItem('copyImage'),
    line,
    menuItem('exportFilm', undefined, { right: chosenFrames() ? `${range(...motionFrames())} · MP4` : 'MP4' }),
    menuItem('exportImages', undefined, { right: 'ZIP' }),
    menuItem('exportSheet', undefined, { right: 'PNG' }),
    menuItem('exportMatte', undefined, { right: 'PNG, WebM, MOV' }),
    line,
    heading(`Motion${frames}`),
    menuItem('exportMotion', undefined, { right: OPTIONS }),
    ...Object.entries(FORMATS).map(([format, { reader }]) =>
      menuItem(motionAction(format), undefined, { right: reader, ...lacking(format) }),
    ),
    menuItem('saveAllMotion'),
    content(html`<div class="mtick">${actionBox('filterMotion', undefined, { role: 'menuitemcheckbox' })}</div>`),
    variableRateNote(),
    warning(),
    ...(places().length
      ? [menuItem('review', undefined, { label: `Review ${count(places().length, 'place')} above ${goal()} px first` })]
      : []),
    line,
    menuItem('saveReport', undefined, { right: 'verdicts, charts, images' }),
  ];
}

/** What cannot be written here, with what mends it. */
function lacking(format) {
  const off = notInstalled(format);
  return off ? { right: ui.exportMissing[format], off } : {};
}

/** Only the camera's picture has a size that is known here: the video's own. */
function sizeAndKey() {
  const { width, height } = server.file ?? {};
  const key = keyOf('saveImage');
  return viewShown() === 'main' && width ? `${width} × ${height} · ${key}` : key;
}

/** What a film whose rate varies becomes: tables keep its frames, animations need one rate. */
function variableRateNote() {
  if (!server.file?.times) return null;
  const rate = `${Number(server.file.fps.toFixed(3))} frames/s`;
  return note(
    ui.filterMotion
      ? `The film’s rate varies: filtered motion has ${rate}.`
      : `The film’s rate varies: ${OWN_TIMES} keep every frame’s time, all others have ${rate}.`,
  );
}

/** The frames of segments in a state, neighbours as one: [[50, 61], [75, 99]]. */
function spans(state) {
  const found = [];
  for (const { first, last } of (server.segments ?? []).filter((s) => s.state === state)) {
    if (found.at(-1)?.[1] === first) found.at(-1)[1] = last;
    else found.push([first, last]);
  }
  return found;
}

/** What formats that hold no gaps make of segments that are not tracked. */
function withoutGaps() {
  const tracked = (server.segments ?? []).filter(isTracked);
  if (!tracked.length || tracked.length === server.segments.length) return nothing;
  const gap = tracked.some((s, i) => i && tracked[i - 1].last !== s.first);
  const frames = range(tracked[0].first, tracked.at(-1).last);
  return gap ? ` ${GAPLESS} need all of them.` : ` ${GAPLESS} hold ${frames} alone.`;
}

/** "Frames 75–99 are lost and 50–61 are outdated. CSV and NPZ say so per frame." */
function warning() {
  const parts = ['lost', 'outdated', 'none'].flatMap((state) => {
    const names = spans(state).map(([first, last]) => range(first, last));
    return names.length ? [{ state, names }] : [];
  });
  if (!parts.length || !hasMotion()) return null;
  const say = ({ state, names }, first) => {
    const noun = first ? 'Frames ' : ' and ';
    return html`<span class=${state === 'lost' ? 'lostword' : nothing}
      >${noun}${joined(names)} are ${state === 'none' ? `not ${words().done}` : state}</span
    >`;
  };
  const clauses = parts.map((part, i) => say(part, i === 0));
  return note(html`${clauses}. CSV and NPZ say so per frame.${withoutGaps()}`);
}
