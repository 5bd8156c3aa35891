// The three angles of the selected part, within their joint limits, and the frame of the rings.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { keyOf } from '../actions/actions.js';
import { actionIcon } from '../actions/buttons.js';
import { icon } from '../controls/icons.js';
import { checkbox, numberField, segmented, shortNumber, slider } from '../controls/fields.js';
import { isFree } from '../store/parts.js';
import { section } from './section.js';

const AXES = ['x', 'y', 'z'];
const FULL_TURN = [-180, 180];
const ROOM = 0.12;

export function rotation(part) {
  return section(
    'Rotation',
    html`${AXES.map((axis, i) => angle(part, axis, server.pose?.angles[part.name]?.[i] ?? null))}${frames()}`,
    actionIcon('resetPart'),
  );
}

function angle(part, axis, value) {
  const limits = part.limits?.[axis] ?? null;
  const spec = {
    key: `${server.view.frame}.${part.name}.${axis}`,
    label: part.words?.[axis] ?? axis.toUpperCase(),
    value,
    unit: '°',
    min: -1080,
    max: 1080,
    coarse: 5,
    limit: isFree(part.name, axis) ? null : limits,
    edit: (deg) => ({ do: 'angles', part: part.name, [axis]: deg, free: isFree(part.name, axis) }),
    off: value === null ? 'No pose at this frame' : '',
  };
  const [min, max] = track(limits, isFree(part.name, axis));
  const title = `${spec.label}${words(limits)}. Double-click to reset`;
  return html`<div class="f">
    <label class="cut" title=${spec.label}>
      <b style="color:var(--g${axis})">${axis.toUpperCase()}</b>${spec.label}
    </label>
    ${slider({ ...spec, min, max, zero: 0, title, band: limits })}
    ${numberField(spec)}${lock(part, axis, limits)}
  </div>`;
}

/** The ends of the slider: a little beyond the limits while they hold, else a full turn. */
function track(limits, free) {
  if (!limits || free) return FULL_TURN;
  const room = ROOM * Math.max(20, limits[1] - limits[0]);
  return [Math.min(0, limits[0]) - room, Math.max(0, limits[1]) + room];
}

function words(limits) {
  if (!limits) return '';
  const [low, high] = limits.map((degrees) => `${shortNumber(degrees, 0)}°`);
  return `, joint limits ${low} to ${high}`;
}

function lock(part, axis, limits) {
  const free = isFree(part.name, axis);
  const off = reasonOff(limits);
  const word = part.words?.[axis] ?? axis.toUpperCase();
  const label = free ? `Apply the joint limits of ${word}` : `Ignore the joint limits of ${word}`;
  return html`<button
    type="button"
    class="lk ${free && !off ? 'on' : ''} ${off ? 'off' : ''}"
    aria-label=${label}
    aria-pressed=${!free}
    aria-disabled=${off ? 'true' : nothing}
    title=${off || label}
    data-key=${off ? nothing : holdKey()}
    @click=${() => off || setFree(part, axis, !free)}
  >
    ${icon(free ? 'unlock' : 'lock')}
  </button>`;
}

const holdKey = () => `hold ${keyOf('free')} in a drag`;

function reasonOff(limits) {
  if (!limits) return 'This axis has no limits';
  return server.view.limits ? '' : 'Joint limits are off for the whole body';
}

function setFree(part, axis, free) {
  const next = new Set(ui.freeAxes ?? []);
  if (free) next.add(`${part.name}.${axis}`);
  else next.delete(`${part.name}.${axis}`);
  setUi('freeAxes', next);
}

function frames() {
  const options = [
    { id: 'part', label: 'Part', title: 'Rings along the part’s own axes' },
    { id: 'parent', label: 'Parent', title: 'Rings along the axes of the parent part' },
    { id: 'view', label: 'View', title: 'Rings along the axes of the view' },
  ];
  return html`<div class="row frames">
    ${segmented({
      label: 'Axes of the rings',
      value: server.view.axes,
      options,
      act: (frame) => send({ do: 'axes', frame }),
    })}<span class="sp"></span>
    ${checkbox({
      label: 'Joint limits',
      on: server.view.limits,
      act: (on) => send({ do: 'limits', on }),
      title: 'Keep every joint within its anatomical limits',
      key: holdKey(),
    })}
  </div>`;
}
