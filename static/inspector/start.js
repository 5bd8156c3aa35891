// Where a segment starts from before the passes go over it, and what templates need not follow.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { checkbox, dropdown } from '../controls/fields.js';
import { line } from './section.js';

const STARTS = [
  { id: 'auto', label: 'Auto', note: 'the best of these' },
  { id: 'linear', label: 'Linear', note: 'plain interpolation' },
  { id: 'templates', label: 'Templates', note: 'matches hands, feet and head' },
  { id: 'both-ways', label: 'Both ways', note: 'tracks from both keyframes' },
  { id: 'import', label: 'Imported', note: 'a motion you imported' },
];

export function start() {
  const { initial } = server.settings;
  const pick = dropdown({
    label: 'Initial guess', value: initial, options: STARTS.map(within),
    title: 'The motion that each segment is refined from',
    act: (id) => send({ do: 'settings', initial: id }),
  });
  return html`${line('Initial guess', pick)}${usesTemplates(initial) ? followLine() : nothing}`;
}

/** Auto looks for templates with the default method at full quality alone. */
const usesTemplates = (initial) => initial === 'templates'
  || (initial === 'auto' && server.settings.method === 'keypose' && server.settings.quality === 'full');

/** An imported motion can be chosen only where there is one. */
function within(option) {
  if (option.id !== 'import') return option;
  const { imported } = server.settings;
  if (imported) return { ...option, note: imported };
  return { ...option, off: 'Import a motion first: drop its file here', note: 'none imported' };
}

const plural = (word) => (word === 'Foot' ? 'Feet' : `${word}s`);

/** The ends of the limbs, by name without their side: what templates follow. */
function ends() {
  const parents = new Set(server.body.parts.map((part) => part.parent));
  const found = new Map();
  for (const part of server.body.parts.filter((one) => one.parent && !parents.has(one.name))) {
    const label = part.mirror ? plural(part.short) : part.label;
    found.set(label, [...(found.get(label) ?? []), part.name]);
  }
  return [...found];
}

function followLine() {
  const all = ends();
  if (all.length === 0) return nothing;
  return line('Follow', html`<div class="follow" role="group" aria-label="Followed by templates">
    ${all.map(([label, names]) => followBox(label, names))}
  </div>`);
}

function followBox(label, names) {
  const out = server.settings.left_out;
  const on = !names.some((name) => out.includes(name));
  const rest = out.filter((name) => !names.includes(name));
  return checkbox({
    label, on,
    title: on ? `${label}: followed. Click to leave out` : `${label}: left out. Click to follow`,
    act: (wanted) => send({ do: 'settings', left_out: wanted ? rest : [...rest, ...names] }),
  });
}
