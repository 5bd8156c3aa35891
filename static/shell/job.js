// The job in the top bar: what runs, how far it is, Cancel; after its end a short message.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { keyOf, perform, whyNot } from '../actions/actions.js';
import { icon } from '../controls/icons.js';
import { progressBar } from '../controls/progress_bar.js';
import { toast } from '../controls/toasts.js';
import { server, ui, setUi } from '../store/state.js';

const STAYS_MS = 8000;
const ENDED = { done: 'good', cancelled: 'old', failed: 'lost' };
/** @type {Record<string, string>} */
const TOASTS = { good: 'good', check: 'check', lost: 'lost' };
const ICONS = { good: 'check', check: 'warn', lost: 'lost', old: 'old' };

let timer = 0;
let wasRunning = false;
/** @type {object | null} */
let said = null;

/** The job's place in the top bar, which is as wide without one: nothing beside it moves. */
export function jobState() {
  return html`<div class="jobs">${shown()}</div>`;
}

function shown() {
  if (server.job?.state === 'running') return runningJob(server.job);
  return ui.ended ? endedJob(ui.ended) : nothing;
}

/** Stop the running job; returns whether there was one. */
export function cancelJob() {
  if (whyNot('cancel')) return false;
  perform('cancel');
  return true;
}

/** Called after every change of the job. */
export function noticeJob() {
  const { state } = server.job ?? {};
  if (state === 'running') {
    wasRunning = true;
    setUi('ended', null);
    return;
  }
  // An end that lies before this page was opened is no news.
  if (!wasRunning) return;
  wasRunning = false;
  if (state in ENDED) announce(server.job);
}

/** A finished job has the colour of its worst segment. */
function announce(job) {
  const kind = job.state === 'done' ? (job.worst ?? ENDED.done) : ENDED[job.state];
  setUi('ended', { ...job, kind });
  clearTimeout(timer);
  timer = setTimeout(() => setUi('ended', null), STAYS_MS);
}

/** Called after every drawing: what a finished job says and has no room in the bar is said in a message. */
export function sayWhatIsCut() {
  const words = document.querySelector('#top .job.end .mut');
  if (!words || said === ui.ended || words.scrollWidth <= words.clientWidth) return;
  said = ui.ended;
  toast({ kind: TOASTS[ui.ended.kind] ?? 'info', words: ui.ended.title, detail: ui.ended.words });
}

function runningJob(job) {
  const isFit = ['fit', 'space', 'drafts'].includes(job.kind); // which do not know how far they are
  const percent = Math.round(job.percent ?? 0);
  const left = timeLeft(job.seconds_left);
  const now = job.words ?? '';
  return html`<div class="job">
    <span class="spin">${icon('run')}</span><b class="num cut">${job.title}</b>
    <span class="mut num cut"
      >${now}${left ? `${now ? ' · ' : ''}${left}` : nothing}</span
    >
    <button class="btn ghost sm" title="Cancel" data-key=${keyOf('cancel')} @click=${cancelJob}>Cancel</button>
    ${progressBar(job.title, isFit ? null : percent, `${now} ${left}`)}
  </div>`;
}

/**
 * The foot of a dialog while the server works for it: what it does, how far it is, Cancel.
 * @param {{ label: string, title: string, words: string, done: number, of: number, cancel: () => void }} work
 */
export function workUnderWay({ label, title, words, done, of, cancel }) {
  const percent = of ? Math.round((100 * done) / of) : null;
  return html`<div class="row sheetfoot">
    <div class="job exjob">
      <span class="spin">${icon('run')}</span><b>${title}</b><span class="mut num cut">${words}</span><span class="sp"></span>
      <button type="button" class="btn ghost sm" @click=${cancel}>Cancel</button>
      ${progressBar(label, percent, words)}
    </div>
  </div>`;
}

function endedJob({ kind, title, words }) {
  return html`<div class="job end ${kind}" role="status">
    ${icon(ICONS[kind])}<b class="num cut" title=${title}>${title}</b>
    ${words ? html`<span class="mut num cut" title=${words}>${words}</span>` : nothing}
  </div>`;
}

function timeLeft(seconds) {
  if (seconds === null || seconds === undefined) return '';
  const whole = Math.max(1, Math.ceil(seconds));
  return whole < 90 ? `${whole} s left` : `${Math.ceil(whole / 60)} min left`;
}
