// The steps to a first pose, in the order the guide goes through them: six of a film posed by hand, four
// of a thing and of observed surfaces; those of a new film are in `film_steps`. A step takes its tool in hand; any
// other
// way of doing it counts as well. `name` is the server's key.

import { send } from '../store/link.js';
import { select } from '../store/parts.js';
import { server, setUi, ui } from '../store/state.js';
import { fewestKeys, isSurface, words as subject } from '../store/clip.js';
import { whom } from '../actions/drafting.js';
import { filmSteps } from './film_steps.js';

const SIZE = `Hold D and drag the point between the arrows until head and feet match. Dragging up
  makes the body smaller and farther away. If you know the height, set it in the Body tab first.`;

/** @typedef {import('./step.js').Step} Step */

/** @type {Step} */
const KEY = {
  name: 'key',
  word: 'Key',
  title: 'Press K',
  text: 'This frame becomes a keyframe: the motion will pass exactly through this pose.',
};

/** @type {Step[]} */
const BY_HAND = [
  {
    name: 'hips',
    tool: 'move',
    takes: { view: 'main', kinds: ['root'] },
    word: 'Hips',
    title: 'Drag the waist onto the hips',
    get text() {
      return `Drag the point between the four arrows onto the hips of ${whom()}. If the body hides
        ${whom()}, lower its opacity with the slider above.`;
    },
  },
  {
    name: 'height',
    tool: 'move',
    again: true,
    takes: { view: 'main', kinds: ['root'] },
    word: 'Size',
    get title() {
      return `Match the size of ${whom()}`;
    },
    text: SIZE,
  },
  {
    name: 'facing',
    tool: 'move',
    again: true,
    rings: true,
    word: 'Turn',
    title: 'Set the facing direction',
    text: `Left limbs are blue, right ones orange. To fine-tune, drag the green ring at the
      waist.`,
    choices: [
      faces('camera', 'Faces the camera'),
      faces('away', 'Faces away'),
      faces('left', 'Faces left', 'Towards the left edge of the image'),
      faces('right', 'Faces right', 'Towards the right edge of the image'),
    ],
  },
  {
    name: 'limbs',
    tool: 'ends',
    again: true,
    takes: { view: 'main', kinds: ['end', 'middle'] },
    word: 'Limbs',
    title: 'Pull the limbs into place',
    get text() {
      const ends = server.body?.is_animals ? 'paws or hooves' : 'hands and feet';
      return `Drag the ringed points onto ${ends}, then onto elbows and knees. Where shoulders
        or hips are off, drag those too. Click a foot or the head for rings that rotate it.`;
    },
  },
  {
    name: 'depth',
    tool: 'ends',
    again: true,
    takes: { view: 'side', kinds: ['end'] },
    word: 'Depth',
    title: 'Check from the side',
    text: `In the Side view, pull limbs that are too near or too far. If the whole body leans
      the wrong way, rotate it at the waist first (red ring).`,
    choices: [{ label: 'Rotate the waist', title: 'Show the rotation rings of the waist', act: turnWaist }],
  },
  KEY,
];

/** @type {Step[]} */
const OF_THING = [
  {
    name: 'hips',
    also: 'height',
    tool: 'move',
    again: true,
    takes: { view: 'main', kinds: ['root'] },
    word: 'Place',
    title: 'Move it onto the thing',
    text: `Drag the point between the four arrows. Hold D and drag up to move it farther away, down to
      bring it nearer.`,
  },
  {
    word: 'Size',
    title: 'Set its sizes',
    tool: 'size',
    text: `Drag its ends and sides until it is as long and as wide as the thing. Sizes you have measured go
      into the Part tab, in centimetres: they make every distance right.`,
  },
  {
    name: 'facing',
    tool: 'rotate',
    again: true,
    rings: true,
    word: 'Turn',
    title: 'Turn it like the thing',
    text: `Drag the rings. The corners of a box can also be dragged to where the picture shows them (V): four
      give its whole pose, two more fit its sizes as well.`,
  },
  KEY,
];

/** @type {Step[]} */
const IN_SURFACE = [
  {
    name: 'hips',
    also: 'height',
    tool: 'move',
    again: true,
    takes: { view: 'main', kinds: ['root'] },
    word: 'Place',
    title: 'Move the body into the surface',
    text: `Drag the point between the four arrows, here and in another view, until the body stands in
      the surface. The Body tab has its sizes.`,
  },
  {
    name: 'facing',
    tool: 'rotate',
    again: true,
    rings: true,
    word: 'Turn',
    title: 'Rotate it like the surface',
    text: 'Drag the rings until the body points the same way as the surface.',
  },
  {
    name: 'limbs',
    tool: 'ends',
    again: true,
    takes: { view: 'main', kinds: ['end', 'middle'] },
    word: 'Limbs',
    title: 'Pull the limbs near',
    text: 'Drag the ringed points near to where they belong, in any view.',
  },
  {
    name: 'key',
    word: 'Key',
    title: 'Press F, then K',
    text: `F fits the body to the surface. Where it is wrong, correct it and press F again. K adds the
      keyframe.`,
  },
];

/** The steps of the guide for what the session is about. */
export function steps() {
  if (isSurface()) return IN_SURFACE;
  if (ui.guidePath === 'film') return filmSteps();
  return ui.guidePath === 'thing' ? OF_THING : BY_HAND;
}

/** The way by hand for this body: a thing of one part has no limbs. */
export const pathByHand = () => (server.body?.parts.length === 1 ? 'thing' : 'hand');

/** Whether the guide leads to a pose by hand, not to a draft of the whole film. */
export const isByHand = () => isSurface() || ui.guidePath !== 'film';

/**
 * Whether this step has been done.
 * @param {Step} step
 */
export function isDone({ name, also, done }) {
  return done ? done() : Boolean(server.guide?.done[name] || server.guide?.done[also]);
}

/** Whether the pose has been kept: then there is nothing left to lead to. */
export const isKept = () => Boolean(server.guide?.done.key);

function faces(way, label, title = label) {
  return { label, title, act: () => send({ do: 'face', way }), ends: true };
}

/** Select the waist: its rings turn the whole body. */
export function takeWaist() {
  const root = server.body?.parts.find(({ parent }) => !parent)?.name;
  if (root) select(root);
}

function turnWaist() {
  setUi('tool', 'move'); // the whole body turns, hands and feet go along
  takeWaist();
}

/**
 * What stands on the card after the last step: where to go on is the server's to say.
 * @returns {Step}
 */
export function ending() {
  const { kind, title = '', detail = '', ahead } = server.suggest ?? {};
  const keys = server.keys?.frames.length ?? 0;
  if (keys < fewestKeys()) {
    const onward = ahead ? ' Or press A: the body is tracked ahead, and you correct where it leads.' : '';
    const then = isSurface() ? '' : ` Then press T to track the frames in between.${onward}`;
    return { title: keys === 1 ? 'First keyframe set' : 'Ready to pose', text: `${title}.${then}` };
  }
  if (server.job?.state === 'running') return { title: subject().doing, text: 'You can keep posing meanwhile.' };
  if (kind !== 'track') return { title, text: detail && `${detail}.` };
  const where = isSurface() ? 'on both sides of the keyframes' : 'between the keyframes';
  return { title: `Press ${subject().verb} (T)`, text: `It finds the motion ${where}.` };
}
