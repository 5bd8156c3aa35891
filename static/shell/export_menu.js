// The Export menu: pictures of this frame, the motion, and what is not to be trusted in it.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { server } from '../store/state.js';
import { words } from '../store/subject.js';
import { frame } from '../timeline/edit/head.js';
import { copyPicture, saveMotion, savePicture, saveReport, viewShown } from './export.js';
import { heading, line, menuHolder, note, toggleMenu } from '../controls/menu.js';
import { listed, range } from '../controls/words.js';

const MOTIONS = [
  { format: 'bvh', icon: 'bone', right: 'Blender, Maya' },
  { format: 'glb', icon: 'both', right: 'any 3D viewer' },
  { format: 'trc', icon: 'trail', right: 'OpenSim' },
  { format: 'c3d', icon: 'ghost', right: 'motion laboratories' },
  { format: 'csv', icon: 'copy', right: 'joints, angles, verdicts' },
  { format: 'npz', icon: 'quad', right: 'NumPy' },
];
const TRACKED = ['good', 'check', 'lost', 'outdated', 'tracking'];

export function exportButton() {
  const button = (open) => html`<button
    class="btn ghost ${open ? 'hov' : ''}"
    aria-haspopup="menu"
    aria-expanded=${open}
    title="Pictures and motion as files"
    @click=${() => toggleMenu('export')}
  >
    ${icon('exp')}Export${icon('chev')}
  </button>`;
  return menuHolder('export', button, items, 'right export');
}

function items() {
  const off = hasMotion() ? '' : `${words().verb} first: there is no motion yet`;
  const keys = server.keys?.frames ?? [];
  const all = server.segments ?? [];
  const frames = all.length ? `, frames ${range(all[0].first, all.at(-1).last)}` : '';
  return [
    heading(`Picture of frame ${frame()}`),
    { icon: 'img', label: 'This view, PNG', right: sizeAndKey(), run: () => savePicture() },
    { icon: 'quad', label: 'All four views, PNG', run: () => savePicture('all') },
    { icon: 'clip', label: 'Copy this view', right: 'Shift C', run: copyPicture },
    line,
    heading(`Motion${frames}`),
    ...MOTIONS.map(({ format, ...looks }) => ({
      ...looks,
      label: format.toUpperCase(),
      off,
      run: () => saveMotion(format),
    })),
    warning(),
    line,
    {
      icon: 'film', label: 'Report, HTML', right: 'verdicts, charts, pictures',
      off: keys.length ? '' : 'Pose a keyframe first', run: saveReport,
    },
  ];
}

/** Only the camera's picture has a size that is known here: the video's own. */
function sizeAndKey() {
  const { width, height } = server.file ?? {};
  return viewShown() === 'main' && width ? `${width} × ${height} · Shift E` : 'Shift E';
}

const hasMotion = () => (server.segments ?? []).some((s) => TRACKED.includes(s.state));

/** The frames of segments in a state, neighbours as one: [[50, 61], [75, 99]]. */
function spans(state) {
  const found = [];
  for (const { first, last } of (server.segments ?? []).filter((s) => s.state === state)) {
    if (found.at(-1)?.[1] === first) found.at(-1)[1] = last;
    else found.push([first, last]);
  }
  return found;
}

/** What BVH and GLB, which hold no gaps, make of segments that are not tracked. */
function withoutGaps() {
  const tracked = (server.segments ?? []).filter((s) => ['good', 'check', 'lost'].includes(s.state));
  if (!tracked.length || tracked.length === server.segments.length) return nothing;
  const gap = tracked.some((s, i) => i && tracked[i - 1].last !== s.first);
  const held = range(tracked[0].first, tracked.at(-1).last);
  return gap ? ' BVH and GLB need all of them.' : ` BVH and GLB hold ${held} alone.`;
}

/** "Frames 75–99 are lost and 50–61 are outdated. CSV and NPZ say so per frame." */
function warning() {
  const parts = ['lost', 'outdated', 'none'].flatMap((state) => {
    const names = spans(state).map(([first, last]) => range(first, last));
    return names.length ? [{ state, names }] : [];
  });
  if (!parts.length || !hasMotion()) return null;
  const say = ({ state, names }, first) => {
    const noun = first ? 'Frames ' : ' and ';
    return html`<span class=${state === 'lost' ? 'lostword' : nothing}
      >${noun}${listed(names)} are ${state === 'none' ? `not ${words().done}` : state}</span
    >`;
  };
  const told = parts.map((part, i) => say(part, i === 0));
  return note(html`${told}. CSV and NPZ say so per frame.${withoutGaps()}`);
}
