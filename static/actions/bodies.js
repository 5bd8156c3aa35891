// Several bodies in one film: which one is posed, and what it is called.

import { bodies, bodiesBeside, bodyNamed, posedBody } from '../store/bodies.js';
import { isSurface } from '../store/clip.js';
import { send } from '../store/link.js';
import { server, setUi } from '../store/state.js';
import { count } from '../controls/words.js';

const MOST = 32;

/** Why no body can be added. */
export function whyNotAddBody() {
  if (isSurface()) return 'Surfaces are of one body';
  if (!server.body) return 'Open a video first';
  return bodies().length < MOST ? '' : `The session has ${MOST} bodies already`;
}

/** Why there is no other body to go to, or to remove. */
export const whyNoOther = () => (bodies().length > 1 ? '' : 'There is no other body');

/** A body of the shelf; where none is named, one as the posed one is. @param {string} [preset] */
export const addMessage = (preset = server.body?.preset ?? server.body?.presets?.[0]?.name) => ({
  do: 'add_body',
  preset,
});

/** @param {string} [id]  The next one, where none is named. */
export function poseMessage(id) {
  const all = bodies();
  const next = all[(all.findIndex(({ posed }) => posed) + 1) % all.length];
  return { do: 'pose_body', body: id ?? next?.id ?? '' };
}

/** The body to go on with: where the posed one has no place to confirm, another that has; where it is good,
 * one that is not. @returns {import('../store/shapes.js').BodyOfScene | undefined} */
export function bodyAhead() {
  if (server.draft?.proposals.length) return undefined;
  const drafted = bodiesBeside().find(({ places }) => places.length);
  if (drafted || server.suggest?.kind !== 'good') return drafted;
  return bodiesBeside().find(({ open, worst }) => open || (worst && worst !== 'good'));
}

/** "2 places to confirm": what there is to do with it. @param {import('../store/shapes.js').BodyOfScene} body */
export function leftToDo({ places, open, segments, worst }) {
  if (places.length) return `${count(places.length, 'place')} to confirm`;
  if (open) return `${count(open, 'segment')} to track`;
  const number = segments.filter(({ state }) => state === worst).length;
  return worst && worst !== 'good' ? `${count(number, 'segment')} ${worst === 'lost' ? 'lost' : 'to check'}` : '';
}

/** "3 keyframes, 12 drafts": what of it is posed. @param {import('../store/shapes.js').BodyOfScene} body */
export function posedWords({ keys, drafts }) {
  if (!drafts) return count(keys.length, 'keyframe');
  return keys.length ? `${count(keys.length, 'keyframe')}, ${count(drafts, 'draft')}` : count(drafts, 'draft');
}

/** @param {string} [id] */
export const removeMessage = (id = posedBody()?.id ?? '') => ({ do: 'remove_body', body: id });

/** Type another name for it, where it is listed. @param {string} [id] */
export const renameBody = (id = posedBody()?.id) => setUi('bodyNaming', id ?? null);

/** @param {string} id @param {string} text */
export function nameBody(id, text) {
  setUi('bodyNaming', null);
  if (text.trim() !== bodyNamed(id)?.called) send({ do: 'call_body', body: id, name: text.trim() });
}
