// The ordered line to the server: edits and questions out, sections and answers in. Edits wait in
// edits.js until the server has them on its disk, also while the line is down.

import { acknowledge, due, keep, settle } from './edits.js';
import { keyProtocols } from './key.js';
import { setUi, applySections } from './state.js';

let socket = null;
let line = 0;
let isGreeted = false;
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
  if (!isOpen() || !isGreeted) return;
  for (const message of due(line)) socket.send(JSON.stringify(message));
}

/** Ask something that concerns this tab alone; rejects when the line is down. */
export function ask(question) {
  if (!isOpen()) return Promise.reject(new Error('not connected'));
  const id = ++questionCount;
  return new Promise((resolve) => {
    questions.set(id, resolve);
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

export function connect() {
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
  questions.clear();
  setTimeout(connect, 500);
}

function receive(message) {
  if (message.t === 'reply') {
    questions.get(message.id)?.(message);
    questions.delete(message.id);
    return;
  }
  if (message.t === 'state') {
    settle(message.dones ?? {});
    applySections(message.set);
    acknowledge(message.acks ?? {});
    // Only now it is known which server this is, and what it has open.
    isGreeted = true;
    sendDue();
  }
  for (const fn of listeners.get(message.t) ?? []) fn(message);
}
