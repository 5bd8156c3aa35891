// Where the selected part is pinned, by which of its points, and the floor it may stand on.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { actionBox, actionButton, actionIcon } from '../actions/buttons.js';
import { keyOf } from '../actions/actions.js';
import {
  allPins,
  exactWithin,
  framesOf,
  isEnd,
  isFoot,
  onFloor,
  pinHere,
  pinMeant,
  pinPart,
  pinsOf,
  proposedPins,
  showPin,
  wholeFoot,
} from '../actions/pins.js';
import { isUpKnown } from '../actions/standing.js';
import { button, checkbox, iconButton, segmented, shortNumber } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server } from '../store/state.js';
import { line, measure, section } from './section.js';

const FLOOR_M = [-4, 1];

/** Whether they come first: of hands and feet, and of whatever is pinned. */
export const pinsComeFirst = (part) => isEnd(part) || pinsOf(part).length > 0;

export function pins(part) {
  const list = pinsOf(part);
  const proposed = proposedPins().filter((pin) => pin.part === part.name);
  const empty = list.length + proposed.length === 0;
  return section(
    'Pins',
    html`${list.map((index) => pinRow(allPins()[index], index))}${proposed.map(proposedRow)}
    ${empty ? html`<p class="note">${why(part)}</p>` : nothing}${details(part, pinMeant(part))}`,
    pinHere(part) === undefined ? pinButton(part) : nothing,
  );
}

function why(part) {
  const key = isEnd(part) ? ` ${keyOf('pin')} does so from anywhere.` : '';
  return `Pin it where it stands still: tracking keeps it in its place.${key}`;
}

function pinButton(part) {
  return iconButton({
    name: 'plus',
    label: 'Pin here',
    key: isEnd(part) ? keyOf('pin') : '',
    act: () => pinPart(part),
    title: 'Pin here, as long as it stands still around this frame',
  });
}

function pinRow(pin, index) {
  return html`<div class="row pinrow ${pin.problem ? 'wrong' : ''}">${named(pin, '')}${actionButton('unpin', index, {
    name: undefined,
    kind: 'ghost',
  })}</div>
    ${pin.problem ? problem(pin, index) : nothing}`;
}

function proposedRow(pin) {
  return html`<div class="row pinrow">${named(pin, 'proposed')}${actionIcon('acceptPins', pin)}${actionIcon('dismissPins', pin)}</div>`;
}

/** Its bar, its name and its frames; a click goes there. */
function named(pin, kind) {
  const inside = pin.first <= server.view.frame && server.view.frame <= pin.last;
  return html`<svg class=${`swatch ${pin.side} ${kind}`} width="14" height="10" aria-hidden="true">
      ${svg`<rect x="0.75" y="0.75" width="12.5" height="8.5" rx="3" />`}</svg>
    <button type="button" class="row name" title=${`Go to frame ${pin.first}${kind && ', proposed'}`}
      aria-current=${inside ? 'true' : nothing}
      @click=${() => showPin(pin, inside ? server.view.frame : pin.first)}>
      <span class="cut">${pin.label}</span><span class="mut num">${framesOf(pin)}</span></button>
    <span class="sp"></span>`;
}

/** The keyframe against it, with what can be done. */
function problem(pin, index) {
  const { keyframe } = pin;
  return html`<div class="note warned pinproblem" role="status">${icon('warn')}<div>${pin.problem}
    <div class="lr">${actionButton('softKey', keyframe, { name: undefined })}
    ${actionButton('splitPin', { index, frame: keyframe }, { name: undefined })}</div></div></div>`;
}

/** What the pin holds, of a foot, and how well. */
function details(part, index) {
  const pin = allPins()[index];
  if (!pin) return nothing;
  const change = (fields) => ({ do: 'change_pin', index, ...fields });
  return html`${isFoot(part) ? holds(part, pin, change) : nothing}
    ${checkbox({
      label: 'Keep on the floor',
      on: pin.floor,
      title: `Of ${pin.label.toLowerCase()}, frames ${framesOf(pin)}`,
      act: (on) => (on ? onFloor(change({ floor: true }), part) : send(change({ floor: false }))),
    })}
    ${pin.floor ? withoutEffect(pin) : nothing}
    ${
      pin.slides_cm === null
        ? nothing
        : html`<p class="note">Slides at most ${shortNumber(pin.slides_cm, 1)} cm in ${framesOf(pin)}.</p>`
    }`;
}

/** Why a foot may not come to the floor though it is to, and what to do about it. */
function withoutEffect(pin) {
  if (!isUpKnown()) {
    return html`<p class="note warned">What is up is not known yet, so the floor has no effect.</p>${actionButton(
      'findUp',
      undefined,
      { name: undefined },
    )}`;
  }
  const exact = exactWithin(pin);
  if (exact.length === 0) return nothing;
  const words = exact.length === 1 ? `Keyframe ${exact[0]} is exact and holds` : `${exact.length} exact keyframes hold`;
  return html`<p class="note warned">${words} the foot where it was posed.</p>${actionButton('softKeys', exact, {
    name: undefined,
  })}`;
}

function holds(part, pin, change) {
  const whole = wholeFoot(part);
  const [heel, toe] = whole;
  const value = pin.landmarks.length === 1 ? pin.landmarks[0] : 'whole';
  return line(
    'Holds',
    segmented({
      label: 'Holds',
      value,
      options: [
        { id: 'whole', label: 'Whole foot' },
        { id: heel, label: 'Heel' },
        { id: toe, label: 'Toes' },
      ],
      act: (id) => send(change({ landmarks: id === 'whole' ? whole : [id] })),
    }),
  );
}

/** Where the floor is. */
export function floor(part) {
  if (!server.floor) return nothing;
  const { height_m: height, has_feet: hasFeet } = server.floor;
  return section(
    'Floor',
    html`${measure(
      {
        key: 'floor',
        label: 'Height',
        value: height,
        unit: 'm',
        decimals: 2,
        step: 0.01,
        coarse: 0.1,
        min: -100,
        max: 100,
        title: 'Along up, from the camera',
        edit: (metres) => ({ do: 'floor', height_m: metres }),
      },
      height === null ? null : FLOOR_M,
    )}
    ${height === null ? html`<p class="note">Not known yet.</p>` : nothing}
    ${actionBox('floor', undefined, { label: 'Show the grid' })}
    <div class="lr floorset">${button({
      name: 'mid',
      label: 'Set from pinned feet',
      act: () => send({ do: 'floor', pinned_feet: true }),
      title: 'At the height of the feet that are pinned',
      off: hasFeet ? '' : 'Pin a foot that stands on the floor first',
    })}${height === null && isFoot(part) ? underFoot(part) : nothing}</div>`,
    iconButton({
      name: 'reset',
      label: 'Forget the floor',
      act: () => send({ do: 'floor' }),
      off: height === null ? 'No floor is set' : '',
    }),
  );
}

function underFoot(part) {
  return button({
    label: 'Use this foot’s height',
    title: `Where the ${part.label.toLowerCase()} stands now`,
    act: () => send({ do: 'floor', under: part.name }),
  });
}
