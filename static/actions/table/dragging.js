// Keys pressed while something is dragged: they do nothing by themselves.

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const DRAGGING = {
  fine: { label: 'Fine, one tenth', keys: ['Shift'], handledBy: 'drag' },
  snapAngle: { label: '5° steps', keys: ['Ctrl'], row: '5° or 1 cm steps', handledBy: 'drag' },
  snapLength: { label: '1 cm steps', keys: ['Ctrl'], row: '5° or 1 cm steps', handledBy: 'drag' },
  depth: { label: 'Nearer or farther', keys: ['D'], handledBy: 'drag' },
  carry: { label: 'Take the rest along', keys: ['Alt'], handledBy: 'drag' },
  free: { label: 'Ignore joint limits', keys: ['U'], handledBy: 'drag' },
  oneAxis: { label: 'One axis', keys: ['X', 'Y', 'Z'], handledBy: 'drag' },
  cancelDrag: { label: 'Cancel', keys: ['Escape'], handledBy: 'drag' },
};
