// Whether the work is safe: "Saved 2 s ago", "Saving…", "Not saved: …", "Read only: …".

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { isNarrow } from './more.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server, ui } from '../store/state.js';
import { shortAgo } from '../controls/words.js';

/** The saved state of the top bar. */
export function savedState() {
  const saved = server.saved;
  if (!saved) return nothing;
  /** @type {Record<string, (saved: import('../store/shapes.js').Saved) => unknown>} */
  const shown = { saved: isSaved, saving: isSaving, failed: hasFailed, readonly: isReadOnly };
  return html`<span class="savedbox" role="status">${shown[saved.state]?.(saved) ?? nothing}</span>`;
}

/** Whether the words change with the clock. */
export const savedTicks = () => server.saved?.state === 'saved' && Boolean(server.saved.at);

function isSaved({ at }) {
  if (!ui.connected) return nothing; // the status bar says that edits wait
  const words = `Saved${at ? ` ${shortAgo(at)}` : ''}`;
  return html`<span class="row saved" title=${words}>${icon('check')}<span class="say">${words}</span></span>`;
}

function isSaving() {
  return html`<span class="row saved saving" title="Saving…">${icon('run')}<span class="say">Saving…</span></span>`;
}

function hasFailed({ words }) {
  const text = words ? `Not saved: ${words}` : 'Not saved';
  // Where the bar has no room for it a banner says it.
  if (isNarrow()) return html`<span class="row saved failed" title=${text}>${icon('lost')}</span>`;
  return html`<span class="chip lost notsaved" title=${text}>
    ${icon('lost')}<button class="btn sm" @click=${() => send({ do: 'save_again' })}>Try again</button>
    <span class="cut">${text}</span>
  </span>`;
}

function isReadOnly({ words }) {
  const text = words || 'Read only';
  return html`<span class="row saved readonly" title=${text}>
    ${icon('lock')}<span class="cut say">${text}</span>
  </span>`;
}
