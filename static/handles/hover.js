// What lies under the resting pointer: a handle at once, a part by asking the server, its name
// after a moment.

import { server, ui, setUi } from '../store/state.js';
import { bodyNamed } from '../store/bodies.js';
import { ask } from '../store/link.js';
import { interaction, redrawSoon } from './interaction.js';
import { isDrawingTool } from './sketch.js';
import { stackAt, targetAt, whichOf } from './targets.js';

const PAUSE_MS = 30;
const NAME_MS = 400;

let asking = false;
let asked = 0;
let wanted = null;
let naming = null;

/** The pointer moved over a view with nothing pressed. */
export function hover(view, x, y, touchy) {
  const target = targetAt(view, x, y, touchy);
  if (interaction.chosen && interaction.chosen.key !== target?.key) interaction.chosen = null;
  interaction.pointer = { view, x, y };
  const key = target?.key ?? null;
  if (interaction.hot?.key !== key || interaction.hot?.view !== view.name) {
    interaction.hot = key && { view: view.name, key };
    redrawSoon();
  }
  if (target) nameTarget(view, target, x, y);
  else askForPart(view, x, y);
  return target;
}

/** The pointer left, or what it saw is no longer true. */
export function leave() {
  interaction.hot = interaction.over = interaction.pointer = interaction.chosen = wanted = null;
  clearTimeout(naming);
  setUi('hover', null);
  redrawSoon();
}

/** The body moved under the pointer: the outline is stale until asked for again. */
export function refresh() {
  if (ui.dragging || !interaction.pointer) return;
  if (interaction.over) {
    interaction.over = null;
    redrawSoon();
  }
  const { view, x, y } = interaction.pointer;
  if (!ui.playing && !interaction.hot) askForPart(view, x, y);
}

function nameTarget(view, target, x, y) {
  wanted = null;
  setUi('hover', null);
  const which = target.handle ? whichOf(stackAt(view, x, y), target) : '';
  name({ view: view.name, part: target.key, outline: [], label: target.label, which, at: { x, y } });
}

/** Another of the handles under the resting pointer is meant: it is named at once. */
export function renameHandle() {
  if (!interaction.pointer || ui.dragging) return;
  const { view, x, y } = interaction.pointer;
  hover(view, x, y, false);
  clearTimeout(naming);
  showName();
}

function name(over) {
  if (interaction.over?.part === over.part && interaction.over.view === over.view) {
    interaction.over = { ...over, named: interaction.over.named };
    // A name that shows stays where it is while the part stays the same.
    if (interaction.over.named) interaction.over.at = interaction.over.at ?? over.at;
    return redrawSoon();
  }
  clearTimeout(naming);
  interaction.over = { ...over, named: false };
  if (over.label) naming = setTimeout(showName, NAME_MS);
  return redrawSoon();
}

function showName() {
  if (!interaction.over || ui.dragging) return;
  const { pointer } = interaction;
  interaction.over = {
    ...interaction.over,
    named: true,
    at: pointer ? { x: pointer.x, y: pointer.y } : interaction.over.at,
  };
  redrawSoon();
}

/** Ask which part is there: not before the last answer, and not too often; only the newest counts. */
function askForPart(view, x, y) {
  if (ui.playing || !server.file || ui.tool === 'pan' || isDrawingTool(ui.tool)) return;
  wanted = { view, x, y };
  askNext();
}

function askNext() {
  if (asking || !wanted) return;
  const wait = asked + PAUSE_MS - performance.now();
  if (wait > 0) {
    asking = true;
    setTimeout(() => {
      asking = false;
      askNext();
    }, wait);
    return;
  }
  const question = wanted;
  wanted = null;
  asking = true;
  asked = performance.now();
  pick(question.view, question.x, question.y).then((answer) => {
    asking = false;
    if (!wanted && interaction.pointer && !interaction.hot && !ui.dragging) show(question, answer);
    askNext();
  });
}

/** Parts under a place, front to back, and the outline of the first; none where the line is lost. */
export async function pick(view, x, y) {
  const none = { parts: [], outline: [], body: null };
  const answer = ask({ ask: 'pick', ...view.inMessage(), at: view.toView([x, y]) });
  return { ...none, ...(await answer.catch(() => none)) };
}

function show({ view, x, y }, { parts, outline, body }) {
  const part = server.body.parts.find(({ name: known }) => known === parts[0]);
  setUi('hover', part?.name ?? null);
  const other = bodyNamed(body);
  view.over.style.cursor = other ? 'pointer' : cursorFor(part);
  if (other) {
    name({ view: view.name, part: other.id, outline, label: other.name, at: { x, y } });
  } else if (part) {
    name({ view: view.name, part: part.name, outline, label: part.label, side: part.side, at: { x, y } });
  } else if (interaction.over) {
    clearTimeout(naming);
    interaction.over = null;
    redrawSoon();
  }
}

function cursorFor(part) {
  if (ui.tool === 'size') return 'crosshair';
  return part ? 'pointer' : '';
}
