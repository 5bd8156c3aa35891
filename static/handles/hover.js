// What lies under the resting pointer: a handle at once, a part by asking the server, its name
// after a moment.

import { server, ui, setUi } from '../store/state.js';
import { ask } from '../store/link.js';
import { hold, touch } from './hold.js';
import { targetAt } from './targets.js';

const PAUSE_MS = 30;
const NAME_MS = 400;

let asking = false;
let asked = 0;
let wanted = null;
let naming = null;

/** The pointer moved over a view with nothing held. */
export function hover(view, x, y, touchy) {
  const target = targetAt(view, x, y, touchy);
  hold.pointer = { view, x, y };
  const key = target?.key ?? null;
  if (hold.hot?.key !== key || hold.hot?.view !== view.name) {
    hold.hot = key && { view: view.name, key };
    touch();
  }
  if (target) nameTarget(view, target, x, y);
  else wantPart(view, x, y);
  return target;
}

/** The pointer left, or what it saw is no longer true. */
export function leave() {
  hold.hot = hold.over = hold.pointer = wanted = null;
  clearTimeout(naming);
  setUi('hover', null);
  touch();
}

/** The body moved under the pointer: the outline is stale until asked for again. */
export function refresh() {
  if (ui.dragging || !hold.pointer) return;
  if (hold.over) {
    hold.over = null;
    touch();
  }
  const { view, x, y } = hold.pointer;
  if (!ui.playing && !hold.hot) wantPart(view, x, y);
}

function nameTarget(view, target, x, y) {
  wanted = null;
  setUi('hover', null);
  const label = target.kind === 'ring' ? ringLabel(target) : target.label;
  name({ view: view.name, part: target.key, outline: [], label, at: { x, y } });
}

/** "Bend", "Twist": what the ring's axis means for this part. */
function ringLabel(ring) {
  const word = ring.part.words?.[ring.axis];
  return word && server.view.axes === 'part' ? `${word}, ${ring.axis.toUpperCase()}` : ring.axis.toUpperCase();
}

function name(over) {
  if (hold.over?.part === over.part && hold.over.view === over.view) {
    hold.over = { ...over, named: hold.over.named };
    // A name that shows stays where it is while the part stays the same.
    if (hold.over.named) hold.over.at = hold.over.at ?? over.at;
    return touch();
  }
  clearTimeout(naming);
  hold.over = { ...over, named: false };
  if (over.label) naming = setTimeout(showName, NAME_MS);
  return touch();
}

function showName() {
  if (!hold.over || ui.dragging) return;
  const { pointer } = hold;
  hold.over = { ...hold.over, named: true, at: pointer ? { x: pointer.x, y: pointer.y } : hold.over.at };
  touch();
}

/** Ask which part is there: not before the last answer, and not too often; only the newest counts. */
function wantPart(view, x, y) {
  if (ui.playing || !server.file || ui.tool === 'pan' || ui.tool === 'mask' || ui.tool === 'vertical') return;
  wanted = { view, x, y };
  pump();
}

function pump() {
  if (asking || !wanted) return;
  const wait = asked + PAUSE_MS - performance.now();
  if (wait > 0) {
    asking = true;
    setTimeout(() => {
      asking = false;
      pump();
    }, wait);
    return;
  }
  const question = wanted;
  wanted = null;
  asking = true;
  asked = performance.now();
  pick(question.view, question.x, question.y).then((answer) => {
    asking = false;
    if (!wanted && hold.pointer && !hold.hot && !ui.dragging) show(question, answer);
    pump();
  });
}

/** Parts under a place, front to back, and the outline of the first. */
export async function pick(view, x, y) {
  const none = { parts: [], outline: [] };
  // An answer that never comes, when the line drops, must not stop the questions.
  const late = new Promise((resolve) => setTimeout(resolve, 1500, none));
  const answer = ask({ ask: 'pick', view: view.name, at: view.toView([x, y]) });
  return { ...none, ...(await Promise.race([answer.catch(() => none), late])) };
}

function show({ view, x, y }, { parts, outline }) {
  const part = server.body.parts.find(({ name: known }) => known === parts[0]);
  setUi('hover', part?.name ?? null);
  view.over.style.cursor = cursorFor(part);
  if (part) {
    name({ view: view.name, part: part.name, outline, label: part.label, side: part.side, at: { x, y } });
  } else if (hold.over) {
    clearTimeout(naming);
    hold.over = null;
    touch();
  }
}

function cursorFor(part) {
  if (ui.tool === 'size') return 'crosshair';
  return part ? 'pointer' : '';
}
