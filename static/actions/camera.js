// How the film's camera moves: what is known of it, finding it, correcting it.

import { isSurface } from '../store/clip.js';
import { send } from '../store/link.js';
import { server } from '../store/state.js';
import { frame, goTo, stopPlaying } from './playhead.js';
import { isUpKnown } from './standing.js';

/** @typedef {'static' | 'turns' | 'moves'} CameraKind */
/** @typedef {import('../store/shapes.js').CameraFinding} CameraFinding */

/** Findings that hold for the whole film. */
const OF_ALL_FRAMES = ['rolling_shutter'];

/** The motion that counts; null while the camera is taken to stand still, or nobody looked. */
export const motion = () => (server.camera_motion?.counts ? server.camera_motion : null);

const isSaidToStand = () => server.settings?.static_camera === true;

/** Whether the camera is taken to stand still: as a person said, else as it was found. */
export const standsStill = () => server.settings?.static_camera ?? server.settings?.found_still === true;

/** Whether it is known to move, whatever is known of how. */
const doesMove = () => (server.settings?.static_camera ?? server.settings?.found_still) === false;

/** How it moves, as far as that is known. @returns {CameraKind | null} */
export const cameraKind = () => (standsStill() ? 'static' : (motion()?.kind ?? null));

/** What is known, in one line. */
export function cameraWords() {
  if (standsStill()) return isSaidToStand() ? 'The camera stands still, as you said.' : 'The camera stands still.';
  if (motion()) return motion().words;
  return doesMove()
    ? 'The camera does not stand still. Its motion is not known yet.'
    : 'Nobody has looked how the camera moves.';
}

/** Whether the camera moves and nobody knows how: that is worth finding. */
export const isCameraUnknown = () => doesMove() && cameraKind() === null;

export const isFindingCamera = () => server.job?.state === 'running' && server.job.kind === 'camera';

export function whyNotFindCamera() {
  if (isSurface()) return 'Surfaces have no picture';
  if (!server.camera) return 'Open a video first';
  return isFindingCamera() ? 'It is being found' : '';
}

/**
 * A person says how it moves. That it stands still counts at once, and so does a motion of this kind that was found
 * before; otherwise one is looked for.
 * @param {CameraKind} kind
 */
export function setCameraKind(kind) {
  if (kind === 'static') send({ do: 'settings', static_camera: true });
  else if (server.camera_motion?.kind === kind) send({ do: 'settings', static_camera: false });
  else send({ do: 'find_camera', camera: kind });
}

export function whyNotForgetCamera() {
  return server.camera_motion ? '' : 'No motion of the camera is known';
}

/** Why points of the background cannot be shown. */
export const whyNoBackground = whyNotForgetCamera;

/** The frames at which a person corrected it. */
export const cameraKeys = () => server.camera_motion?.keys ?? [];

export const isCameraKey = (at) => cameraKeys().includes(at);

export function whyNoCameraKey(at = frame()) {
  return isCameraKey(at) ? '' : `The camera is not corrected at frame ${at}`;
}

export function whyNotMatchCamera() {
  if (isSurface()) return 'Surfaces have no picture';
  if (!server.camera) return 'Open a video first';
  return motion() ? '' : 'Find the camera’s motion first';
}

/** The horizon says how the camera is tilted where it is known how it lies in the world. */
export function whyNotCameraHorizon() {
  return whyNotMatchCamera() || (isUpKnown() ? '' : 'Say what is up first: draw the horizon');
}

/** What is unknown or doubtful of the motion. @returns {CameraFinding[]} */
export const cameraFindings = () => motion()?.findings ?? [];

/** Whether a finding is about some frames, not about the whole film. @param {CameraFinding} found */
export const hasFrames = ({ kind }) => !OF_ALL_FRAMES.includes(kind);

/** @param {CameraFinding} found */
export function visitFinding({ first }) {
  stopPlaying();
  goTo(first);
}
