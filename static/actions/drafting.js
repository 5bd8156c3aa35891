// Poses for every frame from a box around the person on one of them: whether it can begin, why not, and
// what to say of its result.

import { server, setUi, ui } from '../store/state.js';
import { bodies } from '../store/bodies.js';
import { clamp } from '../controls/arithmetic.js';
import { aboutTime, count, joined, range } from '../controls/words.js';
import { chosenFrames, frameCount, isSurface, lastFrame } from '../store/clip.js';
import { frame, placesToConfirm } from './playhead.js';

/** A person of fewer pixels has joints that are hard to tell apart. */
export const SMALL_PX = 60;

/** Why this body cannot be drafted, or ''. */
export function whyNotDraftable() {
  if (server.body?.is_persons) return '';
  if (!server.body?.is_animals) return 'Needs the body of a person, a dog or a horse';
  return animalNetwork() ? '' : `Needs a network of animals, added by ${ADDING_ANIMALS}`;
}

const ADDING_ANIMALS = '“keypose models add NAME --from FILE --sha256 DIGEST --animals”';

/** The network that drafts an animal: the chosen one, else the first that was added. */
function animalNetwork() {
  const all = server.networks?.filter((network) => network.of_animals) ?? [];
  return all.find(({ chosen }) => chosen) ?? all[0];
}

/** Whom the box is around: "the person" or "the animal". */
export const whom = () => (server.body?.is_animals ? 'the animal' : 'the person');

export const whyNotDrawBox = () => (isSurface() ? 'Drafts are made from a video' : whyNotDraftable());

export const whyNotDraft = () => whyNotDrafting() || (ui.box ? whyNotHere() : `Draw a box around ${whom()} first`);

function whyNotDrafting() {
  const { state, kind } = server.job ?? {};
  return whyNotDraftable() || (state === 'running' && kind === 'draft' ? 'Drafting already' : '');
}

/** The box lies on the frame of the playhead, which has to be one of those to draft. */
function whyNotHere() {
  const [first, last] = draftRange();
  return first <= frame() && frame() <= last
    ? ''
    : `The box must lie on one of the frames to draft, ${range(first, last)}`;
}

/**
 * First and last frame to draft: as chosen, else between the in and the out point, else all.
 * @returns {[number, number]}
 */
export const draftRange = () => ui.draftRange ?? usualRange();

const usualRange = () => chosenFrames() ?? [0, lastFrame()];

/** Choose them; the usual ones again where they are these. */
export function setDraftRange(first, last) {
  const from = clamp(first, 0, lastFrame());
  const to = clamp(last, from, lastFrame());
  const [start, end] = usualRange();
  setUi('draftRange', from === start && to === end ? null : [from, to]);
}

/** How many frames are to be drafted. */
export function draftCount() {
  const [first, last] = draftRange();
  return last - first + 1;
}

/** "Draft 120 frames, 40–159"; of all frames without which. */
export function draftLabel() {
  const [first, last] = draftRange();
  const words = `Draft ${count(draftCount(), 'frame')}`;
  return draftCount() === frameCount() ? words : `${words}, ${range(first, last)}`;
}

/** "Takes about 4 minutes.", where it takes long and this computer's pace is known; else ''. */
export function draftTimeWords(frames = draftCount()) {
  const network = server.body?.is_animals ? animalNetwork() : server.networks?.find(({ chosen }) => chosen);
  const pace = network?.frame_s ?? 0;
  const words = aboutTime(frames * pace);
  return words && `Takes ${words}. Cancel keeps what is found by then.`;
}

/** How many frames a draft was cancelled before. */
export const restCount = () => framesIn(server.draft?.rest ?? []);

const framesIn = (runs) => runs.reduce((sum, [first, last]) => sum + last - first + 1, 0);

export const whyNotDraftRest = () => (restCount() ? whyNotDrafting() : 'No frames are left to draft');

/** What is sent: the box as it lies over the frame of the playhead. */
export function draftMessage() {
  return { do: 'draft', frame: frame(), box: rounded(ui.box), ...framesAsked() };
}

function framesAsked() {
  const [first, last] = draftRange();
  return draftCount() === frameCount() ? {} : { first, last };
}

/** @param {number[]} box */
const rounded = (box) => box.map((side) => Math.round(10 * side) / 10);

/** The same of all people in these boxes: each becomes a body. @param {number[][]} boxes */
export function draftAllMessage([box, ...others]) {
  return { do: 'draft', frame: frame(), box: rounded(box), others: others.map(rounded), ...framesAsked() };
}

/** "Draft both people", "Draft all 3 people". */
export const draftAllLabel = (many) => (many === 2 ? 'Draft both people' : `Draft all${many ? ` ${many}` : ''} people`);

export const whyNotDraftAll = (many) => whyNotDrafting() || (many > 1 ? whyNotHere() : 'Only one person is found here');

/** What to say of a box around somebody small, or ''. */
export function smallWords() {
  const height = ui.box ? Math.round(ui.box[3] - ui.box[1]) : SMALL_PX;
  return height < SMALL_PX
    ? `${capital(whom())} is small here (${height} px). Choose a nearer frame if there is one.`
    : '';
}

/** @type {Record<string, (parts: string) => string>} */
const REASONS = {
  start: () => 'first frame of the draft',
  end: () => 'last frame of the draft',
  pose: () => 'extreme pose of the motion',
  residual: (parts) => `${parts} may be off`,
  hidden: (parts) => `${parts} hidden`,
  flip: (parts) => `${parts} may point the other way`,
  wrong: (parts) => `${parts} is wrong: correct it`,
  person: () => 'may be another person from here on',
};

/** "Right forearm hidden": why a place should be confirmed. */
export function reasonOf({ reason, parts }) {
  const words = REASONS[reason]?.(partWords(parts)) ?? '';
  return capital(words);
}

const capital = (words) => words.charAt(0).toUpperCase() + words.slice(1);

/** Several are named by the first of them. */
function partWords(parts) {
  if (parts.length === 0) return 'the body';
  const more = parts.length > 1 ? ` and ${count(parts.length - 1, 'more part')}` : '';
  return `${parts[0].toLowerCase()}${more}`;
}

/** "3 places to confirm" */
export const placesWords = () => `${count(placesToConfirm().length, 'place')} to confirm`;

/** "Drafted 150 of 180 frames.", or "Drafted 31–179." where it is one end that lacks; and of how many
 * the tracked pose is shown. */
export function draftedWords(draft) {
  const { drafted, behind } = draft;
  const where = drafted === 1 ? 'there' : `at ${behind === drafted ? 'all' : behind} of them`;
  return behind ? `${foundWords(draft)} The tracked motion is shown ${where}.` : foundWords(draft);
}

function foundWords({ first, last, drafted, missing, rest = [] }) {
  const all = last - first + 1;
  if (rest.length) return `Drafted ${count(drafted, 'frame')}, ${framesIn(rest)} are left${ofAllLeft(framesIn(rest))}.`;
  if (drafted === all) return `Drafted ${count(all, 'frame')}.`;
  const [gap] = missing;
  if (missing.length === 1 && gap[0] === first) return `Drafted ${range(gap[1] + 1, last)}.`;
  if (missing.length === 1 && gap[1] === last) return `Drafted ${range(first, gap[0] - 1)}.`;
  return `Drafted ${drafted} of ${count(all, 'frame')}.`;
}

/** " of Anna and Ben", where drafts of several bodies were cancelled together; else ''. */
function ofAllLeft(many) {
  const cancelled = bodies().filter(({ posed, rest }) => posed || rest === many);
  return cancelled.length > 1 ? ` of ${joined(cancelled.map(({ name }) => name))}` : '';
}

/** "No person found in frames 10–30 and 6.": where a draft is missing, the longest of them; or ''. */
export function nobodyWords() {
  const runs = server.draft?.missing ?? [];
  if (runs.length === 0) return '';
  const named = [...runs].sort((one, other) => length(other) - length(one)).slice(0, PLACES_NAMED);
  const frames = runs
    .filter((run) => named.includes(run))
    .map(([first, last]) => (first === last ? `${first}` : range(first, last)));
  const isOne = runs.length === 1 && length(runs[0]) === 0;
  const noun = server.body?.is_animals ? 'animal' : 'person';
  return `No ${noun} found in ${isOne ? 'frame' : 'frames'} ${listed(frames, runs.length - frames.length)}.`;
}

/** "The person may change at 96 and 140.": where two people cross; or ''. */
export function personWords() {
  const at = placesToConfirm()
    .filter((place) => place.reason === 'person')
    .map((place) => String(place.frame));
  const named = at.slice(0, PLACES_NAMED);
  return at.length === 0 ? '' : `The person may change at ${listed(named, at.length - named.length)}.`;
}

/** "3, 9, 14 and 2 more places". @param {string[]} places */
const listed = (places, more = 0) => joined(more > 0 ? [...places, count(more, 'more place')] : places);

const PLACES_NAMED = 3;

const length = ([first, last]) => last - first;

/** The longest run of these. */
const longest = (runs) => runs.reduce((one, other) => (length(other) > length(one) ? other : one));

/** The frame to draw a box at, in the longest run without a draft: its middle; at an end of what was
 * drafted, where the person was seen last, as somebody who has left is not seen in the middle. */
export function boxFrameFor({ first, last, missing }) {
  const [from, to] = longest(missing);
  if (from === first) return to;
  return to === last ? from : Math.floor((from + to) / 2);
}

/** The frames to draft from a box there. */
export const runToDraft = (runs) => longest(runs);
