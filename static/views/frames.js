// The pictures of the film: fetched and decoded ahead, shown when they are whole.

import { server, ui, setUi, watch } from '../store/state.js';
import { clampFrame } from '../store/clip.js';
import { fetchOwn } from '../store/key.js';
import { listen, send } from '../store/link.js';

const AHEAD = 24;
const MOST_BYTES = 400e6;
const MOST_LOADS = 6;
/** While playing, a picture waits this long for the server to move the body there too. */
const PATIENCE_MS = 80;
/** A last picture that did not come is asked for again so often. */
const AGAIN_MS = 500;

const decoded = new Map();
const refused = new Set();
const loading = new Map();
const queue = [];
let screen = null;
/** @type {(width: number, height: number) => void} */
let changed = () => {};
let film = '';
let version = '';
let wanted = -1;
let shown = -1; // the frame whose picture is on the screen
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

function newFilm() {
  const file = server.file && server.camera ? `${server.file.path}|${server.file.video}` : '';
  const now = file && `${file}|${server.camera.image_version}`;
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
  const steps = play ? AHEAD : 3;
  queue.length = 0;
  if (!decoded.has(frame) && !loading.has(frame)) queue.push(frame);
  for (let step = 1; step <= steps; step++) {
    for (const next of play ? [frame + step] : [frame + step, frame - step]) {
      if (next < 0 || next > last || decoded.has(next) || loading.has(next)) continue;
      queue.push(next);
    }
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
    const url = `/frame/${frame}.jpg?v=${encodeURIComponent(server.camera.image_version)}`;
    const answer = await fetchOwn(url, { signal: abort.signal });
    if (!answer.ok) {
      refused.add(frame);
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
  const last = server.file.frames - 1;
  const first = server.view.frame >= last ? 0 : server.view.frame;
  play = { first, began: performance.now(), sent: -1, sentAt: 0, drawn: -1, due: -1, askedAt: 0 };
  loadAround(first);
  requestAnimationFrame(tick);
}

function stopPlaying() {
  if (!play) return;
  const { sent, n } = play;
  play = null;
  if (shown < 0) return;
  left = { frame: shown, n: sent === shown ? n : send({ do: 'go', frame: shown }) };
}

function tick(now) {
  if (!play) return;
  const due = dueFrame(Math.max(0, now - play.began) / 1000);
  const last = server.file.frames - 1;
  const frame = newestReady(Math.min(due, last));
  if (frame !== null && frame !== play.sent) {
    play.sent = frame;
    play.sentAt = now;
    play.n = send({ do: 'go', frame });
  }
  if (now - play.sentAt > PATIENCE_MS) drawOnward(play.sent);
  if (due !== play.due || due > last) fetchDue(Math.min(due, last), now);
  play.due = due;
  if (due > last && (play.drawn >= last || refused.has(last))) setUi('playing', false);
  else requestAnimationFrame(tick);
}

/** Have what is due and what follows it; a picture that did not come is asked for again. */
function fetchDue(due, now) {
  if (play.due >= due && now - play.askedAt < AGAIN_MS) return;
  play.askedAt = now;
  wanted = -1;
  loadAround(due);
}

/** The server moved the body: its picture now comes with it. */
function followServer() {
  if (server.view.frame <= play.sent) drawOnward(server.view.frame);
}

/** Time does not run backward, though the server's answer for an earlier frame may come late. */
function drawOnward(frame) {
  if (frame <= play.drawn || !decoded.has(frame)) return;
  play.drawn = frame;
  draw(frame);
}

/** The newest picture that is there and not later than due; none when it was shown already. */
function newestReady(due) {
  for (let frame = due; frame > Math.max(play.sent, play.first - 1); frame--) {
    if (decoded.has(frame)) return frame;
  }
  return null;
}

function dueFrame(seconds) {
  const { times, fps } = server.file;
  if (!times) return play.first + Math.floor(seconds * fps);
  let frame = play.first;
  while (frame < times.length && times[frame] - times[play.first] <= seconds) frame++;
  return frame < times.length ? frame - 1 : frame;
}
