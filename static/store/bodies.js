// The bodies of the scene, and which of them is posed.

import { server } from './state.js';

/** @typedef {import('./shapes.js').BodyOfScene} BodyOfScene */

/** All of them, in the order in which they came. @returns {BodyOfScene[]} */
export const bodies = () => server.bodies ?? [];

/** @returns {BodyOfScene | undefined} */
export const posedBody = () => bodies().find(({ posed }) => posed);

/** Those that are not posed. @returns {BodyOfScene[]} */
export const bodiesBeside = () => bodies().filter(({ posed }) => !posed);

/** @param {string} id @returns {BodyOfScene | undefined} */
export const bodyNamed = (id) => bodies().find((body) => body.id === id);
