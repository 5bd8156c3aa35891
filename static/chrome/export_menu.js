// The Export menu: pictures of this frame, the motion, and what is not to be trusted in it.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from '../icons.js';
import { S } from '../state.js';
import { frame } from '../timeline/head.js';
import { copyPicture, saveMotion, savePicture, viewShown } from './export.js';
import { heading, line, menuHolder, note, toggleMenu } from './menus.js';
import { listed, range } from './words.js';

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
  const off = hasMotion() ? '' : 'Track first: there is no motion yet';
  const keys = S.keys?.frames ?? [];
  const frames = keys.length > 1 ? `, frames ${range(keys[0], keys.at(-1))}` : '';
  return [
    heading(`Picture of frame ${frame()}`),
    { icon: 'img', label: 'This view, PNG', right: sizeAndKey(), run: () => savePicture() },
    { icon: 'quad', label: 'All four views, PNG', run: () => savePicture('all') },
    { icon: 'clip', label: 'Copy this view', right: 'Shift C', run: copyPicture },
    line,
    heading(`Motion${frames}`),
    { icon: 'bone', label: 'BVH', right: 'Blender, Maya', off, run: () => saveMotion('bvh') },
    { icon: 'copy', label: 'CSV', right: 'joints and angles', off, run: () => saveMotion('csv') },
    warning(),
  ];
}

/** Only the camera's picture has a size that is known here: the video's own. */
function sizeAndKey() {
  const { width, height } = S.file ?? {};
  return viewShown() === 'main' && width ? `${width} × ${height} · Shift E` : 'Shift E';
}

const hasMotion = () => (S.segments ?? []).some((s) => TRACKED.includes(s.state));

/** "Segment 75–99 is lost and 50–61 is outdated. The file says so per frame." */
function warning() {
  const parts = ['lost', 'outdated'].flatMap((state) => {
    const names = (S.segments ?? [])
      .filter((s) => s.state === state)
      .map((s) => range(s.first, s.last));
    return names.length ? [{ state, names }] : [];
  });
  if (!parts.length) return null;
  const say = ({ state, names }, first) => {
    const many = names.length > 1;
    const noun = first ? `Segment${many ? 's' : ''} ` : ' and ';
    return html`<span class=${state === 'lost' ? 'lostword' : nothing}
      >${noun}${listed(names)} ${many ? 'are' : 'is'} ${state}</span
    >`;
  };
  return note(html`${parts.map((part, i) => say(part, i === 0))}. The file says so per frame.`);
}
