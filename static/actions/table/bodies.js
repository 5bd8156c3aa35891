// The bodies of the scene.

import { bondMessage, letGoMessage, whyNoBond, whyNotBond } from '../bonds.js';
import { addMessage, poseMessage, removeMessage, renameBody, whyNoOther, whyNotAddBody } from '../bodies.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const BODIES = {
  poseBody: {
    label: 'Next body',
    icon: 'person',
    also: 'switch other person character actor active',
    title: 'Pose the next body. So does a click on it',
    keys: ['Tab'],
    off: whyNoOther,
    message: poseMessage,
  },
  addBody: {
    label: 'Add a body',
    icon: 'plus',
    also: 'second person partner object prop racket ball animal rider',
    title: 'One more body in this film, with keyframes of its own',
    off: whyNotAddBody,
    message: addMessage,
  },
  bond: {
    label: 'Hold the nearest',
    icon: 'hand',
    also: 'bond grip grasp attach constrain touch contact handshake parent',
    title: 'The selected part and the nearest one of another body meet from here on, as long as they are as near',
    keys: ['Shift G'],
    off: () => whyNotBond(),
    message: bondMessage,
  },
  letGo: {
    label: 'Let go',
    icon: 'x',
    also: 'bond release detach',
    title: 'They do not meet any more',
    off: (index) => (index === undefined ? whyNoBond() : ''),
    message: letGoMessage,
  },
  nameBody: {
    label: 'Rename body',
    icon: 'pen',
    also: 'call name person',
    off: whyNoOther,
    run: renameBody,
  },
  removeBody: {
    label: 'Remove body',
    icon: 'trash',
    also: 'delete person',
    title: 'Remove the body from this session, with its keyframes',
    off: whyNoOther,
    message: removeMessage,
  },
};
