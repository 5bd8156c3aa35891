// Edits on their way to the server: each is kept, over a reload too, until it is on the server's disk.
// When another server answers, they go to it, if its session is the one they were made in and is as
// they knew it; otherwise they wait until the person decides. None is made twice: the server
// knows by client and number what it has.

import { server, setUi, ui } from './state.js';
import { inTab } from './storage.js';

const NAME = 'keypose.edits';
const VERSION = 1; // of what is kept under this name
const LOOKS = {
  go: ({ frame }) => ({ frame }),
  limits: ({ on }) => ({ limits: on }),
  link: ({ on }) => ({ link: on }),
  axes: ({ frame }) => ({ axes: frame }),
  pose_body: ({ body }) => ({ body }),
};
const ENDS = new Set(['end_stroke', 'cancel_stroke']);
const NO_EDITS = new Set([
  ...Object.keys(LOOKS),
  ...ENDS,
  ...[
    'select',
    'display',
    'joint_angle',
    'live',
    'begin_guide',
    'dismiss_pins',
    'copy_pose',
    'keep_pose',
    'rename_pose',
    'delete_pose',
    'restore_pose',
    'find_people',
    'look_before',
    'close_fit',
    'close_up',
    'preview_poses',
    'discard_sizes',
    'reduce',
    'discard_reduction',
  ],
  ...['open', 'close', 'cancel', 'save_again'],
  ...['rename_session', 'duplicate_session', 'delete_session', 'restore_session'],
]);

let client = newClient();
let count = 0;
let entries = restore();
const own = new Set([client]);
const acked = new Map();
ui.unsent = []; // [{client, why, file, count}]: what waits for a decision
server.done = 0; // of this page's messages: done or refused
server.ack = 0; // and on the disk

/** Keep a message until it is acknowledged; its number. */
export function keep(message) {
  const n = ++count;
  const last = entries.at(-1);
  // Moves of one gesture replace each other: each is measured from the gesture's beginning.
  if (last && !last.blocked && isMove(message) && last.message.do === message.do && isOf(last, message)) entries.pop();
  for (const entry of entries) {
    if (isMove(entry.message) && !(isMove(message) && isOf(entry, message))) entry.over ??= n;
  }
  entries.push({
    client,
    n,
    message,
    server: server.server,
    file: fileNow(),
    revision: server.revision,
    look: lookNow(),
  });
  store();
  return n;
}

/** The server has done or refused these: the highest number of each client. */
export function settle(dones) {
  for (const [name, n] of Object.entries(dones)) if (own.has(name)) server.done = Math.max(server.done ?? 0, n);
}

/** The server has these on its disk: the highest number of each client. */
export function acknowledge(acks) {
  for (const [name, n] of Object.entries(acks)) {
    acked.set(name, Math.max(acked.get(name) ?? 0, n));
    if (own.has(name)) server.ack = Math.max(server.ack ?? 0, n);
  }
  const left = entries.filter((entry) => !isSafe(entry));
  if (left.length === entries.length) return;
  entries = left;
  store();
  publishUnsent();
}

/** The messages to send now, in order, of those that were not sent on this line yet. */
export function due(line) {
  const unsent = entries.filter((entry) => entry.line !== line);
  if (!unsent.length) return [];
  for (const entry of unsent) entry.blocked = whyNotSent(unsent.find((first) => isOneGroup(first, entry)));
  const free = unsent.filter((entry) => !entry.blocked);
  const messages = withLooks(free);
  for (const entry of free) Object.assign(entry, { server: server.server, line });
  entries = entries.filter((entry) => !entry.blocked || isWorthKeeping(entry));
  if (entries.some((entry) => entry.blocked && entry.client === client)) renewClient();
  store();
  publishUnsent();
  return messages;
}

/** Whether what the page shows is the answer to everything it has sent. */
export const isCaughtUp = () => (server.done ?? 0) >= count;

/** Whether the document stands as this message of ours has left it. */
export const isNewest = (n) => server.revision === `${client}:${n}`;

/** Whether it stands as a later message of ours has left it. */
export const isPast = (n) => {
  const [name, last] = (server.revision ?? '').split(':');
  return name === client && Number(last) > n;
};

/** How many edits wait for the line to come back. */
export const backlog = () => entries.filter((entry) => !entry.blocked && isEdit(entry)).length;

/** Let these be sent though the session has been changed since. */
export function release(name) {
  for (const entry of entries) if (entry.client === name) entry.agreed = true;
}

/** Of what is blocked only edits matter, and the ends of their gestures. */
const isWorthKeeping = (entry) =>
  isEdit(entry) ||
  (ENDS.has(entry.message.do) && entries.some((one) => isMove(one.message) && isOf(one, entry.message)));

/** The person does not want these. */
export function discard(name) {
  entries = entries.filter((entry) => !(entry.blocked && entry.client === name));
  store();
  publishUnsent();
}

// --- another server

const isOneGroup = (one, other) => one.client === other.client && one.file?.path === other.file?.path;

/** Why a group cannot be sent, by its first edit; null when it can. */
function whyNotSent({ file, server: origin, agreed, revision, client: name }) {
  if (!file) return null; // there was no session yet
  if (file.path !== server.file?.path) return 'elsewhere';
  if (origin === server.server) return null;
  if (server.saved?.state === 'readonly') return 'readonly';
  const isKnown = server.revision === revision || server.revision?.startsWith(`${name}:`);
  return isKnown || agreed ? null : 'changed';
}

/** What is made from now on may be sent before what is blocked, whose numbers must not come too late. */
function renewClient() {
  client = newClient();
  own.add(client);
}

/** Another server does not know at which frame one stood, which body was posed, and with which switches. */
function withLooks(some) {
  const messages = [];
  /** @type {Record<string, unknown>} */
  const at = { ...server.view };
  for (const { server: origin, look, message, client: name, n } of some) {
    if (origin !== server.server) messages.push(...steps(at, look));
    messages.push({ ...message, client: name, n });
    Object.assign(at, LOOKS[message.do]?.(message));
    if (message.do === 'undo' || message.do === 'redo') at.frame = at.body = null; // they go where they belong
  }
  return messages;
}

function steps(at, look) {
  const differs = (name) => look[name] !== undefined && look[name] !== at[name];
  const messages = [];
  if (differs('body')) messages.push({ do: 'pose_body', body: look.body });
  if (differs('frame')) messages.push({ do: 'go', frame: look.frame });
  if (differs('axes')) messages.push({ do: 'axes', frame: look.axes });
  for (const name of ['limits', 'link']) if (differs(name)) messages.push({ do: name, on: look[name] });
  Object.assign(at, look);
  return messages;
}

function publishUnsent() {
  const groups = new Map();
  for (const entry of entries.filter((one) => one.blocked && isEdit(one))) {
    const { client: name, blocked, file } = entry;
    const key = `${name} ${file?.path}`;
    if (!groups.has(key)) groups.set(key, { client: name, why: blocked, file, count: 0 });
    groups.get(key).count += 1;
  }
  const unsent = [...groups.values()];
  if (JSON.stringify(unsent) !== JSON.stringify(ui.unsent)) setUi('unsent', unsent);
}

// --- one entry

const isEdit = ({ message }) => !NO_EDITS.has(message.do);
const isMove = (message) => Boolean(message.stroke) && !ENDS.has(message.do);
const isOf = ({ message }, other) => message.stroke === other.stroke;

/** On the server's disk; a gesture is only once it has ended, however often it was acknowledged. */
function isSafe({ client: name, n, message, over }) {
  const upTo = acked.get(name) ?? 0;
  if (n > upTo) return false;
  const end = own.has(name) ? server.ack : upTo; // this page may have ended it under its next name
  return !isMove(message) || (over <= end && server.pose?.stroke !== message.stroke);
}

function fileNow() {
  return server.file ? { path: server.file.path, id: server.file.id, name: server.file.name } : null;
}

/** Where one stands, once all that is on its way is done. */
function lookNow() {
  if (!server.view) return {};
  const { frame, limits, link, axes, body } = server.view;
  const look = { frame, limits, link, axes, body };
  for (const { message, blocked } of entries) if (!blocked) Object.assign(look, LOOKS[message.do]?.(message));
  return look;
}

function newClient() {
  const bytes = crypto.getRandomValues(new Uint8Array(12)); // randomUUID is not there on every address
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('');
}

// --- over a reload

function store() {
  if (entries.length) inTab.write(NAME, JSON.stringify({ version: VERSION, entries }));
  else inTab.remove(NAME);
}

/** What a page of this tab did not get to its server. Its gestures are over. */
function restore() {
  try {
    const kept = JSON.parse(inTab.read(NAME) ?? 'null');
    if (kept?.version !== VERSION) return []; // another page's, which they would not mean the same to
    return kept.entries.filter(isEntry).map((entry) => ({ ...entry, line: null, over: entry.over ?? entry.n }));
  } catch {
    return []; // not as this page writes them
  }
}

function isText(value) {
  return typeof value === 'string';
}

function isObject(value) {
  return value !== null && typeof value === 'object' && !Array.isArray(value);
}

/** Whether an entry is as `keep` makes them. */
function isEntry(entry) {
  if (!isObject(entry) || !isObject(entry.message) || !isObject(entry.look)) return false;
  const { client: name, n, message, over, file, server: origin, revision } = entry;
  const isFile = file === null || (isObject(file) && [file.path, file.id, file.name].every(isText));
  const isNumbered = Number.isSafeInteger(n) && n > 0 && (over === undefined || Number.isSafeInteger(over));
  const texts = [name, message.do, origin ?? '', revision ?? '']; // no session was open, or no server known
  return texts.every(isText) && /^[0-9a-f]{24}$/.test(name) && isNumbered && isFile;
}
