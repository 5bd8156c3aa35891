// The ordered line to the server: edits and questions out, sections and answers in. Edits wait in
// edits.js until the server has them on its disk, also while the line is down.

import { acknowledge, due, keep, settle } from './edits.js';
import { unpacked } from './series.js';
import { fetchOwn, keyProtocols } from './storage.js';
import { setUi, applySections, ui } from './state.js';

const SILENT_MS = 3000; // the server says something every second
const GIVEN_UP_MS = 10_000; // a line so long silent is laid anew
const LOOK_MS = 500;
const AGAIN_MS = 150; // short: on this computer a refused try costs little, and a person is waiting

let socket = null;
let line = 0;
let isGreeted = false;
let receivedAt = performance.now(); // the last message of the server, or when the connection was made
let lookedAt = performance.now();
let questionCount = 0;
let strokes = 0;
const tab = Math.random().toString(36).slice(2, 10);
const questions = new Map();
const listeners = new Map();

/** Send an action; its number comes back, by which the server acknowledges it. */
export function send(action) {
  const n = keep(action);
  sendDue();
  return n;
}

/** Send what can be sent by now. */
export function sendDue() {
  // To a silent server nothing goes: of a gesture only the newest move is sent once it speaks again.
  if (!isOpen() || !isGreeted || !ui.connected) return;
  for (const message of due(line)) socket.send(JSON.stringify(message));
}

/** Ask something that concerns this tab alone; rejects when the line is down, or lost before the answer. */
export function ask(question) {
  if (!isOpen()) return Promise.reject(new Error('not connected'));
  const id = ++questionCount;
  return new Promise((resolve, reject) => {
    questions.set(id, { resolve, reject });
    socket.send(JSON.stringify({ ...question, id }));
  });
}

/** A name for one gesture: all edits that carry it are one undo step. */
export function newStroke(kind) {
  return `${tab}-${kind}-${++strokes}`;
}

/** Call fn for every message of this kind: "note", "refused", "state". */
export function listen(kind, fn) {
  if (!listeners.has(kind)) listeners.set(kind, new Set());
  listeners.get(kind).add(fn);
}

/** When the server last sent something, in the milliseconds of performance.now(). */
export const lastReceived = () => receivedAt;

export function connect() {
  setInterval(listenForSilence, LOOK_MS);
  layLine();
}

function layLine() {
  receivedAt = performance.now();
  socket = new WebSocket(`${location.origin.replace(/^http/, 'ws')}/events`, keyProtocols());
  socket.onopen = onOpen;
  socket.onmessage = (event) => receive(JSON.parse(event.data));
  socket.onclose = onClose;
}

function isOpen() {
  return socket !== null && socket.readyState === WebSocket.OPEN;
}

function onOpen() {
  line += 1;
  isGreeted = false;
  setUi('connected', true);
}

function onClose() {
  setUi('connected', false);
  dropQuestions();
  setTimeout(lookForServer, AGAIN_MS);
}

/** Lay the line again once somebody answers at this address. A browser puts off sockets by seconds
 * when many of them have failed, so it is asked by another way. */
async function lookForServer() {
  const { status } = await answerOf('/static/logo.svg');
  setUi('turnedAway', status === 403);
  if (status === 200) layLine();
  else setTimeout(lookForServer, AGAIN_MS);
}

async function answerOf(path) {
  try {
    return await fetchOwn(path, { method: 'HEAD', cache: 'no-store', signal: AbortSignal.timeout(SILENT_MS) });
  } catch {
    return { status: 0 }; // nobody answers
  }
}

/** A line can be dead without having been closed: a computer asleep, a network gone. */
function listenForSilence() {
  const now = performance.now();
  // A tab that was asleep itself has not received what was sent meanwhile.
  if (now - lookedAt > 2 * LOOK_MS + 1000) receivedAt = now;
  lookedAt = now;
  if (!socket || socket.readyState > WebSocket.OPEN) return; // it is about to be laid anew
  if (now - receivedAt > GIVEN_UP_MS) giveUp();
  else if (now - receivedAt > SILENT_MS) setUi('connected', false);
}

function giveUp() {
  const silent = socket;
  socket = null;
  for (const event of ['onopen', 'onmessage', 'onclose']) silent[event] = null;
  silent.close();
  setUi('connected', false);
  dropQuestions();
  lookForServer();
}

/** The line is lost: what was asked on it is not answered any more. */
function dropQuestions() {
  const unanswered = [...questions.values()];
  questions.clear();
  for (const { reject } of unanswered) reject(new Error('the line was lost'));
}

function receive(message) {
  receivedAt = performance.now();
  if (!ui.connected) {
    setUi('connected', true);
    sendDue();
  }
  if (message.t === 'reply') {
    questions.get(message.id)?.resolve(message);
    questions.delete(message.id);
    return;
  }
  if (message.t === 'state') {
    settle(message.dones ?? {});
    applySections(unpacked(message.set));
    acknowledge(message.acks ?? {});
    // Only now it is known which server this is, and what it has open.
    isGreeted = true;
    sendDue();
  }
  for (const fn of listeners.get(message.t) ?? []) fn(message);
}
