// Standing on the floor: when that can be done, and what finding drafts anew would change.

import { count, joined } from '../controls/words.js';
import { isSurface } from '../store/clip.js';
import { server } from '../store/state.js';
import { isFoot } from './pins.js';
import { isTracked } from './tracking.js';

export function whyNotStand() {
  if (isSurface()) return 'A body fitted to surfaces stands where they do';
  if (server.settings?.method === 'paper') return 'The published method has no pins';
  if (!server.body?.parts.some(isFoot)) return 'This body has no feet with heel and toe';
  const segments = server.segments ?? [];
  if (segments.some(isTracked)) return '';
  return segments.some(({ state }) => state === 'outdated')
    ? 'The tracked motion is out of date. Track again first'
    : 'Track first';
}

export function whyNotFindUp() {
  if (isSurface()) return 'Surfaces have no picture';
  return server.camera ? '' : 'Open a video first';
}

/** What drafts for another up direction would change; null where there are none. */
const lifts = () => server.camera?.lifts ?? null;

export function whyNotLift() {
  if (lifts()) return '';
  return server.draft ? 'The drafts are as the up direction has them' : 'There are no drafts';
}

/** Such as "280 drafts and 6 keyframes that nobody posed change; 5 segments are tracked anew". */
export function liftWords() {
  const { drafts = 0, keyframes = 0, segments = 0 } = lifts() ?? {};
  const posed = joined([drafts && count(drafts, 'draft'), keyframes && count(keyframes, 'keyframe')].filter(Boolean));
  const tracked = segments ? `; ${count(segments, 'segment')} ${segments === 1 ? 'is' : 'are'} tracked anew` : '';
  return `${posed} that nobody posed ${drafts + keyframes === 1 ? 'changes' : 'change'}${tracked}`;
}

/** Such as "Looks down by 12° ± 2°, leans 2° to the right". */
export function tiltWords() {
  const { tilt_deg: tilt, roll_deg: roll, up_off_deg: off } = server.camera;
  const [down, aside] = [Math.round(Math.abs(tilt)), Math.round(Math.abs(roll))];
  const by = off == null ? '' : ` ± ${off}°`;
  const looks = down ? `Looks ${tilt < 0 ? 'down' : 'up'} by ${down}°${by}` : `Looks straight ahead${by}`;
  return aside ? `${looks}, leans ${aside}° to the ${roll > 0 ? 'left' : 'right'}` : looks;
}

export const isUpKnown = () => Boolean(server.camera) && server.camera.up_origin !== 'camera';
