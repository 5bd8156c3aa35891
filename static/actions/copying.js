// Copying and pasting a pose or keyframes, and the library of kept poses. What cannot be written there
// is still copied within this session, by the server.

import { toast } from '../controls/toasts.js';
import { count } from '../controls/words.js';
import { ask, send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';
import { listed, met, occupied, selectedKeys, selectKeys } from './selection.js';
import { frame } from './playhead.js';

/** Put a text there that is still on its way; whether it could be. @param {Promise<string>} text */
export async function writeText(text) {
  try {
    if (window.ClipboardItem && navigator.clipboard?.write) {
      // Given as a promise, so that the key that was pressed still counts when it comes.
      const blob = text.then((known) => new Blob([known], { type: 'text/plain' }));
      blob.catch(() => {}); // reported by the clipboard, too
      await navigator.clipboard.write([new ClipboardItem({ 'text/plain': blob })]);
    } else {
      await navigator.clipboard.writeText(await text);
    }
    return true;
  } catch {
    return false;
  }
}

/** What is there; null where it cannot be read. */
export async function readText() {
  try {
    return await navigator.clipboard.readText();
  } catch {
    return null;
  }
}

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
const readableName = (text) =>
  text
    .replace(/\p{Cc}/gu, ' ')
    .trim()
    .slice(0, LONGEST) || null;

export const whyNotKeep = () =>
  keptPoses().length >= MOST ? `The library holds ${MOST} poses. Delete some first` : '';

export const keepMessage = () => ({ do: 'keep_pose', name: freeName() });

/** @param {KeptPose | undefined} pose */
export const whyNotInsert = (pose) =>
  pose && !pose.fits ? `This pose is of another body, ${pose.body}, without a part of this one` : '';

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

/** What the server takes in a message, and how many keyframes at a time. */
const LARGEST_BYTES = 1_000_000;
const MOST_KEYS = 500;
const NEWER = 'This was copied in a newer Keypose. Update this one to paste it.';
const NOTHING = 'The clipboard holds no pose or keyframes. Copy some first (Ctrl C).';

const VERSION = 1;

/** @typedef {{ keypose: 'pose' | 'keyframes', version?: number, keys: { after: number }[] }} Copied */
/** @typedef {{ mirrored?: boolean, onto_body?: boolean }} How */

/** What was copied here and did not get onto the clipboard. @type {string | null} */
let unwritten = null;

export const copyWords = () => (selectedKeys().length > 1 ? `Copy ${selectedKeys().length} keyframes` : 'Copy pose');

const canRead = () => Boolean(globalThis.navigator?.clipboard?.readText);

export const nothingCopied = () => (server.clipboard || canRead() ? '' : 'Copy a pose first (Ctrl C)');

export const whyNotCopy = () =>
  selectedKeys().length > MOST_KEYS ? `At most ${MOST_KEYS} keyframes can be copied at a time` : '';

/** Copy the selected keyframes, or the pose at this frame. */
export async function copy() {
  const frames = selectedKeys();
  send({ do: 'copy_pose', frames });
  const text = ask({ ask: 'copied', frames }).then((answer) => answer.text ?? Promise.reject(new Error('nothing')));
  const isWritten = await writeText(text);
  unwritten = isWritten ? null : await text.catch(() => null);
  setUi('copiedHere', !isWritten);
  if (frames.length > 1) toast({ kind: 'info', words: `${count(frames.length, 'keyframe')} copied.` });
}

/**
 * What a text holds, as far as the page can see: the server checks the rest.
 * @param {string | null} text
 * @returns {Copied | null}
 */
export function copiedIn(text) {
  if (!text || text.length > LARGEST_BYTES || !text.includes('"keypose"')) return null;
  try {
    const found = JSON.parse(text);
    const isOurs = ['pose', 'keyframes'].includes(found?.keypose) && Array.isArray(found.keys) && found.keys.length > 0;
    return isOurs && bytesOf(found) < LARGEST_BYTES ? found : null;
  } catch {
    return null;
  }
}

const bytesOf = (found) => new TextEncoder().encode(JSON.stringify(found)).length;

/** The frames at which the keyframes of what was copied would stand. @returns {number[]} */
export const framesFrom = (copied, at) => copied.keys.map((key) => at + Number(key?.after ?? 0));

/** Paste what was copied here where that did not get onto the clipboard, else what its text holds. */
export function pasteText(text, how = {}) {
  const copied = copiedIn(unwritten) ?? copiedIn(text);
  if (copied) return paste(copied, how);
  if (server.clipboard && (ui.copiedHere || !text)) return send({ do: 'paste_pose', ...how });
  return toast({ kind: 'check', words: NOTHING });
}

/** @param {Copied} copied @param {How} how */
function paste(copied, how) {
  if ((copied.version ?? VERSION) > VERSION) return toast({ kind: 'check', words: NEWER });
  const message = { do: 'paste_pose', ...how, copied };
  if (copied.keypose === 'pose') return send(message);
  const frames = framesFrom(copied, frame());
  const taken = met(occupied(), [], frames);
  const go = (more = {}) => {
    send({ ...message, ...more });
    selectKeys(frames);
  };
  if (!taken.length) return go();
  const words =
    taken.length === 1 ? `Frame ${taken[0]} is already a keyframe.` : `Frames ${listed(taken)} are already keyframes.`;
  const at = frame();
  return toast({
    kind: 'check',
    words,
    detail: 'Nothing was pasted.',
    brief: true,
    button: {
      label: taken.length === 1 ? 'Replace it' : 'Replace them',
      run: () => (frame() === at ? go({ replace: true }) : paste(copied, how)),
    },
  });
}

/** From a button or a menu: the clipboard is asked. @param {How} how */
export async function pasteWith(how) {
  pasteText(ui.copiedHere ? '' : await readText(), how);
}

// --- on its keys the browser delivers by itself what is on the clipboard

const PATIENCE_MS = 1000; // a browser that has much to do is late with it
/** @type {{ mirrored: boolean, timer: number } | null} */
let awaited = null;
let isOverdue = false;

/** Ctrl V was pressed: the paste event comes next; in a browser without one, nothing. */
export function awaitPaste(mirrored) {
  clearTimeout(awaited?.timer);
  isOverdue = false;
  awaited = { mirrored, timer: setTimeout(giveUp, PATIENCE_MS) };
}

function giveUp() {
  settle('');
  isOverdue = true;
}

/** The browser delivers what is on its clipboard. If it came too late, it would be pasted a second time. */
export function onPaste(text) {
  if (isOverdue) isOverdue = false;
  else settle(text);
}

/** `isElsewhere()`: whether what is pasted belongs to a field of text. */
export function mountPaste(isElsewhere) {
  document.addEventListener('paste', (event) => {
    if (isElsewhere() || !server.file) return;
    event.preventDefault();
    onPaste(event.clipboardData?.getData('text/plain') ?? '');
  });
}

function settle(text) {
  const { mirrored = false, timer } = awaited ?? {};
  clearTimeout(timer);
  awaited = null;
  pasteText(text, mirrored ? { mirrored } : {});
}
