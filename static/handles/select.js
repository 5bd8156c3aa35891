// Clicks: what they select, and what a second click at the same place means.

import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { select as selectPart } from '../store/parts.js';
import { chooseMask, deleteCorner, maskAt } from './masks.js';
import { distance } from './space.js';

const DOUBLE_MS = 350;
const SAME_PX = 5;

let last = { time: -Infinity, view: null, at: [0, 0], part: null, frame: -1 };

/** A click in a view at a time: on a target, on parts (front to back), or on nothing. */
export function click(view, { x, y, time: now }, target, parts) {
  const here = last.view === view.name && distance(last.at, [x, y]) < SAME_PX;
  const same = here && last.frame === server.view.frame;
  const twice = same && now - last.time < DOUBLE_MS;
  const part = target ? partOf(target) : partAt(parts, same && !twice);
  if (twice) clickTwice(view, x, y, target);
  else clickOnce(view, x, y, target, part);
  last = { time: twice ? -Infinity : now, view: view.name, at: [x, y], frame: server.view.frame, part: twice ? last.part : part };
}

/** The front part, or at a further click the one behind the selected. */
function partAt(parts, again) {
  if (!parts.length) return null;
  const at = parts.indexOf(server.view.selected);
  return again && at >= 0 ? parts[(at + 1) % parts.length] : parts[0];
}

/** The part that a target stands for, or null. */
export const partOf = (target) =>
  target.kind === 'ring' || target.kind === 'keypoint' || target.change || target.kind === 'trail' ? null : target.part;

function clickOnce(view, x, y, target, part) {
  if (target?.kind === 'trail') return void send({ do: 'go', frame: target.frame });
  if (target?.tell) return chooseMask(target.index);
  if (target?.kind === 'ring' || target?.kind === 'keypoint') return undefined;
  const mask = part ? null : maskAt(view, x, y);
  chooseMask(mask ? mask.index : null);
  if (!mask) select(part);
  return undefined;
}

function clickTwice(view, x, y, target) {
  if (target?.kind === 'corner') return deleteCorner(target);
  if (target?.change || target?.kind === 'ring' || target?.kind === 'keypoint' || maskChosen(view, x, y)) return undefined;
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
