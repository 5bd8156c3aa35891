// The inspector: the part picker on top, four tabs of numbers below.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { placesToConfirm } from '../actions/playhead.js';
import { icon } from '../controls/icons.js';
import { server, ui, setUi, watch } from '../store/state.js';
import { isSurface } from '../store/clip.js';
import { bodyChips } from './bodies.js';
import { bodyTab, freedom } from './body_tab.js';
import { cameraMotion } from './camera_motion.js';
import { cues, keypoints, masks } from './cues.js';
import { draft } from './draft.js';
import { distortion, film, lens, upright, virtualCamera } from './lens.js';
import { method } from './method.js';
import { partTab } from './part_tab.js';
import { picker } from './picker.js';
import { reviewPanel, revealRow } from './review.js';
import { segment } from './segment.js';
import { space } from './space.js';
import { surfaces } from './surfaces.js';

const TABS = {
  part: { label: 'Part', title: 'The selected part: pose and sizes', draw: partTab },
  body: { label: 'Body', title: 'The whole body: preset, height, all sizes', draw: bodyTab },
  camera: { label: 'Camera', title: 'Lens, motion, up direction, ignored regions, recording rate', draw: cameraTab },
  track: { label: 'Track', title: 'Tracking settings and results', draw: trackTab },
};

/** The same tabs where there are surfaces instead of a film. */
const OTHERWISE = {
  camera: { ...TABS.camera, title: 'The camera that the image is rendered from', draw: virtualTab },
  track: { ...TABS.track, label: 'Fit', title: 'Fit settings and results', draw: fitTab },
};

/** @type {import('../store/shapes.js').Watched[]} */
const SHOWN = [
  'file',
  'surface',
  'camera',
  'body',
  'bodies',
  'view',
  'pose',
  'keys',
  'segments',
  'errors',
  'space',
  'draft',
  'people',
  'job',
  'lanes',
  'masks',
  'settings',
  'cues',
  'networks',
  'keypoints',
  'clipboard',
  'poses',
  'u:timeKeys',
  'pins',
  'bonds',
  'proposed_pins',
  'floor',
  'camera_motion',
  'background',
  'u:tab',
  'u:tool',
  'u:hover',
  'u:figureHover',
  'u:freeAxes',
  'u:lens',
  'u:mask',
  'u:box',
  'u:rings',
  'u:allKeypoints',
  'u:draftRange',
  'u:span',
  'u:segmentFirst',
  'u:allFreedoms',
  'u:fitFocal',
  'sizes_preview',
  'u:allSizes',
  'review',
  'u:review',
  'u:placeSeen',
  'u:reviewGoal',
  'u:reviewHeld',
  'u:reviewDone',
  'u:allInSpace',
  'u:bodyNaming',
];

/** What was selected when it was last brought into sight. */
let shownSelected = null;

export function mount() {
  const inspector = document.getElementById('insp');
  const room = document.createElement('div');
  room.className = 'insp-room stack';
  inspector.append(room);
  addDrawer(inspector);
  room.addEventListener('mousedown', keepKeysWithTheFrame);
  watch(SHOWN, () => draw(room));
}

function draw(room) {
  render(server.file && server.body && server.view ? contents() : nothing, room);
  revealRow(room);
  if (server.view?.selected === shownSelected) return;
  shownSelected = server.view?.selected;
  // With the keyboard in the figure the focus goes along.
  if (document.activeElement?.closest('.fig')) room.querySelector('.fig [tabindex="0"]')?.focus();
  const rows = room.querySelectorAll('.tree .sel, .size.sel, .free.sel');
  for (const row of rows) row.scrollIntoView({ block: 'nearest' });
}

function contents() {
  if (ui.review) return reviewPanel();
  const tab = TABS[ui.tab] ? ui.tab : 'part';
  return html`${bodyChips()}${picker()}
    <div class="tabs" role="tablist" aria-label="Inspector" @keydown=${turn}>
      ${Object.keys(TABS).map((id) => head(id, tab))}
    </div>
    <div class="body" role="tabpanel" id="insp-body" aria-label=${tabOf(tab).label}>
      ${tabOf(tab).draw()}
    </div>`;
}

function head(id, current) {
  return html`<button
    type="button"
    role="tab"
    title=${tabOf(id).title}
    aria-selected=${id === current}
    aria-controls="insp-body"
    tabindex=${id === current ? 0 : -1}
    @click=${() => setUi('tab', id)}
  >
    ${tabOf(id).label}
  </button>`;
}

const tabOf = (id) => (isSurface() && OTHERWISE[id]) || TABS[id];

/** Arrow keys walk over the tabs once one of them has been reached with Tab. */
function turn(event) {
  const way = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (way === undefined) return;
  event.preventDefault();
  event.stopPropagation();
  const ids = Object.keys(TABS);
  const next = (ids.indexOf(ui.tab) + way + ids.length) % ids.length;
  setUi('tab', ids[next]);
  event.currentTarget.children[next].focus();
}

function cameraTab() {
  return server.camera ? html`${lens()}${cameraMotion()}${upright()}${masks()}${distortion()}${film()}` : nothing;
}

function virtualTab() {
  return server.camera ? virtualCamera() : nothing;
}

function fitTab() {
  return server.settings ? html`${segment()}${surfaces()}` : nothing;
}

function trackTab() {
  if (!server.settings) return nothing;
  // Where nothing is posed yet, or a draft waits to be confirmed, that is the next thing to do.
  const isNext = !server.keys?.frames.length || placesToConfirm().length > 0;
  return html`${cues()}${keypoints()}${isNext ? draft() : nothing}${segment()}${space()}${method()}${isNext ? nothing : draft()}${freedom()}`;
}

/** A control clicked with the mouse leaves the keys with the views; what was typed is taken over. */
function keepKeysWithTheFrame(event) {
  if (event.target.closest('input, number-field, slide-bar')) return;
  if (!event.target.closest('button, path, [role=option]')) return;
  event.preventDefault();
  if (!event.target.closest('[popover]')) document.activeElement?.blur();
}

/** In a narrow window the inspector is a drawer over the views: put the tag that pulls it out on its left edge;
 * the style sheet shows it where it is needed. */
function addDrawer(inspector) {
  const place = document.createElement('div');
  place.className = 'insp-tag';
  inspector.append(place);
  const drawTag = () => {
    const open = inspector.classList.contains('open');
    const label = open ? 'Close the inspector' : 'Open the inspector';
    const toggle = () => {
      inspector.classList.toggle('open');
      drawTag();
    };
    render(
      html`<button type="button" aria-label=${label} title=${label} aria-expanded=${open} @click=${toggle}>
        ${icon(open ? 'sf' : 'sb')}
      </button>`,
      place,
    );
  };
  drawTag();
}
