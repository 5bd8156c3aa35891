// The drawing is a stack of layers from back to front, each drawn again only when something it is drawn
// from changed: the playhead moves over lanes and curves that stay as they are.

import { nothing, render } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { GROUND } from './draw/ground.js';
import { PLAYHEAD } from './draw/playhead.js';
import { markOf, MARKS } from './marks.js';
import { grabbed, hovered } from './pointer.js';

/** What is dragged or hovered, over everything. @type {import('./mark.js').Layer} */
const AT_HAND = {
  group: 'top',
  z: 20,
  from: () => [grabbed(), hovered(), server.segments, server.curve, server.pins, ui.curveAxis, ui.span],
  draw({ rows }) {
    const what = grabbed() ?? hovered();
    const mark = markOf(what?.kind);
    return (grabbed() ? mark?.drag : mark?.tip)?.(what, rows) ?? nothing;
  },
};

const LAYERS = [...GROUND, ...PLAYHEAD, ...MARKS.flatMap(({ layers = [] }) => layers), AT_HAND].sort(
  (one, other) => one.z - other.z,
);

/** Build the groups, and return what draws the layers that changed. */
export function layersOf(drawing) {
  const groups = {};
  for (const name of ['back', 'frames', 'above', 'top']) groups[name] = group(drawing, name);
  groups.frames.setAttribute('clip-path', 'url(#tl-frames)');
  const layers = LAYERS.map((layer) => ({ ...layer, element: group(groups[layer.group]), before: null }));
  return (stage) => {
    const common = [
      stage.rows,
      stage.lanes,
      stage.scroll,
      stage.empty,
      stage.bottom,
      ui.timeWindow,
      ui.timeSize,
      server.file,
    ];
    for (const layer of layers) {
      const now = [...common, ...layer.from()];
      if (layer.before?.every((value, i) => Object.is(value, now[i]))) continue;
      layer.before = now;
      render(layer.draw(stage), layer.element);
    }
  };
}

function group(parent, name = '') {
  const element = document.createElementNS('http://www.w3.org/2000/svg', 'g');
  element.setAttribute('class', name);
  return parent.appendChild(element);
}
