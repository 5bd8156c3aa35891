// The pictures of the film: fetched and decoded ahead, shown when they are whole.

import { server, ui, setUi, watch } from '../store/state.js';
import { clampFrame, isSurface } from '../store/clip.js';
import { fetchOwn } from '../store/storage.js';
import { listen, send } from '../store/link.js';
import { changedAt, dueAt, framesAhead, rangeToPlay } from './clock.js';

const AHEAD = 24;
const MOST_BYTES = 400e6;
const MOST_LOADS = 6;
/** While playing, a picture waits this long for the server to move the body there too. */
const PATIENCE_MS = 80;
/** Pixels of a film whose pictures are fetched whole, however small they are shown. */
const LARGE = 1920 * 1080;
/** A last picture that did not come is asked for again so often. */
const AGAIN_MS = 500;

const decoded = new Map();
const refused = new Set();
const loading = new Map();
const queue = [];
let screen = null;
/** @type {(width: number, height: number) => void} */
let changed = () => {};
/** Pixels of the screen to one of the film; none until the film is shown. */
let across = 0;
let film = '';
let version = '';
let wanted = -1;
let shown = -1; // the frame whose picture is on the screen
/**
 * While playing. run: how the film is played. lap: how often it has begun again. due: the frame that should be seen.
 * sent, sentAt, n: the newest frame that the server was asked for, when, and the number of that message.
 * drawn: the newest frame whose picture was drawn. askedAt: when pictures were asked for last.
 */
let play = null;
/** Where playing left the playhead, {frame, n}: older answers of the server come after it. */
let left = null;

/** Draw into this canvas; `onSize(width, height)` when the pictures have another size. */
export function mountFrames(canvas, onSize) {
  screen = canvas.getContext('2d', { alpha: false });
  changed = onSize;
  watch(['file', 'camera'], newFilm);
  watch(['view'], () => server.view && (play ? followServer() : showServerFrame()));
  listen('state', () => left && server.done >= left.n && showServerFrame());
  watch(['u:connected'], () => (left = null));
  watch(['u:playing'], () => (ui.playing ? startPlaying() : stopPlaying()));
  watch(['u:speed', 'u:shuttle', 'u:loop', 'u:span'], playOtherwise);
}

/** The server's frame counts once it has applied where playing ended. */
function showServerFrame() {
  if (left && server.done < left.n && server.view.frame !== left.frame) return;
  if (left && server.done >= left.n) left = null;
  if (server.view) showFrame(server.view.frame);
}

/** Show this frame as soon as its picture is there; a later request replaces it. */
function showFrame(frame) {
  if (!server.file) return;
  wanted = clampFrame(frame);
  if (decoded.has(wanted)) draw(wanted);
  else loadFirst(wanted);
  loadAround(wanted);
}

/** The film is shown with so many pixels of the screen to one of its own. */
export function showAcross(pixels) {
  across = pixels;
  newFilm();
}

/** A picture of a large film is fetched with a pixel for so many of its own across as the screen has room for. */
function shrink() {
  const { width, height } = server.camera;
  if (isSurface() || width * height <= LARGE) return 1;
  return [4, 2].find((by) => by * across <= 1) ?? 1;
}

const addressOf = (frame) =>
  `/frame/${frame}.jpg?v=${encodeURIComponent(server.camera.image_version)}&shrink=${shrink()}`;

/** Whether the picture on the screen is this frame's, or will never be: it cannot be read. */
export const isPictureOf = (frame) => shown === frame || refused.has(frame);

function newFilm() {
  const file = server.file && server.camera ? `${server.file.path}|${server.file.video}` : '';
  const now = file && `${file}|${addressOf(0)}`;
  if (now === version) return;
  if (file !== film) blank(); // the same film through another lens may stay until it is there
  film = file;
  version = now;
  for (const bitmap of decoded.values()) bitmap.close();
  for (const abort of loading.values()) abort.abort();
  decoded.clear();
  loading.clear();
  refused.clear();
  queue.length = 0;
  shown = -1;
  if (now && server.view) showFrame(server.view.frame);
}

/** Rather no picture than a wrong one. */
function blank() {
  delete screen.canvas.dataset.frame;
  shown = -1;
}

function draw(frame) {
  if (shown === frame) return;
  const bitmap = decoded.get(frame);
  decoded.delete(frame); // the newest used stand last
  decoded.set(frame, bitmap);
  const { canvas } = screen;
  if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
    changed(bitmap.width, bitmap.height);
  }
  screen.drawImage(bitmap, 0, 0);
  shown = frame;
  canvas.dataset.frame = frame;
  setUi('shown', frame);
}

function loadFirst(frame) {
  const place = queue.indexOf(frame);
  if (place >= 0) queue.splice(place, 1);
  if (!loading.has(frame)) queue.unshift(frame);
  pump();
}

function loadAround(frame) {
  const last = server.file.frames - 1;
  queue.length = 0;
  for (const next of [
    frame,
    ...(play ? framesAhead(play.run, frame, AHEAD) : [1, -1, 2, -2, 3, -3].map((step) => frame + step)),
  ]) {
    if (next >= 0 && next <= last && !decoded.has(next) && !loading.has(next)) queue.push(next);
  }
  pump();
}

function pump() {
  while (loading.size < MOST_LOADS && queue.length) load(queue.shift());
}

async function load(frame) {
  const abort = new AbortController();
  const asked = version;
  loading.set(frame, abort);
  try {
    const answer = await fetchOwn(addressOf(frame), { signal: abort.signal });
    if (!answer.ok) {
      refused.add(frame);
      setUi('unreadable', frame);
      return void (frame === wanted && blank());
    }
    const bitmap = await createImageBitmap(await answer.blob());
    if (asked !== version) return void bitmap.close();
    decoded.set(frame, bitmap);
    evict();
    if (frame === wanted) draw(frame);
  } catch (error) {
    if (error.name !== 'AbortError') setTimeout(() => frame === wanted && showFrame(frame), 1000);
  } finally {
    if (loading.get(frame) === abort) loading.delete(frame);
    pump();
  }
}

/** Drop the pictures that were not used for longest. */
function evict() {
  let bytes = 0;
  for (const bitmap of decoded.values()) bytes += 4 * bitmap.width * bitmap.height;
  for (const [frame, bitmap] of decoded) {
    if (bytes <= MOST_BYTES || decoded.size <= 2 * AHEAD) return;
    if (frame === shown || frame === wanted) continue;
    bytes -= 4 * bitmap.width * bitmap.height;
    decoded.delete(frame);
    bitmap.close();
  }
}

function startPlaying() {
  if (!server.file || !server.view) return;
  const now = performance.now();
  play = { run: runFrom(server.view.frame, now), askedAt: 0, due: -1, n: null };
  beginLap(0);
  loadAround(play.run.from);
  requestAnimationFrame(tick);
}

/** How the film is played from a frame on, as things are chosen now. @returns {import('./clock.js').Run} */
function runFrom(at, began) {
  const { frames, fps, times } = server.file;
  const rate = ui.speed * ui.shuttle;
  const range = rangeToPlay({
    lastFrame: frames - 1,
    keys: server.keys?.frames ?? [],
    span: ui.span,
    at,
    way: Math.sign(rate),
  });
  return { ...range, began, rate, loops: ui.loop, fps, times };
}

/** Another speed, way or range while it plays: on from the frame that is due. */
function playOtherwise() {
  if (!play) return;
  const now = performance.now();
  const turns = Math.sign(ui.speed * ui.shuttle) !== Math.sign(play.run.rate);
  const { from } = changedAt(play.run, now, {});
  play.run = runFrom(from, now);
  if (turns || play.run.from !== from) beginLap(0);
}

/** Once more from its beginning, or the other way: nothing of this was seen yet. */
function beginLap(lap) {
  Object.assign(play, { lap, sent: null, sentAt: 0, drawn: null });
}

function stopPlaying() {
  if (!play) return;
  const { sent, n } = play;
  play = null;
  if (shown < 0) return;
  left = { frame: shown, n: sent === shown ? n : send({ do: 'go', frame: shown }) };
}

/**
 * Ask the server for the newest decoded frame that is due. Its picture is drawn when the body is there
 * (`followServer`), or after PATIENCE_MS.
 */
function tick(now) {
  if (!play) return;
  const due = dueAt(play.run, now);
  if (due.lap !== play.lap) beginLap(due.lap);
  const frame = newestReady(due.frame);
  if (frame !== null) {
    play.sent = frame;
    play.sentAt = now;
    play.n = send({ do: 'go', frame });
  }
  if (play.sent !== null && now - play.sentAt > PATIENCE_MS) drawOnward(play.sent);
  if (due.frame !== play.due || due.over) fetchDue(due.frame, now);
  play.due = due.frame;
  if (due.over && (play.drawn === due.frame || refused.has(due.frame))) setUi('playing', false);
  else requestAnimationFrame(tick);
}

/** Have what is due and what follows it; a picture that did not come is asked for again. */
function fetchDue(due, now) {
  if (play.due === due && now - play.askedAt < AGAIN_MS) return;
  play.askedAt = now;
  wanted = -1; // what arrives is drawn by `drawOnward` alone
  loadAround(due);
}

/** Whether a frame comes after another, the way it is played; all come after none. */
const isAfter = (frame, other) => other === null || Math.sign(play.run.rate) * (frame - other) > 0;

/** The server moved the body: its picture now comes with it. */
function followServer() {
  if (play.sent !== null && !isAfter(server.view.frame, play.sent)) drawOnward(server.view.frame);
}

/** Time does not run backward, though the server's answer for an earlier frame may come late. */
function drawOnward(frame) {
  if (!isAfter(frame, play.drawn) || !decoded.has(frame)) return;
  play.drawn = frame;
  draw(frame);
}

/** The newest picture that is there and not later than due; none when it was shown already. */
function newestReady(due) {
  const { run, lap, sent } = play;
  const way = Math.sign(run.rate);
  const first = lap === 0 ? run.from : way > 0 ? run.first : run.last;
  for (let frame = due; isAfter(frame, sent) && !isAfter(first, frame); frame -= way) {
    if (decoded.has(frame)) return frame;
  }
  return null;
}
