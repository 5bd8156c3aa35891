// The SVG over each view, drawn anew whenever what it shows has changed.

import { render, svg, nothing } from '../vendor/lit-html/lit-html.js';
import { partNamed } from '../store/parts.js';
import { ui } from '../store/state.js';
import { ALL_VIEWS, view as viewNamed } from '../views/views.js';
import { drawBackground } from './background.js';
import { drawBoxCorners } from './boxcorners.js';
import { drawGrips, drawLimb, drawReach } from './grips.js';
import { interaction } from './interaction.js';
import { drawKeypoints } from './keypoints.js';
import { drawLabels } from './labels.js';
import { drawMasks } from './masks.js';
import { drawOffline } from './drag.js';
import { drawPinMarks, drawPlace, drawSoles, drawTrail } from './marks.js';
import { drawRings } from './rings.js';
import { isLarge } from './scale.js';
import { drawSizes } from './sizes.js';
import { drawSketch } from './sketch.js';
import { pathOf } from './space.js';
import { isReady, targetsIn } from './targets.js';
import { drawUprights } from './uprights.js';

/** Draw the overlays of all views that are shown. */
export function paint() {
  for (const name of ALL_VIEWS) {
    const view = viewNamed(name);
    if (!view.isShown) continue;
    render(isReady(view) ? overlay(view) : nothing, view.over);
    drawLabels(view);
  }
}

function overlay(view) {
  const targets = targetsIn(view);
  const dragged = interaction.drag && !interaction.drag.gentle ? 'dragged' : '';
  const drawing = interaction.sketch ? `drawing ${interaction.sketch.tool}-tool` : '';
  const classes = `hands ${isLarge(view) ? 'large' : 'small'} ${dragged} ${drawing} on-${view.name}`;
  return svg`<g class=${classes}>
    ${drawBackground(view)}
    ${drawUprights(view)}
    ${drawMasks(view, targets.masks)}
    ${drawSoles(view)}
    ${drawTrail(view, targets.trail)}
    ${drawHover(view)}
    ${drawLimb(view)}
    ${drawReach(view, targets.grips)}
    ${drawPlace(view)}
    ${drawBoxCorners(view, targets.corners)}
    ${drawGrips(view, targets.grips)}
    ${drawOffline(view)}
    ${drawPinMarks(view)}
    ${drawSizes(view, targets.sizes)}
    ${drawRings(view, targets.rings)}
    ${drawKeypoints(view, targets.keypoints)}
    ${drawSketch(view)}
  </g>`;
}

/** The outline of the part under the pointer, in its own colour. */
function drawHover(view) {
  const over = interaction.over;
  if (over?.view !== view.name || !over.outline.length || ui.dragging) return nothing;
  const side = partNamed(over.part)?.side ?? 'C';
  const d = pathOf(
    over.outline.map((p) => view.fromView(p)),
    true,
  );
  return svg`<path class="outline-edge" d=${d} /><path class="outline ${side}" d=${d} />`;
}
