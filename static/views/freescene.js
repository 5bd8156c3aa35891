// What the free view shows beside the body: the floor and the body's shadow below it, ghosts of the
// neighbouring keyframes, the ways of the feet with their heights, and the film's camera.

import { nothing, svg } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { CELL_M, dropped, gridPaths, outlineOf, placed } from './floor.js';
import { dot, plus } from './orbit.js';
import { moved, movedBack } from './world.js';

/** The grid reaches so many times as far as the eye is from what it looks at, within these. */
const REACH = 0.95;
const [LEAST_REACH_M, MOST_REACH_M] = [2.5, 8];
const FARTHEST_CELL_M = 12;
/** Frames of the feet's ways to both sides of the present. */
const WAY_FRAMES = 150;
const FLAT_M = 0.01;
const NEAR_M = 0.05;
/** The picture stands so far before the camera, or at this share of the way to the body. */
const PICTURE_M = 1.2;
const PICTURE_SHARE = 1 / 3;

/** Where the floor is and which way is down, for the camera at the present frame; null before the page
 * knows. */
export function ground() {
  if (!server.feet || !server.views) return null;
  const { front: level, origin } = server.views;
  return { level, floor: server.feet.floor_m - dot(level[1], origin) };
}

/** A point of the world for the camera at the present frame. @param {number[]} p */
export const toCamera = (p) => movedBack(p, server.camera_here);

/** Whether there is a body to see: somebody posed it at some frame. */
export function hasBody() {
  return Boolean(server.pose && server.keys && server.keys.frames.length + server.keys.drafts.length);
}

/** The middle of the body, or of where it will be. */
export function bodyMiddle() {
  const points = Object.values(server.pose?.points ?? {});
  return points.length ? mean(points) : [0, 0, 3];
}

/** @param {number[][]} points */
const mean = (points) => points.reduce((total, p) => plus(total, p, 1 / points.length), [0, 0, 0]);

/** Between the feet, or between whatever limbs' ends are followed. */
export function feetMiddle() {
  const feet = (server.feet?.paths ?? []).map(({ part }) => server.pose?.points[part]).filter(Boolean);
  return feet.length ? mean(feet) : bodyMiddle();
}

const path = (points, isClosed) =>
  points.length ? `M${points.map((p) => `${p[0].toFixed(1)} ${p[1].toFixed(1)}`).join('L')}${isClosed ? 'Z' : ''}` : '';

// --- floor and shadow

export function drawFloor(project, distance) {
  const { level, floor } = ground();
  const reach = Math.min(Math.max(REACH * distance, LEAST_REACH_M), MOST_REACH_M);
  const cell = distance > FARTHEST_CELL_M ? 4 * CELL_M : CELL_M;
  const paths = gridPaths(project, { level, floor, centre: bodyMiddle(), reach, cell });
  return svg`<g class="floor">${paths.map(
    ({ d, share, isStrong }) =>
      svg`<path class=${isStrong ? 'strong' : ''} d=${d} stroke-opacity=${(share * (isStrong ? 0.7 : 0.3)).toFixed(3)}
        />`,
  )}</g>`;
}

/** The parts let straight down to the floor, blurred. */
export function drawShadow(project) {
  if (!hasBody() || !server.solids) return nothing;
  const { level, floor } = ground();
  const down = (p) => project(dropped(p, level, floor));
  return svg`<defs><filter id="free-soft" x="-40%" y="-40%" width="180%" height="180%">
      <feGaussianBlur stdDeviation="9" /></filter></defs>
    <path class="shadow" filter="url(#free-soft)" d=${outlines(server.pose.T, down)
      .map(({ d }) => d)
      .join('')} />`;
}

/** The outline of every part standing so, with its depth. */
function outlines(T, project) {
  return server.body.parts
    .filter(({ name }) => server.solids[name] && T[name])
    .map(({ name, side }) => {
      const points = placed(server.solids[name].points, T[name]);
      const corners = outlineOf(points, project);
      return { side, d: path(corners, true), depth: project(points[0])[2] };
    });
}

// --- ghosts

export function drawGhosts(project) {
  if (!hasBody() || !server.solids) return nothing;
  return svg`${(server.ghosts ?? []).map((ghost) => drawGhost(project, ghost))}`;
}

function drawGhost(project, { frame, T }) {
  const parts = outlines(T, project).sort((a, b) => b.depth - a.depth);
  return svg`<g class="ghost" data-ghost=${frame}>
    ${parts.map(({ side, d }) => svg`<path class=${`side-${side}`} d=${d} />`)}
  </g>`;
}

/** Each ghost's frame at the foot that stands lowest. */
export function ghostLabels(project) {
  const { level } = ground();
  return (server.ghosts ?? []).map(({ frame, T }) => {
    const side = frame < server.view.frame ? -8 : 8; // both may stand in one place
    const feet = (server.feet.paths ?? []).map(({ part }) => T[part]).filter(Boolean);
    const places = (feet.length ? feet : Object.values(T)).map((t) => [t[3], t[7], t[11]]);
    const lowest = places.reduce((a, b) => (dot(level[1], b) > dot(level[1], a) ? b : a));
    return { words: `${frame}`, at: project(lowest), shift: [side, 18] };
  });
}

// --- the feet's ways

/** Which of the known moments are drawn: those around the present frame. */
function shownMoments() {
  const { frames } = server.feet;
  const { frame } = server.view;
  return frames.flatMap((at, i) => (Math.abs(at - frame) <= WAY_FRAMES ? [i] : []));
}

const isWayShown = () => Boolean(server.view?.trail && hasBody() && server.feet?.paths.length);

/** The feet's ways for the camera at the present frame. */
function pathsHere() {
  const { paths } = server.feet;
  if (!server.camera_motion) return paths;
  return paths.map((foot) => ({ ...foot, points: foot.points.map(toCamera) }));
}

export function drawWays(project) {
  if (!isWayShown()) return nothing;
  const shown = shownMoments();
  return svg`<g class="ways">${pathsHere().map((foot) => drawWay(project, foot, shown))}</g>`;
}

function drawWay(project, { side, points }, shown) {
  const { level, floor } = ground();
  const { frames } = server.feet;
  const seen = shown.map((i) => ({
    frame: frames[i],
    at: project(points[i]),
    low: project(dropped(points[i], level, floor)),
  }));
  const whole = seen.filter(({ at, low }) => at[2] > NEAR_M && low[2] > NEAR_M);
  const past = whole.filter(({ frame }) => frame <= server.view.frame);
  const future = whole.filter(({ frame }) => frame >= server.view.frame);
  return svg`<path class="below" d=${path(whole.map(({ low }) => low))} />
    ${drawHeight(project, points, shown)}
    <path class=${`way side-${side}`} d=${path(past.map(({ at }) => at))} />
    <path class=${`way future side-${side}`} d=${path(future.map(({ at }) => at))} />`;
}

/** Straight down from where the foot is now, if it is off the floor. */
function drawHeight(project, points, shown) {
  const { level, floor } = ground();
  const p = points[nearestMoment(shown)];
  const low = p && dropped(p, level, floor);
  if (!p || Math.hypot(...plus(p, low, -1)) < FLAT_M) return nothing;
  return svg`<path class="height" d=${path([project(p), project(low)])} />`;
}

function nearestMoment(shown) {
  const { frames } = server.feet;
  const away = (i) => Math.abs(frames[i] - server.view.frame);
  return shown.reduce((best, i) => (away(i) < away(best) ? i : best), shown[0]);
}

/** The keyframes on the feet's ways: where to press to go there. */
export function wayKeys(project) {
  if (!isWayShown()) return [];
  const keys = new Set(server.keys.frames);
  const { frames } = server.feet;
  const shown = shownMoments().filter((i) => keys.has(frames[i]));
  return pathsHere().flatMap(({ part, points, label }) =>
    shown
      .map((i) => ({ part, frame: frames[i], at: project(points[i]), label: `${label}, frame ${frames[i]}` }))
      .filter(({ at }) => at[2] > NEAR_M),
  );
}

/** The first and the last frame of what is shown, at the way of the foot that goes farthest. */
export function wayLabels(project) {
  if (!isWayShown()) return [];
  const shown = shownMoments();
  const reach = ({ points }) => Math.max(...shown.map((i) => Math.hypot(...plus(points[i], points[shown[0]], -1))));
  const { points } = pathsHere().reduce((best, foot) => (reach(foot) > reach(best) ? foot : best));
  const ends = [...new Set([shown[0], shown.at(-1)])].filter((i) => i !== undefined);
  return ends.map((i) => ({ words: `${server.feet.frames[i]}`, at: project(points[i]), shift: [-8, 16] }));
}

// --- the film's camera

/** The film's camera: where it stands and the corners of its picture; null where it has no film. */
export function filmCamera() {
  const { camera } = server;
  if (!camera) return null;
  const isTele = camera.projection === 'telephoto';
  const away = Math.min(PICTURE_M, PICTURE_SHARE * Math.max(bodyMiddle()[2], 0.3));
  const k = isTele ? camera.telephoto_distance_m : away;
  const [w, h] = [camera.width - 0.5, camera.height - 0.5];
  const corners = [
    [-0.5, -0.5],
    [w, -0.5],
    [w, h],
    [-0.5, h],
  ].map(([u, v]) => [((u - camera.cx) / camera.fx) * k, ((v - camera.cy) / camera.fy) * k, away]);
  return { place: [0, 0, 0], corners, isTele };
}

/** Four lines from the camera to its picture's corners, and the frame. */
export function drawFilmCamera(project) {
  const { place, corners, isTele } = filmCamera();
  const [at, seen] = [project(place), corners.map(project)];
  if (seen.some((p) => p[2] < NEAR_M)) return nothing;
  const rays = isTele || at[2] < NEAR_M ? [] : seen.map((corner) => path([at, corner]));
  return svg`<g class="film">${rays.map((d) => svg`<path class="ray" d=${d} />`)}
    <path class="frame" d=${path(seen, true)} /></g>`;
}

/** So many of the frames at which the camera is drawn on its path. */
const MOST_FRUSTUMS = 12;
/** How far before its place a frustum's picture stands. */
const FRUSTUM_M = 0.25;

/** The way of a camera that moves, and how it looked on it. */
export function drawCameraPath(project) {
  const path_ = server.camera_motion?.path;
  if (!path_) return nothing;
  const places = path_.T.map((T) => project(toCamera([T[3], T[7], T[11]])));
  const every = Math.max(1, Math.ceil(path_.T.length / MOST_FRUSTUMS));
  const drawn = path_.T.map((T, i) => ({ T, i })).filter(({ i }) => i % every === 0);
  return svg`<g class="campath">
    <path class="way" d=${path(places.filter((p) => p[2] > NEAR_M))} />
    ${drawn.map(({ T, i }) => svg`<path class="sight" d=${frustum(project, T, path_.zoom[i])} />`)}</g>`;
}

/** The pyramid of what a camera sees that stands so. */
function frustum(project, T, zoom) {
  const { camera } = server;
  const here = camera.fx / zoomHere();
  const corners = [
    [-0.5, -0.5],
    [0.5, -0.5],
    [0.5, 0.5],
    [-0.5, 0.5],
  ].map(([x, y]) => [
    (x * camera.width * FRUSTUM_M) / (here * zoom),
    (y * camera.height * FRUSTUM_M) / (here * zoom),
    FRUSTUM_M,
  ]);
  const seen = [[0, 0, 0], ...corners].map((p) => project(toCamera(moved(p, T))));
  if (seen.some((p) => p[2] < NEAR_M)) return '';
  const [at, ...frame] = seen;
  return frame.map((corner) => path([at, corner])).join('') + path(frame, true);
}

/** The zoom of the present frame: the camera's numbers are those of it. */
function zoomHere() {
  const { frames, zoom } = server.camera_motion.path;
  const nearest = frames.reduce(
    (best, f, i) => (Math.abs(f - server.view.frame) < Math.abs(frames[best] - server.view.frame) ? i : best),
    0,
  );
  return zoom[nearest];
}

/** "26 mm · frame 50": the lens as the Camera tab says it. */
export function filmWords() {
  const { focal_mm: mm, lens_is_guess: isGuess } = server.camera;
  return `${isGuess ? '≈ ' : ''}${Math.round(mm)} mm · frame ${ui.shown ?? server.view.frame}`;
}
