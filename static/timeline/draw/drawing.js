// The drawing is a stack of layers from back to front, each drawn again only when something it is drawn
// from changed: the playhead moves over lanes and curves that stay as they are.

import { render } from '../../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../../store/state.js';
import { isSurface } from '../../store/clip.js';
import { frame, segmentAt, suggestedFrame } from '../../actions/playhead.js';
import { selectedKeys } from '../../actions/selection.js';
import { selectFrom } from '../edit/drags.js';
import { grabbed, hovered } from '../edit/pointer.js';
import { drawClip, drawDamage, drawGround, drawKeyLabels, drawNothingYet, drawRuler } from './ground.js';
import {
  drawCurrent, drawCurrentPart, drawKeys, drawNeed, drawPartKeys, drawSuggestion,
} from './keymarks.js';
import { drawDrafts, drawPlaces } from './drafts.js';
import { drawNotes, drawReduced, drawReviewPlaces, drawSpan } from './rulermarks.js';
import { drawSegments } from './segments.js';
import { drawLaneLabels, drawLanes } from './lanes.js';
import { drawGrips, drawSelectionBand } from './selection.js';
import { drawPinLabels, drawPins } from './pins.js';
import { drawCurrentCurveKey, drawCurve } from './curve.js';
import { drawCurveLabels } from './curvelabels.js';
import { drawScoreLabels, drawScores } from './scores.js';
import { drawBand, drawGrabbed, drawPlayhead } from './overlay.js';
import { drawOverview } from './overview.js';
import { memoize } from './series.js';

/** A function that draws the layer if any of its inputs is another than the last time. */
function layer(element, inputs, draw) {
  let before = null;
  return () => {
    const now = inputs();
    if (before !== null && now.every((value, i) => Object.is(value, before[i]))) return;
    before = now;
    render(draw(), element);
  };
}

const isScore = () => ui.chart === 'score' && !isSurface() && (server.segments ?? []).length > 0;

/** Where frames end: the chart of scores under them has passes across, not frames. */
const bottomOf = (rows) => (isScore() && rows.curve !== null ? rows.curve.y - 3 : rows.height);

const noteGrabbed = () => (grabbed()?.kind === 'note' ? grabbed().from : null);
/** The frames of the keyframes that are on their way: where they were they are not drawn. */
const NONE = [];
const keysGrabbed = memoize((what) => {
  if (what === null || what.copy) return NONE;
  return what.kind === 'key' ? [what.from] : what.kind === 'keys' ? what.frames : NONE;
});
const onTheWay = () => keysGrabbed(grabbed());
const chosenKeys = () => (grabbed()?.kind === 'keys' ? NONE : selectedKeys());
const pinGrabbed = () => (grabbed()?.kind === 'pin' ? grabbed() : null);
const angleGrabbed = () => (grabbed()?.kind === 'angle' ? grabbed().frame : null);

/** [where, name, what it is drawn from, how]; all are drawn from the ground as well. */
/** @type {[string, string, () => unknown[], (ground: any) => unknown][]} */
const LAYERS = [
  ['back', 'ground', () => [], ({ rows }) => drawGround(rows)],
  ['frames', 'ruler', () => [isScore()], ({ rows }) => drawRuler(bottomOf(rows))],
  ['frames', 'damage', () => [server.damage, isScore()], ({ rows }) => drawDamage(bottomOf(rows))],
  ['frames', 'bands', () => [frame(), server.keys, isScore()], ({ rows }) => drawBand(rows, bottomOf(rows))],
  ['frames', 'lanes', () => [server.view?.selected],
    ({ rows, lanes, scroll }) => drawLanes(rows, lanes, scroll)],
  ['frames', 'pinbars', () => [server.pins, server.proposed_pins, server.body, ui.timePin, pinGrabbed()],
    ({ rows }) => drawPins(rows.pins)],
  ['frames', 'selection', () => [chosenKeys()], ({ rows }) => drawSelectionBand(rows, chosenKeys())],
  ['frames', 'need', () => [server.need, server.suggest], ({ rows }) => drawNeed(rows)],
  ['frames', 'segments', () => [server.segments, server.suggest, server.keys], ({ rows }) => drawSegments(rows)],
  ['frames', 'drafts', () => [server.keys, server.segments, server.draft], ({ rows }) => drawDrafts(rows)],
  ['frames', 'chart', () => [isScore(), ...chartInputs()],
    ({ rows }) => (isScore() ? drawScores(rows.curve) : drawCurve(rows.curve, angleGrabbed()))],
  ['frames', 'suggestion', () => [suggestedFrame(), server.keys, isScore(), Boolean(ui.review)],
    ({ rows }) => drawSuggestion(rows, bottomOf(rows))],
  ['frames', 'grips', () => [chosenKeys()], ({ rows }) => drawGrips(rows, chosenKeys())],
  ['frames', 'keys', () => [server.keys, server.segments, String(onTheWay()), chosenKeys()],
    ({ rows }) => [drawKeys(rows, onTheWay(), chosenKeys()), drawPartKeys(rows, onTheWay())]],
  ['frames', 'reduced', () => [server.reduction, server.keys], ({ rows }) => drawReduced(rows)],
  ['frames', 'places', () => [server.draft, isScore()], ({ rows }) => drawPlaces(rows, bottomOf(rows))],
  ['frames', 'review-places', () => [server.review, ui.review, ui.reviewGoal, ui.reviewLeft], () => drawReviewPlaces()],
  ['frames', 'current', () => [frame(), String(onTheWay()), chosenKeys(), angleGrabbed(), isScore(), ...curveInputs()],
    ({ rows }) => [
      onTheWay().includes(frame()) ? null : [drawCurrent(rows, chosenKeys()), drawCurrentPart(rows)],
      isScore() || angleGrabbed() !== null ? null : drawCurrentCurveKey(rows.curve),
    ]],
  ['frames', 'span', () => [ui.span, isScore()], ({ rows }) => drawSpan(bottomOf(rows))],
  ['frames', 'nothing', () => [server.curve, isScore()],
    ({ rows, empty }) => drawNothingYet(rows, empty, isScore())],
  ['above', 'labels', () => [server.keys], ({ rows }) => [drawClip(), drawKeyLabels(rows)]],
  ['above', 'lane-labels', () => [server.view?.selected],
    ({ rows, lanes, scroll }) => drawLaneLabels(rows, lanes, scroll, toggleGroup, selectOf)],
  ['above', 'pin-labels', () => [server.pins, server.proposed_pins, server.body], ({ rows }) => drawPinLabels(rows.pins)],
  ['above', 'chart-labels', () => [isScore(), ...chartInputs()],
    ({ rows }) => (isScore() ? drawScoreLabels(rows.curve) : drawCurveLabels(rows.curve))],
  ['above', 'overview', () => [server.segments, server.keys, frame()], () => drawOverview()],
  ['frames', 'notes', () => [server.notes, noteGrabbed()], () => drawNotes(noteGrabbed())],
  ['top', 'head', () => [frame(), server.keys, selectedKeys(), server.segments, isScore()],
    ({ rows }) => drawPlayhead(bottomOf(rows))],
  ['top', 'grabbed', () => [grabbed(), hovered(), server.segments, server.curve, server.pins, ui.curveAxis, ui.span],
    ({ rows }) => drawGrabbed(rows)],
];

function curveInputs() {
  return [server.curve, server.segments, server.keys, server.body, ui.curveAxis, angleGrabbed()];
}

const chartInputs = () => (isScore() ? [segmentAt(frame())] : curveInputs());

/** Build the groups, and return each layer as a function that draws it where it changed. */
export function layersOf(drawing, ground) {
  const places = {};
  for (const place of ['back', 'frames', 'above', 'top']) places[place] = group(drawing, place);
  places.frames.setAttribute('clip-path', 'url(#tl-frames)');
  return LAYERS.map(([place, name, inputs, draw]) => {
    const common = () => {
      const { rows, lanes, scroll, empty } = ground();
      return [rows, lanes, scroll, empty, ui.timeWindow, ui.timeSize, server.file];
    };
    return layer(group(places[place], name), () => [...common(), ...inputs()], () => draw(ground()));
  });
}

function group(parent, name) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', 'g');
  element.setAttribute('class', name);
  return parent.appendChild(element);
}

function toggleGroup(lane) {
  const open = new Set(ui.timeOpen);
  if (!open.delete(lane.label)) open.add(lane.label);
  setUi('timeOpen', open);
}

/** A lane's name selects its part and leaves the playhead where it is. */
const selectOf = (lane) => selectFrom(lane, frame());
