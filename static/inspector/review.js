// The review in the inspector's place: the goal, how far one is, a row for every place.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { keyOf, labelOf, perform, titleOf, whyNot } from '../actions/actions.js';
import { closeReview, goal, lowerGoal, setGoal, visit } from '../actions/review.js';
import { doneWords, openRows, orderWords } from '../actions/review_list.js';
import { dropdown } from '../controls/dropdown.js';
import { icon } from '../controls/icons.js';
import { toggleMenu } from '../controls/menu.js';
import { count, roughError } from '../controls/words.js';
import { fetchOwn } from '../store/storage.js';
import { server, setUi, ui } from '../store/state.js';
import { words } from '../store/clip.js';

const SIDE = 104; // device pixels, for 52 of the page

/** Of a thousand rows those have pictures that are seen. @type {IntersectionObserver | null} */
let seen = null;

class FrameCrop extends HTMLElement {
  shown = '';
  isSeen = false;
  /** @type {{ frame: number, at: [number, number], crop: number } | null}  Pixels of the video. */
  wanted = null;

  connectedCallback() {
    seen ??= new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) /** @type {FrameCrop} */ (target).see(isIntersecting);
    });
    seen.observe(this);
  }

  disconnectedCallback() {
    seen?.unobserve(this);
  }

  set spec(spec) {
    this.wanted = spec;
    this.see(this.isSeen);
  }

  see(isSeen) {
    this.isSeen = isSeen;
    if (isSeen && this.wanted) this.show(this.wanted);
  }

  show({ frame, at, crop }) {
    const version = server.camera?.image_version ?? '';
    const now = `${server.file?.path}|${version}|${frame}|${at}|${crop}`;
    if (now === this.shown) return;
    this.shown = now;
    this.load(now, `/frame/${frame}.jpg?v=${encodeURIComponent(version)}`, at, crop);
  }

  async load(asked, url, [x, y], crop) {
    const answer = await fetchOwn(url).catch(() => null);
    if (asked !== this.shown) return;
    if (!answer?.ok) {
      this.shown = ''; // asked for again when the list is drawn next
      return;
    }
    const picture = await createImageBitmap(await answer.blob());
    if (asked === this.shown) this.draw(picture, x, y, crop);
    picture.close();
  }

  draw(picture, x, y, crop) {
    // A frame may come smaller than the video is.
    const scale = picture.width / (server.camera?.width ?? picture.width);
    const canvas = Object.assign(document.createElement('canvas'), { width: SIDE, height: SIDE });
    const [left, top] = [x + 0.5 - crop / 2, y + 0.5 - crop / 2].map((at) => at * scale);
    canvas.getContext('2d')?.drawImage(picture, left, top, crop * scale, crop * scale, 0, 0, SIDE, SIDE);
    this.replaceChildren(canvas);
  }
}

customElements.define('frame-crop', FrameCrop);

/** @typedef {import('../store/shapes.js').ReviewPlace} ReviewPlace */

const SAID = { accepted: 'Accepted', corrected: 'Corrected', unclear: 'Left open' };

export function reviewPanel() {
  const list = ui.review;
  const open = openRows(list);
  const answers = new Map(list.done.map(({ id, answer }) => [id, answer]));
  return html`<section class="review" aria-label="Review">
    ${head(list, open.length)}
    <div class="rv-rows" role="list"
      @pointerleave=${() => setUi('reviewHeld', null)}>${list.rows.map((row) =>
        drawRow(list, row, answers.get(row.id)),
      )}</div>
    ${open.length ? nothing : reviewFinishedCard(list)}
    ${list.done.length ? doneRow(list) : nothing}
    ${untracked()}
  </section>`;
}

function head(list, left) {
  const all = list.done.length + left;
  const share = all ? (100 * list.done.length) / all : 100;
  return html`<header>
    <div class="row"><h2>Review${
      left ? html` · <span class="num">${left} left</span>` : nothing
    }</h2><span class="sp"></span>
      <button type="button" class="btn ghost sm" title="Close the review"
        @click=${closeReview}>Close<kbd>Esc</kbd></button></div>
    ${all ? progress(list.done.length, all, share) : nothing}
    <div class="row rv-goal"><span class="dim">Goal</span>${dropdown(goals())}<span class="sp"></span>
      ${left ? html`<span class="dim">${orderWords(list.rows)}</span>` : nothing}</div>
  </header>`;
}

function progress(done, all, share) {
  return html`<div class="row"><span class="rv-track" role="progressbar" aria-label="Reviewed"
    aria-valuemin="0" aria-valuemax=${all} aria-valuenow=${done}><i style="width:${share.toFixed(1)}%"></i></span>
    <span class="num mut">${done} of ${all}</span></div>`;
}

function goals() {
  return {
    label: 'Goal',
    value: String(goal()),
    kind: 'ghost',
    text: `nothing above ${goal()} px`,
    options: (server.review?.goals ?? []).map((px) => ({
      id: String(px),
      label: `Nothing above ${px} px`,
      note: tooLow(px) ? 'below what a right joint is off' : '',
    })),
    act: (id) => setGoal(Number(id)),
  };
}

/** Whether joints that are right are off by more. */
const tooLow = (px) => (server.review?.right_px ?? 0) > px;

/** @param {ReviewPlace} row @param {import('../store/shapes.js').Answer | undefined} answer */
function drawRow(list, row, answer) {
  const isCurrent = row.id === list.current;
  return html`<div class="rv-place ${isCurrent ? 'on' : ''} ${answer ? 'done' : ''}" role="listitem"
    aria-current=${isCurrent ? 'true' : nothing}>
    <button type="button" class="rv-go" title=${`Go to frame ${row.frame}`} @click=${() => visit(row.id)}>
      <frame-crop aria-hidden="true" .spec=${row}></frame-crop>
      <span class="rv-what">
        <span class="row rv-name"><i class="dot"
          style="background:var(--${row.side})"></i><b class="cut">${row.label}</b><span class="num">${row.frame}</span></span>
        <span class="num rv-size">${
          answer
            ? html`<span class="said">${icon('check')}${SAID[answer]}</span>`
            : row.size || (row.kind === 'draft' ? 'to confirm' : 'size not known')
        }</span>
        <span class="rv-why cut">${row.reason}</span>
      </span>
    </button>
    ${
      isCurrent && !answer && ui.tool !== 'box'
        ? actions(row)
        : answer && ui.reviewHeld === row.id
          ? html`<div class="rv-held" inert>${actions(row)}</div>`
          : nothing
    }
  </div>`;
}

/** @param {ReviewPlace} row */
function actions(row) {
  const refusal = refusalOf(row);
  const advice = row.kind === 'draft' ? DRAFT : limbWords(row);
  return html`<div class="row acts">${act('acceptPlace', 'pri')}${act('nextPlace', 'ghost')}${act('cannotTell', 'ghost', false)}</div>
    <p class="note" role=${refusal ? 'status' : nothing}>${refusal ? `Not accepted. ${refusal}` : advice}</p>`;
}

/** Why its answer was refused, or ''. @param {ReviewPlace} row */
const refusalOf = ({ id }) => (ui.review?.refused?.id === id ? ui.review.refused.words : '');

const DRAFT = 'Accept makes the draft a keyframe. Correct it on the picture first where it is off.';

/** @param {ReviewPlace} row */
function limbWords({ part }) {
  const limb = server.body?.lanes.find(({ parts }) => part && parts.includes(part))?.label.toLowerCase();
  return limb
    ? `Or drag the ring on the picture. That keys only the ${limb}.`
    : 'Or drag what is off. That keys only the limb you drag.';
}

/** @param {import('../actions/actions.js').ActionId} id */
function act(id, kind, showsKey = true) {
  const why = whyNot(id);
  return html`<button type="button" class="btn sm ${kind} ${why ? 'off' : ''}" aria-disabled=${why ? 'true' : nothing}
    title=${why || `${titleOf(id)} (${keyOf(id)})`} @click=${(event) => press(event, id)}>
    ${labelOf(id)}${showsKey ? html`<kbd>${keyOf(id)}</kbd>` : nothing}</button>`;
}

/** By the pointer: nothing moves under it, so the row keeps its height until it leaves. */
function press(event, id) {
  const isPointer = event.detail > 0;
  if (whyNot(id)) return;
  if (isPointer && id !== 'nextPlace') setUi('reviewHeld', ui.review.current);
  perform(id);
}

/** "3 done: 4, 44, 93", those which are no rows any more. */
function doneRow(list) {
  const gone = list.done.filter(({ id }) => !list.rows.some((row) => row.id === id));
  if (!gone.length) return nothing;
  const listed = gone.map(
    ({ label, frame, answer }) =>
      html`<li>${label} <span class="num">${frame}</span> <span class="dim">${SAID[answer].toLowerCase()}</span></li>`,
  );
  return html`<p class="row past num">${icon('check')}${gone.length} done: ${gone.map(({ frame }) => frame).join(', ')}<span class="sp"></span>
      <button type="button" class="btn ghost sm" aria-expanded=${Boolean(ui.reviewDone)}
        @click=${() => setUi('reviewDone', !ui.reviewDone)}>${ui.reviewDone ? 'Hide' : 'Show'}</button></p>
    ${ui.reviewDone ? html`<ul class="rv-done">${listed}</ul>` : nothing}`;
}

function reviewFinishedCard(list) {
  if (!list.done.length && !hasMotion()) {
    return html`<div class="ended none"><p>Nothing to review. Track first.</p>${track('pri')}</div>`;
  }
  if (!hasMotion()) {
    return html`<div class="ended" role="status">
      <p class="row b">${icon('check')}<b>${doneWords(list)}</b></p>
      <p>What lies between the keyframes shows once it is tracked.</p><div class="row">${track('pri')}</div></div>`;
  }
  const soFar = server.review?.untracked ? ' so far' : '';
  return html`<div class="ended" role="status">
    <p class="row b">${icon('check')}<b>Nothing left above ${goal()} px${soFar}</b></p>
    ${list.done.length ? html`<p class="num">${doneWords(list)}</p>` : nothing}
    ${expected()}
    <div class="row"><button type="button" class="btn sm ${soFar ? '' : 'pri'}"
      @click=${() => toggleMenu('export')}>Export…</button>
      ${lower()}</div>
  </div>`;
}

const track = (kind) =>
  html`<button type="button" class="btn sm ${kind}" title=${titleOf('trackChanged')}
    @click=${() => perform('trackChanged')}>${words().verb}<kbd>${keyOf('trackChanged')}</kbd></button>`;

const hasMotion = () => (server.segments ?? []).some(({ state }) => ['good', 'check', 'lost'].includes(state));

function expected() {
  const { px, cm, right_px: right } = server.review ?? {};
  if (px == null) return nothing;
  const rest = tooLow(goal()) ? ` A joint that is right is off by ${roughError(right, null)} in this video.` : '';
  return html`<p class="num">Expected error ${roughError(px, cm ?? null).replace('≈ ', '')}.${rest}</p>`;
}

function lower() {
  const px = lowerGoal();
  if (px === undefined) return nothing;
  return html`<button type="button" class="btn ghost sm"
    @click=${() => setGoal(px)}>Lower the goal to ${px} px</button>`;
}

/** What is not tracked cannot be judged. */
function untracked() {
  const many = server.review?.untracked ?? 0;
  if (!many || !hasMotion()) return nothing;
  const verb = many === 1 ? 'needs' : 'need';
  return html`<p class="row past warned">${icon('warn')}<span>${count(many, 'segment')} ${verb} tracking.</span><span class="sp"></span>${track('')}</p>`;
}

/** Keep the current row in sight. */
export function revealRow(room) {
  if (!ui.review || ui.review.current === revealed) return;
  revealed = ui.review.current;
  room.querySelector('.rv-place.on')?.scrollIntoView({ block: 'nearest' });
}

let revealed = null;
