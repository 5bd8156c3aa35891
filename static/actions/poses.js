// The library of poses: kept for every session, inserted at this frame.

import { toast } from '../controls/toasts.js';
import { send } from '../store/link.js';
import { server } from '../store/state.js';
import { frame } from './playhead.js';

export const MOST = 200;
const LONGEST = 60;

/** @typedef {import('../store/shapes.js').KeptPose} KeptPose */

/** @returns {KeptPose[]} */
export const keptPoses = () => server.poses ?? [];

/** "Pose 3": the first of these that no kept pose has. */
export function freeName(poses = keptPoses()) {
  const names = new Set(poses.map(({ name }) => name));
  let number = poses.length + 1;
  while (names.has(`Pose ${number}`)) number += 1;
  return `Pose ${number}`;
}

/** A name as it is kept; null where nothing is left of it. */
const readableName = (text) => text.replace(/\p{Cc}/gu, ' ').trim().slice(0, LONGEST) || null;

export const whyNotKeep = () => (keptPoses().length >= MOST ? `The library holds ${MOST} poses. Delete some first` : '');

export const keepMessage = () => ({ do: 'keep_pose', name: freeName() });

/** @param {KeptPose | undefined} pose */
export const whyNotInsert = (pose) => (pose && !pose.fits ? `This pose is of another body, ${pose.body}, without a part of this one` : '');

/** @param {KeptPose | undefined} pose */
export const insertTitle = (pose) => `Insert ${pose?.name ?? 'the pose'} at frame ${frame()}, where the body stands`;

/** @param {KeptPose} pose */
export function renamePose(pose, text) {
  const name = readableName(text);
  if (name && name !== pose.name) send({ do: 'rename_pose', id: pose.id, name });
}

/** @param {KeptPose} pose */
export function deletePose({ id, name }) {
  send({ do: 'delete_pose', id });
  const button = { label: 'Undo', run: () => send({ do: 'restore_pose', id }) };
  toast({ kind: 'info', words: `${name} deleted from the library.`, button, brief: true });
}
