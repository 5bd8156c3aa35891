// The people whom the program finds in the picture on which a box is to be drawn: asked for once a frame, behind
// all else;
// which of them is meant.

import { send } from '../store/link.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { whyNotDrawBox } from './drafting.js';
import { frame } from './playhead.js';

/** Until the playhead has stood still so long nobody is looked for. */
const RESTS_MS = 250;
/** What stands before the finding of another film or frame, or of one that was left. */
const NONE = [];

/** @typedef {[number, number, number, number]} Box */

/** The frame whose people were asked for and are not known yet, with its film. */
let asked = '';
let timer = 0;
let wasAtWork = false;

export function mountPeople() {
  watch(['file', 'view', 'people', 'job', 'body', 'saved', 'u:tool', 'u:box', 'u:playing', 'u:connected'], () => {
    const isAtWork = server.job?.state === 'running';
    if (wasAtWork && !isAtWork) asked = ''; // it may have ended the looking
    wasAtWork = isAtWork;
    clearTimeout(timer);
    if (isWanted()) timer = window.setTimeout(ask, RESTS_MS);
  });
}

const here = () => `${server.file?.path} ${frame()}`;

/** Whether people may be proposed: a box is to be drawn, and none is. */
const isOpen = () =>
  Boolean(server.file) && ui.tool === 'box' && !ui.box && !ui.playing && isPersons() && !whyNotDrawBox();

const isPersons = () => !server.body?.is_animals;

const isKnown = () => server.people?.frame === frame();

function isWanted() {
  const mayAsk = ui.connected && server.saved?.state !== 'readonly' && server.job?.state !== 'running';
  return isOpen() && mayAsk && !isKnown() && asked !== here();
}

function ask() {
  if (!isWanted()) return;
  asked = here();
  send({ do: 'find_people', frame: frame() });
  setUi('lookedAt', asked);
}

/** Whether the answer of this frame is still to come. */
export const isLooking = () => isOpen() && !isKnown() && asked === here();

/** Boxes around those in the present picture, the tallest first; none once a box is drawn. @returns {Box[]} */
export const peopleHere = () => (isOpen() && isKnown() ? (server.people?.boxes ?? NONE) : NONE);

/** Whether somebody was looked for to the end and nobody found. */
export const isNobodyHere = () => isOpen() && isKnown() && server.people?.boxes?.length === 0;

/** The one that holds a place of the picture, the smallest of several. @param {[number, number]} spot */
export function personAt([x, y]) {
  const at = peopleHere().filter(([left, top, right, bottom]) => left <= x && x <= right && top <= y && y <= bottom);
  return at.sort((one, other) => area(one) - area(other))[0] ?? null;
}

const area = ([left, top, right, bottom]) => (right - left) * (bottom - top);

/** The one who is meant before anybody was pointed at. */
export const personMeant = () => (peopleHere().includes(ui.personHover) ? ui.personHover : peopleHere()[0]) ?? null;

/** The box is as if it had been drawn by hand. @param {Box | null} person */
export function takePerson(person = personMeant()) {
  if (person) setUi('box', [...person]);
}

/** What the picture on which a box is to be drawn holds, in a line; '' while nobody has looked. */
export function peopleWords() {
  if (isLooking()) return 'Looking for people in this frame…';
  if (isNobodyHere()) return 'No person found in this frame. Draw a box, or choose another frame.';
  const { length } = peopleHere();
  if (length === 1) return 'One person found. Press Enter, or click.';
  return length ? `${length} people found. Click the one to draft; Shift Enter drafts all.` : '';
}
