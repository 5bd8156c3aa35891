// Bodies that are no person: their parts as an indented tree whose lines show who hangs on whom.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { ancestors, childrenOf } from '../store/parts.js';

/** face(part) → {selected, hovered, over(), out(), act()}, as in figure.js. */
export function tree(body, face) {
  const roots = body.parts.filter((part) => !part.parent);
  return html`<div class="tree" role="tree" aria-label="Parts">
    ${roots.flatMap(branch).map((part) => row(part, face(part)))}
  </div>`;
}

/** A part and all below it, in the order they are drawn. */
function branch(part) {
  return [part, ...childrenOf(part).flatMap(branch)];
}

function row(part, look) {
  return html`<button
    type="button"
    role="treeitem"
    class="${look.selected ? 'sel' : ''} ${look.hovered ? 'hov' : ''}"
    tabindex=${look.first ? 0 : -1}
    aria-selected=${look.selected}
    title=${part.label}
    @pointerenter=${look.over}
    @pointerleave=${look.out}
    @click=${look.act}
  >
    ${rails(part)}<span class="dot" style="background:var(--${part.side})"></span>
    <span class="cut">${part.short}</span>${part.mirror ? html`<small>${part.side}</small>` : nothing}
  </button>`;
}

/** One line per ancestor that has more children below, and the bend to the part itself. */
function rails(part) {
  if (!part.parent) return nothing;
  const line = [...ancestors(part), part].slice(1);
  return line.map((step, i) => {
    const bend = i === line.length - 1;
    return html`<i class="${bend ? 'bend' : ''} ${isLast(step) ? 'end' : ''}"></i>`;
  });
}

function isLast(part) {
  return childrenOf({ name: part.parent }).at(-1).name === part.name;
}
