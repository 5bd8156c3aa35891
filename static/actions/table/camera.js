// The motion of the film's camera: found, said, corrected, left.

import { server, setUi, ui } from '../../store/state.js';
import {
  cameraKind,
  setCameraKind,
  whyNoBackground,
  whyNoCameraKey,
  whyNotCameraHorizon,
  whyNotFindCamera,
  whyNotForgetCamera,
  whyNotMatchCamera,
} from '../camera.js';
import { frame } from '../playhead.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const CAMERA = {
  findCamera: {
    also: 'solve matchmove match move camera tracking pan tilt zoom shake handheld hand-held moving stabilise background',
    label: 'Find the camera’s motion',
    icon: 'wand',
    off: whyNotFindCamera,
    title: 'Pan, tilt, zoom and shake, from the background. Then the world stands still while the camera moves',
    message: () => ({ do: 'find_camera' }),
  },
  cameraStands: {
    also: 'static fixed tripod locked off',
    ...kind('static', 'Stands still', 'The camera stands still'),
    title: 'The camera does not move at all, as on a tripod',
  },
  cameraTurns: {
    also: 'pan tilt zoom roll nodal rotation',
    ...kind('turns', 'Turns', 'The camera turns in one place'),
    title: 'The camera pans, tilts or zooms in one place. Its motion is found from the background',
  },
  cameraMoves: {
    also: 'dolly travel handheld hand-held translation drone walk',
    ...kind('moves', 'Moves', 'The camera moves through the scene'),
    title: 'The camera is carried through the scene. Its motion is found from the background',
  },
  forgetCamera: {
    also: 'remove delete clear camera motion solve reset',
    label: 'Leave the camera as it was',
    icon: 'reset',
    off: whyNotForgetCamera,
    title: 'Forget the motion and its corrections: the world is what the camera sees',
    message: () => ({ do: 'forget_camera' }),
  },
  background: {
    also: 'features track markers dots camera motion solve',
    label: 'Show background points',
    icon: 'rings',
    off: whyNoBackground,
    title: 'Points that tell how the camera moves: dots agree with its motion, crosses do not and are left out',
    on: () => Boolean(server.view?.background),
    message: () => ({ do: 'display', background: !server.view?.background }),
  },
  cameraHorizon: {
    also: 'camera motion drift roll tilt level fix',
    label: 'Correct the camera by the horizon',
    icon: 'floor',
    off: whyNotCameraHorizon,
    title: 'Turn the camera at this frame until the horizon lies on a line you draw. What is up in the world stays',
    on: () => ui.tool === 'cameraHorizon',
    run: () => setUi('tool', 'cameraHorizon'),
  },
  cameraMatch: {
    also: 'camera motion drift survey fix align correspond',
    label: 'Match points of two frames',
    icon: 'link',
    off: whyNotMatchCamera,
    title: 'Mark points of the background at one frame and the same ones at another: the camera turns until they meet',
    on: () => ui.tool === 'cameraMatch',
    run: () => setUi('tool', 'cameraMatch'),
  },
  deleteCameraKey: {
    also: 'remove camera correction',
    label: 'Delete the camera’s correction',
    icon: 'trash',
    off: whyNoCameraKey,
    title: 'The camera at this frame as it was found',
    message: (at = frame()) => ({ do: 'delete_camera_key', frame: at }),
  },
};

/** @param {import('../camera.js').CameraKind} id */
function kind(id, label, alone) {
  return {
    label,
    alone,
    icon: 'camc',
    off: whyNotFindCamera,
    on: () => cameraKind() === id,
    run: () => setCameraKind(id),
  };
}
