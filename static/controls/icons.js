// The page's icons, drawn on a 16 px grid with strokes; class f is filled.

import { html, svg } from '../vendor/lit-html/lit-html.js';

/** On a 16 px grid; it also stands on the pictures and the timeline. */
export const ANCHOR = svg`<circle cx="8" cy="3.700"
  r="1.700"/><path d="M8 5.400v8.400M5.300 7.600h5.400M2.900 9.300c.2 2.900 2.300 4.500 5.100 4.500s4.900-1.600 5.100-4.500"/>`;

const SHAPES = {
  undo: svg`<path d="M3 6h6.5a3.5 3.5 0 0 1 0 7H6M3 6l3-3M3 6l3 3"/>`,
  redo: svg`<path d="M13 6H6.5a3.5 3.5 0 0 0 0 7H10M13 6l-3-3M13 6l-3 3"/>`,
  check: svg`<path d="M3 8.5l3.2 3.2L13 5"/>`,
  warn: svg`<path d="M8 2.5 14.3 13H1.7zM8 6.5v3"/><circle class="f" cx="8" cy="11.3" r=".9"/>`,
  lost: svg`<circle cx="8" cy="8" r="5.8"/><path d="M5.8 5.8l4.4 4.4M10.2 5.8l-4.4 4.4"/>`,
  old: svg`<circle cx="8" cy="8" r="5.8" stroke-dasharray="2.6 2"/><path d="M8 5v3.2l2 1.3"/>`,
  run: svg`<path d="M8 2.2A5.8 5.8 0 1 1 2.2 8"/>`,
  x: svg`<path d="M4 4l8 8M12 4l-8 8"/>`,
  chev: svg`<path d="M4.5 6.5 8 10l3.5-3.5"/>`,
  chr: svg`<path d="M6.5 4.5 10 8l-3.5 3.5"/>`,
  track: svg`<path d="M2 12c3-.4 3.2-7.5 6-7.5S11 9 14 8"/><path class="f"
    d="M2 9.6 4.4 12 2 14.4-.4 12zM14 5.6 16.4 8 14 10.4 11.6 8z" transform="translate(.2 -.2) scale(.97)"/>`,
  exp: svg`<path d="M8 9.5V2.5M5 5l3-3 3 3M3 9v4.5h10V9"/>`,
  help: svg`<circle cx="8" cy="8" r="6"/><path d="M6.2 6.3a1.9 1.9 0 1 1 2.6 1.8c-.6.3-.8.6-.8 1.2"/><circle class="f"
    cx="8" cy="11.4" r=".9"/>`,
  sun: svg`<circle cx="8" cy="8"
    r="2.8"/><path d="M8 1.5v1.6M8 12.9v1.6M1.5 8h1.6M12.9 8h1.6M3.4 3.4l1.1 1.1M11.5 11.5l1.1 1.1M3.4 12.6l1.1-1.1M11.5 4.5l1.1-1.1"/>`,
  tabs: svg`<rect x="2" y="5" width="9" height="8.5"
    rx="1.2"/><path d="M5 5V3.2A1 1 0 0 1 6 2.2h7a1 1 0 0 1 1 1V10a1 1 0 0 1-1 1h-2"/>`,
  sel: svg`<path d="M3.5 2.5 12.5 8 8.4 8.9 6.6 13z"/>`,
  rot: svg`<path d="M12.8 5.5A5.6 5.6 0 1 0 13.6 8"/><path d="M13.4 2.6v3.2h-3.2"/><circle class="f" cx="8" cy="8"
    r="1.3"/>`,
  move: svg`<path d="M8 1.8v12.4M1.8 8h12.4M6.2 3.6 8 1.8l1.8 1.8M6.2 12.4 8 14.2l1.8-1.8M3.6 6.2 1.8 8l1.8 1.8M12.4 6.2 14.2 8l-1.8 1.8"/>`,
  ik: svg`<path d="M3.6 12.2 6 6.4M7.4 5.6l4 2.6"/><circle cx="3.2" cy="13" r="1.4"/><circle cx="6.5" cy="5"
    r="1.4"/><path d="M11 6.6l3.6 2.3-1.7.4-.8 1.6z" class="f"/>`,
  size: svg`<path d="M5.5 1.8h5v12.4h-5zM5.5 5H8M5.5 8h1.8M5.5 11H8"/>`,
  hand: svg`<path d="M5 8V4.2a1 1 0 0 1 2 0V7 3a1 1 0 0 1 2 0v4-3.2a1 1 0 0 1 2 0V8 5.8a1 1 0 0 1 2 0V10c0 2.6-1.6 4.2-4 4.2S5.8 13 4.6 11L3 8.6a1 1 0 0 1 1.7-1z" transform="scale(.96) translate(.2 .2)"/>`,
  wire: svg`<path d="M3 4.5h10M3 11.5h10M5 2.5v11M11 2.5v11"/>`,
  solid: svg`<path class="f" d="M4 3.2h8v9.6H4z"/>`,
  both: svg`<path class="f" style="opacity:.4" d="M4 3.2h8v9.6H4z"/><path d="M4 3.2h8v9.6H4zM8 3.2v9.6"/>`,
  rings: svg`<circle cx="8" cy="8" r="5.5"
    style="opacity:.35"/><path d="M8 2.5a5.5 5.5 0 1 1-5.5 5.5"/><circle class="f" cx="8" cy="8" r="1.2"/>`,
  person: svg`<circle class="f" cx="8" cy="3.800" r="2.100"/><path class="f"
    d="M4.200 14V9.300a2.600 2.600 0 0 1 2.600-2.600h2.400a2.600 2.600 0 0 1 2.600 2.600V14z"/>`,
  camc: svg`<rect x="1.8" y="4.5" width="8.4" height="7" rx="1.2"/><path d="M10.200 7.200 14.200 5v6l-4-2.200"/>`,
  floor: svg`<path d="M4.500 4.500h7L15 12H1zM8 4.500V12M2.700 8.200h10.600"/>`,
  ghost: svg`<circle cx="6" cy="8" r="4" stroke-dasharray="2 1.8"/><circle cx="10" cy="8" r="4"/>`,
  trail: svg`<path d="M2 12.5C4 12 4.5 5 8 5s3.5 5 6-1"/><circle class="f" cx="2.6" cy="12.2" r="1.2"/><circle class="f"
    cx="8" cy="5" r="1.2"/><circle class="f" cx="13.6" cy="4.4" r="1.2"/>`,
  key: svg`<path class="f" d="M8 2.5 13.5 8 8 13.5 2.5 8z"/>`,
  part: svg`<path d="M8 2.500 13.500 8 8 13.500 2.500 8z"/><path class="f" d="M2.500 8h11L8 13.500z"/>`,
  keyadd: svg`<path d="M7 2.5 12.5 8 7 13.5 1.5 8z"/><path d="M13 2v4M11 4h4"/>`,
  first: svg`<path class="f" d="M12.5 3.5v9L6 8z"/><path d="M4 3.5v9"/>`,
  last: svg`<path class="f" d="M3.5 3.5v9L10 8z"/><path d="M12 3.5v9"/>`,
  pk: svg`<path class="f" d="M7 4.5 3.5 8 7 11.5z"/><path d="M11 4.6 14.4 8 11 11.4 7.6 8z"/>`,
  nk: svg`<path class="f" d="M9 4.5 12.5 8 9 11.5z"/><path d="M5 4.6 8.4 8 5 11.4 1.6 8z"/>`,
  sb: svg`<path d="M9.5 4 5.5 8l4 4"/>`,
  sf: svg`<path d="M6.5 4l4 4-4 4"/>`,
  ahead: svg`<path class="f"
    d="M4 5.200 6.800 8 4 10.800 1.200 8z"/><path d="M8.200 8h5.800M11.200 5.200 14 8l-2.800 2.800"/>`,
  back: svg`<path class="f"
    d="M12 5.200 14.800 8 12 10.800 9.200 8z"/><path d="M7.800 8H2M4.800 5.200 2 8l2.800 2.800"/>`,
  play: svg`<path class="f" d="M4.5 2.8v10.4L13 8z"/>`,
  repeat: svg`<path d="M4.500 5.500h6.500a2.500 2.500 0 0 1 0 6H5a2.500 2.500 0 0 1-2.400-3.200M6.500 3.300 4.300 5.500l2.200 2.200"/>`,
  in: svg`<path d="M7 3H4.500v10H7M14 8H8M10.500 5.500 8 8l2.500 2.500"/>`,
  out: svg`<path d="M9 3h2.500v10H9M2 8h6M5.500 5.500 8 8l-2.500 2.500"/>`,
  loop: svg`<path d="M3 8a4 4 0 0 1 4-4h5M10 2l2 2-2 2M13 8a4 4 0 0 1-4 4H4M6 14l-2-2 2-2"/>`,
  lock: svg`<rect x="3.5" y="7" width="9" height="6.5" rx="1.2"/><path d="M5.5 7V5a2.5 2.5 0 0 1 5 0v2"/>`,
  unlock: svg`<rect x="3.5" y="7" width="9" height="6.5" rx="1.2"/><path d="M5.5 7V4.6a2.5 2.5 0 0 1 4.8-1"/>`,
  mirror: svg`<path d="M8 2v12" stroke-dasharray="2 1.6"/><path d="M5.5 5v6L1.8 11zM10.5 5v6l3.7 0z"/>`,
  copy: svg`<rect x="5.5" y="5.5" width="8" height="8" rx="1.2"/><path d="M3.5 10.5h-1v-8h8v1"/>`,
  paste: svg`<path d="M5.5 3.5h-2v10h9v-10h-2"/><rect x="5.5" y="2" width="5" height="3" rx=".8"/>`,
  reset: svg`<path d="M3 8a5 5 0 1 0 1.6-3.7M3 2.8V5.2h2.5"/>`,
  prev: svg`<path d="M6 3.5 1.5 8 6 12.5"/><path class="f" d="M11 5 14 8l-3 3-3-3z"/>`,
  take: svg`<path d="M2 11c2.5 0 2.5-6 5-6"/><path class="f" d="M11 5 14 8l-3 3-3-3z"/>`,
  grow: svg`<path d="M9.5 2.5h4v4M13.5 2.5 9 7M6.5 13.5h-4v-4M2.5 13.5 7 9"/>`,
  more: svg`<circle class="f" cx="3.5" cy="8" r="1.2"/><circle class="f" cx="8" cy="8" r="1.2"/><circle class="f"
    cx="12.5" cy="8" r="1.2"/>`,
  film: svg`<rect x="2" y="3" width="12" height="10" rx="1.2"/><path d="M5 3v10M11 3v10M2 8h3M11 8h3"/>`,
  img: svg`<rect x="2" y="3" width="12" height="10" rx="1.2"/><circle cx="5.6" cy="6.4"
    r="1.1"/><path d="M2.5 12 7 8l2.5 2 2-1.6 2.5 2.2"/>`,
  up: svg`<path d="M8 10.5V3M4.8 6 8 2.8 11.2 6M2.5 10.5v3h11v-3"/>`,
  folder: svg`<path d="M2 12.5v-9h4l1.5 1.8H14v7.2z"/>`,
  bone: svg`<circle cx="4" cy="12" r="2"/><circle cx="12" cy="4" r="2"/><path d="M5.4 10.6l5.2-5.2"/>`,
  depth: svg`<path d="M8 14V3M8 3 5.5 5.5M8 3l2.5 2.5M3 14h10"/>`,
  flag: svg`<path d="M4 14V2.5h8.5L10.5 6l2 3.5H4"/>`,
  mid: svg`<path d="M2.5 4v8M13.5 4v8M5 8h6M5 8l1.5-1.5M5 8l1.5 1.5M11 8 9.5 6.5M11 8 9.5 9.5"/>`,
  quad: svg`<rect x="2.5" y="2.5" width="11" height="11" rx="1"/><path d="M8 2.5v11M2.5 8h11"/>`,
  clip: svg`<rect x="3.5" y="3" width="9" height="11" rx="1.2"/><path d="M6 3V2h4v1"/>`,
  link: svg`<path d="M6.8 9.2a2.4 2.4 0 0 0 3.4 0l2.3-2.3a2.4 2.4 0 0 0-3.4-3.4l-.9.9"/>
    <path d="M9.2 6.8a2.4 2.4 0 0 0-3.4 0L3.5 9.1a2.4 2.4 0 0 0 3.4 3.4l.9-.9"/>`,
  minus: svg`<path d="M4 8h8"/>`,
  plus: svg`<path d="M4 8h8M8 4v8"/>`,
  pause: svg`<path class="f" d="M4.5 3h2.500v10H4.500zM9 3h2.500v10H9z"/>`,
  moon: svg`<path d="M13 9.500A5.500 5.500 0 1 1 6.500 3a4.500 4.500 0 0 0 6.500 6.500z"/>`,
  wand: svg`<path d="M2.5 13.5 9 7M10.5 5.5l.8-.8"/>
    <path d="M11.5 8.5v2.6M10.2 9.8h2.6M6.5 2v2.6M5.2 3.3h2.6M13 2.2v2M12 3.2h2"/>`,
  crop: svg`<path d="M2.5 5.500v-3h3M10.500 2.500h3v3M13.500 10.500v3h-3M5.500 13.500h-3v-3"/><circle cx="8" cy="6.600"
    r="1.400"/><path d="M5.600 11.200c.3-1.700 1.200-2.500 2.400-2.500s2.100.8 2.400 2.500"/>`,
  anchor: svg`${ANCHOR}`,
  down: svg`<path d="M8 2v8.500M5 7.500l3 3 3-3M3 13.500h10"/>`,
  phone: svg`<rect x="4.200" y="1.800" width="7.600" height="12.400" rx="1.600"/><circle cx="6.600" cy="4.400"
    r="1.100"/>`,
  camcorder: svg`<rect x="1.800" y="4.500" width="8.700" height="7"
    rx="1.200"/><path d="M10.500 7.200 14.200 5v6l-3.700-2.200"/>`,
  action: svg`<rect x="2" y="4" width="12" height="8.500" rx="1.600"/><circle cx="10" cy="8.300" r="2.300"/>`,
  find: svg`<circle cx="7" cy="7" r="4.500"/><path d="M10.400 10.400 14 14"/>`,
  note: svg`<path d="M2.500 2.500h11v8h-6l-3 3v-3h-2zM5 5.300h6M5 7.800h4"/>`,
  pen: svg`<path d="M10.500 3 13 5.500 5.500 13l-3 .5.5-3zM9 4.500 11.500 7"/>`,
  trash: svg`<path d="M3 4.500h10M6.500 4.500V3h3v1.500M4.500 4.500l.6 8.500h5.800l.6-8.500"/>`,
};

/** An icon by name; `style` for the rare one that differs. */
export function icon(name, style = '') {
  return html`<svg class="i" viewBox="0 0 16 16" aria-hidden="true" style=${style}>${SHAPES[name]}</svg>`;
}

export const LOGO = html`<svg width="20" height="20" viewBox="0 0 20 20" fill="none" aria-hidden="true">
  <path d="M3 15.5C6.5 15 7 5 10 5s3.5 7 7 6" stroke="var(--acc)" stroke-width="1.8" stroke-linecap="round" />
  <path d="M3 12.6 5.9 15.5 3 18.4.1 15.5z" fill="var(--t1)" />
  <path d="M10 2.1 12.9 5 10 7.9 7.1 5z" fill="var(--t1)" />
  <path d="M17 8.1 19.9 11 17 13.9 14.1 11z" fill="var(--t1)" />
</svg>`;
