// Keys pressed while something is dragged: they do nothing by themselves.

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const DRAGGING = {
  fine: { also: 'slow precise precision', label: 'Fine, one tenth', keys: ['Shift'], handledBy: 'drag' },
  snapAngle: { also: 'snap step degrees increments', label: '5° steps', keys: ['Ctrl'], row: '5° or 1 cm steps', handledBy: 'drag' },
  snapLength: { also: 'snap step grid increments', label: '1 cm steps', keys: ['Ctrl'], row: '5° or 1 cm steps', handledBy: 'drag' },
  depth: { also: 'distance z push pull', label: 'Nearer or farther', keys: ['D'], handledBy: 'drag' },
  carry: { also: 'unlock release ends follow', label: 'Take the rest along', keys: ['Alt'], handledBy: 'drag' },
  free: { also: 'unlock limits joint range', label: 'Ignore joint limits', keys: ['U'], handledBy: 'drag' },
  oneAxis: { also: 'constrain lock axis xyz', label: 'One axis', keys: ['X', 'Y', 'Z'], handledBy: 'drag' },
  cancelDrag: { alone: 'Cancel the drag', label: 'Cancel', keys: ['Escape'], handledBy: 'drag' },
};
