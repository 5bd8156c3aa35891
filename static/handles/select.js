// Clicks: what they select, and what a second click at the same place means.

import { server, ui, setUi } from '../store/state.js';
import { select as selectPart } from '../store/parts.js';
import { chooseMask, maskAt } from './masks.js';
import { choose } from './interaction.js';
import { after, stackAt, targetAt } from './targets.js';
import { distance } from './space.js';

const DOUBLE_MS = 350;
const SAME_PX = 5;

let last = { time: -Infinity, view: null, at: [0, 0], part: null, frame: -1 };

/** A click in a view at a time: on a target, on parts (front to back), or on nothing. */
export function click(view, { x, y, time: now }, pressed, parts) {
  const here = last.view === view.name && distance(last.at, [x, y]) < SAME_PX;
  const same = here && last.frame === server.view.frame;
  const twice = same && now - last.time < DOUBLE_MS;
  const target = same && !twice ? further(view, x, y, pressed) : held(view, x, y, pressed);
  const part = target ? partOf(target) : partAt(parts, same && !twice);
  if (twice) clickTwice(view, x, y, target);
  else clickOnce(view, x, y, target, part);
  last = {
    time: twice ? -Infinity : now,
    view: view.name,
    at: [x, y],
    frame: server.view.frame,
    part: twice ? last.part : part,
  };
}

/** Where handles lie over each other, the pressed one is meant until the pointer leaves it. */
function held(view, x, y, target) {
  if (target) choose(view, stackAt(view, x, y), target);
  return target;
}

/** The handle behind the one that was pressed, which itself was chosen by the press before. */
function further(view, x, y, target) {
  const stack = target ? stackAt(view, x, y) : [];
  const next = stack.length > 1 ? after(stack, target) : target;
  if (next) choose(view, stack, next);
  return next;
}

/** Select the handle behind the one that is meant here; false where that is the last of them. */
export function selectBehind(view, x, y) {
  const stack = stackAt(view, x, y);
  const target = targetAt(view, x, y);
  if (stack.length < 2 || target.key === stack.at(-1).key) return false;
  select(further(view, x, y, target).part);
  return true;
}

/** The front part, or at a further click the one behind the selected. */
function partAt(parts, again) {
  if (!parts.length) return null;
  const at = parts.indexOf(server.view.selected);
  return again && at >= 0 ? parts[(at + 1) % parts.length] : parts[0];
}

/** The part that a handle stands for, or null. */
export const partOf = ({ handle, part }) => (handle ? part : null);

function clickOnce(view, x, y, target, part) {
  if (target?.click) return target.click();
  const mask = part ? null : maskAt(view, x, y);
  chooseMask(mask ? mask.index : null);
  if (!mask) select(part);
  return undefined;
}

function clickTwice(view, x, y, target) {
  if (target?.clickTwice) return target.clickTwice();
  if (maskChosen(view, x, y)) return undefined;
  const part = target?.part ?? last.part;
  if (!part) return view.fit();
  setUi('limb', limbOf(part));
  return undefined;
}

const maskChosen = (view, x, y) => ui.mask != null && maskAt(view, x, y)?.index === ui.mask;

/** Select a part, or nothing. */
export function select(part) {
  setUi('limb', null);
  selectPart(part);
}

/** The parts of the limb that a part belongs to; the part alone where it has none. */
function limbOf(part) {
  const handle = server.body.handles.find(({ limb }) => limb.includes(part));
  return handle ? handle.limb : [part];
}
