// The five steps to a first pose, in the order the guide goes through them. A step takes its tool in
// hand; any other way of doing it counts as well. `name` is the server's key.

import { S } from '../state.js';

/**
 * takes: which handles are to be dragged, in which view. again: it is rarely done with one drag, so
 * the card waits for Next instead of moving on by itself.
 */
export const STEPS = [
  {
    name: 'hips',
    tool: 'move',
    takes: { view: 'main', kinds: ['root'] },
    word: 'Hips',
    title: 'Drag the waist onto the hips',
    text: 'Put the white diamond where the person’s hips are. The whole body comes along.',
  },
  {
    name: 'height',
    tool: 'move',
    again: true,
    takes: { view: 'main', kinds: ['root'] },
    word: 'Size',
    title: 'As large as the person',
    text: `Hold D and drag the diamond up or down until head and feet match the person’s. The body
      comes nearer or goes farther. Set the height in the Body tab first if you know it.`,
  },
  {
    name: 'limbs',
    tool: 'ends',
    again: true,
    takes: { view: 'main', kinds: ['end', 'middle'] },
    word: 'Limbs',
    title: 'Pull the limbs into place',
    text: 'Drag the white circles onto hands and feet, then onto elbows and knees.',
  },
  {
    name: 'depth',
    tool: 'ends',
    again: true,
    takes: { view: 'side', kinds: ['end'] },
    word: 'Depth',
    title: 'Look from the side',
    text: 'In Side, pull hands and feet that lie too near or too far.',
  },
  {
    name: 'key',
    word: 'Key',
    title: 'Press K',
    text: 'This frame becomes a keyframe: the motion will pass exactly through this pose.',
  },
];

/** What stands on the card after the last step: where to go on is the server's to say. */
export function ending() {
  const keys = S.keys?.frames.length ?? 0;
  const { words = '', reason = '' } = S.suggest ?? {};
  if (keys > 1) return { title: 'The first segment stands', text: `${words} ${sentence(reason)}` };
  const title = keys === 1 ? 'The first keyframe stands' : 'That is how to pose';
  return { title, text: `${words} Then T tracks the frames between.` };
}

/** A reason as a sentence of its own. */
function sentence(reason) {
  if (!reason) return '';
  return `${reason[0].toUpperCase()}${reason.slice(1)}${reason.endsWith('.') ? '' : '.'}`;
}
