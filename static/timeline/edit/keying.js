// Setting and deleting a keyframe. K only ever sets one; what is deleted can be had back at once.

import { server } from '../../store/state.js';
import { send } from '../../store/link.js';
import { toast } from '../../controls/toasts.js';
import { frame, isKey } from './head.js';
import { draftFrames } from '../draw/keymarks.js';

/** K: the pose here is this frame's keyframe. Where it is one already, nothing is lost. */
export function setKey() {
  const at = frame();
  if (isKey(at) && !draftFrames().includes(at)) {
    const words = `Frame ${at} is a keyframe already. Its pose is kept as you change it; Delete removes it.`;
    toast({ kind: 'info', words });
  }
  send({ do: 'add_key', frame: at });
}

/** Delete a keyframe, by default the one under the playhead. */
export function deleteKey(at = frame()) {
  if (!isKey(at)) {
    toast({ kind: 'info', words: `Frame ${at} is no keyframe.` });
    return;
  }
  send({ do: 'delete_key', frame: at });
  const button = { label: 'Undo', run: () => bringBack(at) };
  toast({ kind: 'info', words: `Keyframe ${at} deleted.`, button, brief: true });
}

function bringBack(at) {
  if (server.undo?.undo === `delete keyframe ${at}`) send({ do: 'undo' });
  else toast({ kind: 'info', words: 'Other steps came after it. Ctrl Z takes back one after another.' });
}
