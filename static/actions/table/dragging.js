// Keys pressed while something is dragged: they do nothing by themselves.

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const DRAGGING = {
  fine: { label: 'Fine, one tenth', keys: ['Shift'], heard: 'drag' },
  snapAngle: { label: '5° steps', keys: ['Ctrl'], row: '5° or 1 cm steps', heard: 'drag' },
  snapLength: { label: '1 cm steps', keys: ['Ctrl'], row: '5° or 1 cm steps', heard: 'drag' },
  depth: { label: 'Nearer or farther', keys: ['D'], heard: 'drag' },
  carry: { label: 'Take the rest along', keys: ['Alt'], heard: 'drag' },
  free: { label: 'Ignore joint limits', keys: ['U'], heard: 'drag' },
  oneAxis: { label: 'One axis', keys: ['X', 'Y', 'Z'], heard: 'drag' },
  cancelDrag: { label: 'Cancel', keys: ['Escape'], heard: 'drag' },
};
