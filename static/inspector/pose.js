// Poses taken over whole: fitted to the picture, tracked, from the keyframes around, copied, mirrored,
// at rest; exchanged sides.

import { html } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { words } from '../store/subject.js';
import { button, iconButton } from '../controls/fields.js';
import { fitHereButton } from './fitting.js';
import { section } from './section.js';
import { reaches } from './seen.js';

const TRACKED = new Set(['good', 'check', 'lost']);

export function pose() {
  const empty = server.clipboard ? '' : 'No pose is copied yet. Copy one with Ctrl C';
  const icons = html`${iconButton({
    name: 'copy', label: 'Copy pose', key: 'Ctrl C', act: () => send({ do: 'copy_pose' }),
  })}${iconButton({
    name: 'paste', label: 'Paste pose', key: 'Ctrl V', off: empty,
    act: () => send({ do: 'paste_pose', mirrored: false }),
  })}${iconButton({
    name: 'reset', label: 'Reset the whole pose', key: 'Shift ⌫', act: () => send({ do: 'reset_pose' }),
  })}`;
  return section(
    'Pose',
    html`<div class="lr">
      ${fitHereButton()}
      ${button({
        name: 'take', label: `Take ${words().done}`, title: `Take the ${words().done} pose over as your own`,
        act: () => send({ do: 'take_tracked' }), off: untracked(),
      })}
      ${button({
        name: 'mirror', label: 'Paste mirrored', key: 'Ctrl Shift V', off: empty,
        title: 'Paste the copied pose with left and right exchanged',
        act: () => send({ do: 'paste_pose', mirrored: true }),
      })}
      ${fromKey(neighbour(-1), 'before', 'P')} ${fromKey(neighbour(1), 'after', '')}
      ${button({
        name: 'loop', label: 'Exchange sides', off: sides(),
        title: 'Exchange left and right: the left limbs go where the right ones are seen',
        act: () => send({ do: 'exchange' }),
      })}
    </div>`,
    icons,
  );
}

/** Why left and right cannot be exchanged, or ''. */
function sides() {
  return server.body.parts.some((part) => part.mirror) ? '' : 'This body has no left and right';
}

/** Why no tracked pose can be taken here, or ''. */
function untracked() {
  const here = server.view.frame;
  const result = (server.segments ?? []).some(
    (one) => reaches(one, here) && (TRACKED.has(one.state) || one.scores?.length),
  );
  return result ? '' : `Frame ${here} is not ${words().done} yet. ${words().verb} with T`;
}

/** The nearest keyframe before (−1) or after (+1) the present frame. */
function neighbour(way) {
  const frames = server.keys?.frames ?? [];
  const here = server.view.frame;
  return way < 0 ? frames.findLast((f) => f < here) : frames.find((f) => f > here);
}

function fromKey(frame, word, key) {
  const none = `There is no keyframe ${word} frame ${server.view.frame}`;
  return button({
    name: 'prev',
    flip: word === 'after',
    label: frame === undefined ? (word === 'before' ? 'Previous key' : 'Next key') : `From key ${frame}`,
    title: `Copy the pose of keyframe ${frame} to here`,
    key,
    off: frame === undefined ? none : '',
    act: () => send({ do: 'copy_key', from_frame: frame }),
  });
}
