// The command search: everything that can be looked for by its words, and how well it fits. An entry:
// { id, kind, title, icon, key, off: why not, on, fields, menus, run }.

import { count, joined, longAgo } from '../controls/words.js';
import { frameCount, lastFrame } from '../store/clip.js';
import { select } from '../store/parts.js';
import { server, setUi, ui } from '../store/state.js';
import { inBrowser } from '../store/storage.js';
import { entryOf, iconOf, isOn, keyOf, labelOf, perform, spell, titleOf, whyNot } from './actions.js';
import { menusWith } from './context_menus.js';
import { allNotes, noteAsOneLine } from './keying.js';
import { frame, goTo, isKey, segmentAt, stopPlaying } from './playhead.js';
import { isReviewing } from './review.js';
import { GROUPS } from './table.js';

const FITS = { whole: 100, beginning: 85, inside: 55, slip: 35, letters: 30 };
const LEAST_FOR_SLIP = 4;

/** Lower case, without accents, in words. */
const wordsIn = (text) =>
  text
    .toLowerCase()
    .normalize('NFD')
    .replace(/\p{M}/gu, '')
    .split(/[^\p{L}\p{N}]+/u)
    .filter(Boolean);

/**
 * How well a query fits, 0 where it does not: every word of it must fit one of a field's words.
 * @param {string} query
 * @param {{ text: string, weight: number }[]} fields  The weightiest first.
 */
export function fitOf(query, fields) {
  const wanted = wordsIn(query);
  if (!wanted.length) return 0;
  const known = fields.map(({ text, weight }) => ({ words: wordsIn(text), weight }));
  let sum = 0;
  for (const word of wanted) {
    const best = Math.max(
      0,
      ...known.map(({ words, weight }) => weight * Math.max(0, ...words.map((one) => wordFit(word, one)))),
    );
    if (best === 0) return 0;
    sum += best;
  }
  return sum / wanted.length + orderBonus(wanted, known[0].words);
}

/** What begins as the query does, or is no longer than it, stands before what only contains it. */
function orderBonus(wanted, words) {
  const starts = words[0]?.startsWith(wanted[0]) ? 8 : 0;
  const isSame = words.length === wanted.length && words.every((word, i) => word.startsWith(wanted[i]));
  return starts + (isSame ? 8 : 0) - Math.min(6, words.length * 0.5);
}

function wordFit(wanted, word) {
  if (word === wanted) return FITS.whole;
  if (word.startsWith(wanted)) return FITS.beginning;
  if (wanted.length > 1 && word.includes(wanted)) return FITS.inside;
  if (wanted.length >= LEAST_FOR_SLIP && isSlip(wanted, word.slice(0, wanted.length + 1))) return FITS.slip;
  return wanted.length > 1 && wanted[0] === word[0] && isInOrder(wanted, word) ? FITS.letters : 0;
}

function isInOrder(wanted, word) {
  let at = 0;
  for (const letter of word) if (letter === wanted[at]) at += 1;
  return at === wanted.length;
}

/** One letter more, fewer or another, or two swapped; of a beginning of the word. */
function isSlip(wanted, word) {
  return [word, word.slice(0, wanted.length), word.slice(0, wanted.length - 1)].some((each) => isOneOff(wanted, each));
}

function isOneOff(a, b) {
  let start = 0;
  while (start < a.length && a[start] === b[start]) start += 1;
  let end = 0;
  while (end < Math.min(a.length, b.length) - start && a.at(-1 - end) === b.at(-1 - end)) end += 1;
  const [restA, restB] = [a.slice(start, a.length - end), b.slice(start, b.length - end)];
  if (restA.length <= 1 && restB.length <= 1) return true;
  return restA.length === 2 && restB === restA[1] + restA[0];
}

/** @typedef {import('./actions.js').ActionId} ActionId */
/** @typedef {{ text: string, weight: number }} Field */
/**
 * @typedef {object} Entry
 * @property {string} id
 * @property {string} kind  "Action", or what else it is.
 * @property {string} group  The heading it stands under while nothing is typed.
 * @property {string} title
 * @property {string} [icon]
 * @property {string} [side]  Of the body, where it is a part.
 * @property {string} [key]  The key that does the same.
 * @property {string} off
 * @property {boolean} [on]
 * @property {string} more  Where else it is.
 * @property {Field[]} fields
 * @property {() => unknown} run
 */

/** These are done to something that is pointed at; what of them one looks for stands elsewhere. */
const NOT_ALONE = new Set([
  'goTo',
  'goToStep',
  'duplicateKeyframe',
  'openRecent',
  'pinCorner',
  'splitPin',
  'copyKeyHere',
  'unkeyLimb',
  'search',
  'insertPose',
  'insertMirrored',
]);
/** What the others are done to here, where it is not the playhead or what is selected. */
const ABOUT = { zoomToSegment: () => segmentAt(frame()) ?? null };
const HELD = { drag: 'Held while dragging', pointer: 'Done with the pointer' };
/** Its keys are handled in the review alone, and it is done in it alone. */
const isReviewKeyOutsideReview = (handledBy) => handledBy === 'review' && !isReviewing();

const WEIGHTS = { title: 1, synonyms: 0.75, more: 0.45 };
/** The joint at which a part hangs, by which it is looked for as well. @type {Record<string, string>} */
const JOINTS = { thigh: 'hip', shin: 'knee', foot: 'ankle', upper_arm: 'shoulder', forearm: 'elbow', hand: 'wrist' };

/** The settings: where each is, and by what words it is looked for. */
export const SETTINGS = [
  {
    title: 'Rotation of the selected part',
    tab: 'part',
    section: 'Rotation',
    words: 'angle degrees euler bend twist numeric',
  },
  { title: 'Position of the body', tab: 'part', section: 'Position', words: 'translate coordinates root numeric' },
  { title: 'Size of the selected part', tab: 'part', section: 'Size', words: 'length width radius shape bone' },
  { title: 'Pins of the selected part', tab: 'part', section: 'Pins', words: 'contact plant foot' },
  { title: 'Floor height', tab: 'part', section: 'Floor', words: 'ground plane level' },
  {
    title: 'Body preset and height',
    tab: 'body',
    section: 'Body',
    words: 'male female adult elderly actor person figure tall',
  },
  {
    title: 'Parts and sizes',
    tab: 'body',
    section: 'Parts',
    words: 'all sizes proportions lengths limbs table racket tool prop bone',
  },
  {
    title: 'Lens',
    tab: 'camera',
    section: 'Lens',
    words: 'focal length field of view fov zoom mm calibration distortion intrinsics',
  },
  { title: 'Up direction', tab: 'camera', section: 'Up direction', words: 'vertical horizon gravity tilt level' },
  {
    title: 'Motion of the camera',
    tab: 'camera',
    section: 'Motion',
    words: 'static tripod pan tilt zoom shake handheld moving matchmove stands still',
  },
  { title: 'Lens distortion', tab: 'camera', section: 'Distortion', words: 'bent fisheye barrel k1 k2' },
  { title: 'Ignore masks', tab: 'camera', section: 'Ignore masks', words: 'regions mask exclude occlusion matte roto' },
  {
    title: 'Recording rate (slow motion)',
    tab: 'camera',
    section: 'Video',
    words: 'frame rate fps frames per second high speed recorded 240 timing',
  },
  { title: 'Deinterlace', tab: 'camera', section: 'Video', words: 'interlaced fields comb lines' },
  { title: 'Cues', tab: 'track', section: 'Cues', words: 'brightness keypoints depth lifting silhouette evidence' },
  { title: 'Method and quality', tab: 'track', section: 'Method', words: 'settings preview full smooth' },
  { title: 'Tracked motions', tab: 'track', section: 'Tracked motions', words: 'degrees of freedom dof joints locked' },
  { title: 'Results of this segment', tab: 'track', section: 'Segment', words: 'verdict score error rank' },
];

const FOR_RECENT = 6;
const FOR_OFF = -12;
const MOST_FOUND = 40;
const MOST_RECENT = 6;
const MOST_MENUS = 2;
const NOTE_LETTERS = 80;
const KEPT = 'keypose.recent-commands';

/**
 * What stands in the list for a query, the best first; for none what was used lately, then all.
 * @param {string} query
 * @param {string} kind  Of entries; All of them.
 */
export function found(query, kind = 'All') {
  const recent = recentIds();
  const all = allEntries().filter((one) => kind === 'All' || one.kind === kind);
  if (!query.trim()) return kind === 'All' ? withoutQuery(all, recent) : all;
  const ranked = all.map((entry) => ({ entry, fit: rank(entry, query, recent) })).filter(({ fit }) => fit > 0);
  ranked.sort((a, b) => b.fit - a.fit);
  return [...(kind === 'All' ? frameEntries(query) : []), ...ranked.slice(0, MOST_FOUND).map(({ entry }) => entry)];
}

function withoutQuery(all, recent) {
  const lately = recent
    .map((id) => all.find((entry) => entry.id === id))
    .filter(Boolean)
    .slice(0, MOST_RECENT);
  const actions = all.filter((entry) => entry.kind === 'Action' && !lately.includes(entry));
  return [...lately.map((entry) => ({ ...entry, group: 'Recent' })), ...actions];
}

function rank(entry, query, recent) {
  const fit = fitOf(query, entry.fields);
  if (fit === 0) return 0;
  return fit + (recent.includes(entry.id) ? FOR_RECENT : 0) + (entry.off ? FOR_OFF : 0);
}

/** Do what an entry stands for, and remember that it was used. */
export function runEntry(entry) {
  remember(entry.id);
  entry.run();
}

// --- what there is

/** @returns {Entry[]} */
export function allEntries() {
  const all = [...actionEntries(), ...recentFiles()];
  return server.file ? [...all, ...partEntries(), ...settingEntries(), ...noteEntries()] : all;
}

function actionEntries() {
  return GROUPS.flatMap(({ title, actions }) =>
    Object.keys(actions)
      .filter((id) => !NOT_ALONE.has(id))
      .map((id) => actionEntry(/** @type {ActionId} */ (id), title?.() ?? 'File')),
  );
}

/** @param {ActionId} id */
function actionEntry(id, group) {
  const { handledBy, keys = [], always } = entryOf(id);
  const held =
    HELD[handledBy] ?? (isReviewKeyOutsideReview(handledBy) ? `Start the review first${reviewKey()}` : undefined);
  const needsFile = !server.file && !always && id !== 'openFile' ? 'Open a video first' : '';
  const about = ABOUT[id]?.();
  const nothingThere = about === null ? 'There is no segment here' : '';
  const off = held ?? (needsFile || nothingThere || whyNot(id, about));
  const title = nothingThere ? 'Zoom to segment' : (entryOf(id).alone ?? String(labelOf(id, about)));
  const menus = menusWith(id);
  const tip = nothingThere ? '' : String(titleOf(id, about) ?? '');
  return made({
    id: `action:${id}`,
    kind: 'Action',
    group,
    title,
    icon: nothingThere ? 'grow' : iconOf(id, about),
    off,
    key: keys.length ? keys.map(spell).join(', ') : '',
    on: off ? undefined : isOn(id, about),
    more: menus.length ? `In the menu of ${joined(menus.slice(0, MOST_MENUS))}` : '',
    words: `${group} ${entryOf(id).also ?? ''}`,
    tip,
    run: () => perform(id, about),
  });
}

const reviewKey = () => ` (${keyOf('review')})`;

function partEntries() {
  return (server.body?.parts ?? []).map((part) =>
    made({
      id: `part:${part.name}`,
      kind: 'Part',
      group: 'Parts',
      title: part.label,
      side: part.side,
      off: '',
      on: server.view?.selected === part.name ? true : undefined,
      more: 'Select this part',
      words: `select ${part.name} ${jointOf(part.name)}`,
      run: () => select(part.name),
    }),
  );
}

const jointOf = (name) => JOINTS[name.replace(/^(left|right)_/, '')] ?? '';

function settingEntries() {
  const tabs = [
    ['part', 'Part'],
    ['body', 'Body'],
    ['camera', 'Camera'],
    ['track', 'Track'],
  ].map(([tab, label]) =>
    made({
      id: `tab:${tab}`,
      kind: 'Tab',
      group: 'Settings',
      title: `${label} tab`,
      icon: 'tabs',
      off: '',
      more: 'Inspector',
      words: 'settings panel inspector properties',
      run: () => setUi('tab', tab),
    }),
  );
  const sections = SETTINGS.map(({ title, tab, section, words }) =>
    made({
      id: `setting:${tab}:${section}`,
      kind: 'Setting',
      group: 'Settings',
      title,
      icon: 'tabs',
      off: '',
      more: `${tab[0].toUpperCase()}${tab.slice(1)} tab`,
      words: `settings ${words}`,
      run: () => {
        setUi('tab', tab);
        setUi('seek', section);
      },
    }),
  );
  return [...tabs, ...sections];
}

function noteEntries() {
  return allNotes().map((note) =>
    made({
      id: `note:${note.frame}`,
      kind: 'Note',
      group: 'Notes',
      title: noteAsOneLine(note, NOTE_LETTERS),
      icon: 'note',
      off: '',
      more: `Frame ${note.frame}`,
      words: `note notes ${note.frame} ${note.text}`,
      run: () => toFrame(note.frame),
    }),
  );
}

function recentFiles() {
  const others = (ui.library?.recents ?? []).filter(({ path, missing }) => path !== server.file?.path && !missing);
  return others.map((recent) =>
    made({
      id: `file:${recent.id}`,
      kind: 'Session',
      group: 'Recent sessions',
      title: recent.name,
      icon: 'film',
      off: '',
      more: `${count(recent.keyframes, 'keyframe')} · ${longAgo(recent.opened_at)}`,
      words: 'open recent session file',
      run: () => perform('openRecent', recent),
    }),
  );
}

/** "47", "frame 47", "go to 47". */
function frameEntries(query) {
  const [, digits] = query.trim().match(/^(?:go\s*to\s*)?(?:frame|f|keyframe|#)?\s*(\d{1,9})$/i) ?? [];
  if (digits === undefined || frameCount() === 0) return [];
  const to = Number(digits);
  const off = to > lastFrame() ? `The video has frames 0 to ${lastFrame()}` : '';
  return [
    made({
      id: 'frame',
      kind: 'Frame',
      group: 'Frames',
      title: `Go to frame ${to}`,
      icon: 'flag',
      off,
      more: isKey(to) ? 'Keyframe' : 'Frame',
      words: '',
      run: () => toFrame(to),
    }),
  ];
}

function toFrame(to) {
  stopPlaying();
  goTo(to);
}

/** @returns {Entry} */
function made({ words, tip = '', ...known }) {
  const fields = [
    { text: known.title, weight: WEIGHTS.title },
    { text: words, weight: WEIGHTS.synonyms },
    { text: `${known.more} ${tip}`, weight: WEIGHTS.more },
  ];
  return /** @type {Entry} */ ({ ...known, fields });
}

// --- what was used lately

function recentIds() {
  try {
    const kept = JSON.parse(inBrowser.read(KEPT) ?? '[]');
    return Array.isArray(kept) ? kept.filter((id) => typeof id === 'string') : [];
  } catch {
    return [];
  }
}

function remember(id) {
  if (id === 'frame') return;
  const ids = [id, ...recentIds().filter((other) => other !== id)].slice(0, MOST_RECENT);
  inBrowser.write(KEPT, JSON.stringify(ids));
}
