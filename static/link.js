// The ordered line to the server: edits and questions out, sections and answers in. Edits made
// while the line is down wait here and are sent, in order, once it is back.

import { keyProtocols } from './key.js';
import { S, put, take } from './state.js';

let socket = null;
let count = 0;
let strokes = 0;
// randomUUID is there on this computer's own address only.
const tab = [...crypto.getRandomValues(new Uint8Array(8))].map((byte) => byte.toString(16).padStart(2, '0')).join('');
const waiting = [];
const questions = new Map();
const listeners = new Map();

/** Send an action; its number comes back, by which the server acknowledges it. */
export function send(action) {
  const message = { ...action, n: ++count };
  if (!isOpen()) {
    keep(message);
    return message.n;
  }
  socket.send(JSON.stringify(message));
  return message.n;
}

/** Ask something that concerns this tab alone; rejects when the line is down. */
export function ask(question) {
  if (!isOpen()) return Promise.reject(new Error('not connected'));
  const id = ++count;
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
  socket.onopen = opened;
  socket.onmessage = (event) => receive(JSON.parse(event.data));
  socket.onclose = closed;
}

/** How many edits wait for the line to come back. */
export function backlog() {
  return waiting.length;
}

function isOpen() {
  return socket !== null && socket.readyState === WebSocket.OPEN;
}

function keep(message) {
  const last = waiting.at(-1);
  // Moves of one gesture replace each other: each is told from the gesture's beginning.
  const same = last?.stroke && last.stroke === message.stroke && last.do === message.do;
  if (same) waiting.pop();
  waiting.push(message);
}

function opened() {
  put('connected', true);
  for (const message of waiting.splice(0)) socket.send(JSON.stringify(message));
}

function closed() {
  put('connected', false);
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
    S.done = message.done; // done or refused
    S.ack = message.ack; // and on the disk
    take(message.set);
  }
  for (const fn of listeners.get(message.t) ?? []) fn(message);
}
