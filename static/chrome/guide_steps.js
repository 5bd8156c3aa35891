// The six steps to a first pose, in the order the guide goes through them. A step takes its tool in
// hand; any other way of doing it counts as well. `name` is the server's key.

import { send } from '../link.js';
import { S, put } from '../state.js';
import { fewestKeys, isSurface, words as subject } from '../subject.js';

const SIZE_IN_PICTURE = `Hold D and drag the point between the arrows until head and feet match: up
  makes the body smaller and farther. If you know the height, set it in the Body tab first.`;
const SIZE_IN_SURFACE = `Set the height in the Body tab until head and feet match, then the thickness
  of trunk and limbs. F lays the body into the surface: press it now, and again after the limbs.`;

/**
 * takes: which handles are to be dragged, in which view. again: it is rarely done with one drag, so
 * the card waits for Next instead of moving on by itself. rings: it needs those of the waist.
 * choices: buttons on the card, [{label, title, act, ends}]; one that `ends` the step leads on.
 */
export const STEPS = [
  {
    name: 'hips',
    tool: 'move',
    takes: { view: 'main', kinds: ['root'] },
    word: 'Hips',
    title: 'Drag the waist onto the hips',
    text: `Drag the point between the four arrows onto the person’s hips. The slider above makes the
      body fainter where it hides the person.`,
  },
  {
    name: 'height',
    tool: 'move',
    again: true,
    takes: { view: 'main', kinds: ['root'] },
    word: 'Size',
    title: 'As large as the person',
    get text() {
      return isSurface() ? SIZE_IN_SURFACE : SIZE_IN_PICTURE;
    },
  },
  {
    name: 'facing',
    tool: 'move',
    again: true,
    rings: true,
    word: 'Turn',
    title: 'Which way the person faces',
    text: `Left limbs are blue, right ones orange. For a turn in between, drag the green ring at the
      waist.`,
    choices: [
      faces('camera', 'Faces the camera'),
      faces('away', 'Turned away'),
      faces('left', 'Faces left', 'Toward the left edge of the picture'),
      faces('right', 'Faces right', 'Toward the right edge of the picture'),
    ],
  },
  {
    name: 'limbs',
    tool: 'ends',
    again: true,
    takes: { view: 'main', kinds: ['end', 'middle'] },
    word: 'Limbs',
    title: 'Pull the limbs into place',
    text: `Drag the ringed points onto hands and feet, then onto elbows and knees. A click on a foot
      or the head shows rings that turn it.`,
  },
  {
    name: 'depth',
    tool: 'ends',
    again: true,
    takes: { view: 'side', kinds: ['end'] },
    word: 'Depth',
    title: 'Look from the side',
    text: `In Side, pull hands and feet that lie too near or too far. Does the whole body lean the
      wrong way there? Turn it at the waist first (red ring).`,
    choices: [{ label: 'Turn the waist', title: 'Show the rings of the waist', act: turnWaist }],
  },
  {
    name: 'key',
    word: 'Key',
    title: 'Press K',
    text: 'This frame becomes a keyframe: the motion will pass exactly through this pose.',
  },
];

function faces(way, label, title = label) {
  return { label, title, act: () => send({ do: 'face', way }), ends: true };
}

/** Select the waist: its rings turn the whole body. */
export function takeWaist() {
  const root = S.body?.parts.find(({ parent }) => !parent)?.name;
  if (root && S.view?.selected !== root) send({ do: 'select', part: root });
}

function turnWaist() {
  put('tool', 'rotate');
  takeWaist();
}

/** What stands on the card after the last step: where to go on is the server's to say. */
export function ending() {
  const keys = S.keys?.frames.length ?? 0;
  if (keys >= fewestKeys()) return standing();
  const { words = '' } = S.suggest ?? {};
  const title = keys === 1 ? 'The first keyframe stands' : 'That is how to pose';
  return { title, text: isSurface() ? words : `${words} Then T tracks the frames between.` };
}

const ORDER = ['lost', 'check', 'good'];

/** With two keyframes and more: track them, and then what tracking found. */
function standing() {
  if (S.job?.state === 'running') {
    return { title: subject().doing, text: 'It may go on while you pose.' };
  }
  const { kind, words = '', reason = '' } = S.suggest ?? {};
  if (kind === 'track') {
    const where = isSurface() ? 'on both sides of the keyframes' : 'between the keyframes';
    return { title: `Press ${subject().verb} (T)`, text: `It finds the motion ${where}.` };
  }
  const found = ORDER.map((state) => (S.segments ?? []).find((s) => s.state === state)).find(Boolean);
  if (!found) return { title: 'That is how to pose', text: words };
  const isSaid = found.words.toLowerCase().includes(reason.toLowerCase());
  const title = `${found.first}–${found.last}. ${found.words}`;
  return { title, text: isSaid ? words : `${words} ${sentence(reason)}` };
}

/** A reason as a sentence of its own. */
function sentence(reason) {
  if (!reason) return '';
  return `${reason[0].toUpperCase()}${reason.slice(1)}${reason.endsWith('.') ? '' : '.'}`;
}
