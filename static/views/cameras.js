// The eyes of the views. An eye says where a point of the camera frame lies in its view's
// plane, and gives three.js the very same projection, so that lines of the page and pictures of
// viser agree whatever the window, the lens and the pixels of the screen.
//
// three.js stands in the camera frame with y up and z toward the viewer: (x, −y, −z).

import { placed } from './floor.js';

const NEAREST_M = 0.05;
const FARTHEST_M = 2000;
/** Parallel views show what lies this far before and behind the body. */
const HALF_DEPTH_M = 200;

const AS_CAMERA = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];

const USUAL_VIEWS = {
  top: [
    [1, 0, 0],
    [0, 0, -1],
    [0, 1, 0],
  ],
  side: [
    [0, 0, 1],
    [0, 1, 0],
    [-1, 0, 0],
  ],
  front: AS_CAMERA,
};

/** The camera's own eye. Its plane is the picture. */
export function cameraEye(camera) {
  const telephoto = camera.projection === 'telephoto';
  const distance = (z) => (telephoto ? camera.telephoto_distance_m : Math.max(z, 0.01));
  return {
    rows: AS_CAMERA,
    project: ([x, y, z]) => [(camera.fx * x) / distance(z) + camera.cx, (camera.fy * y) / distance(z) + camera.cy, z],
    unitsPerMetre: ([, , z]) => camera.fx / distance(z),
    setProjection(matrix, edges, coordinates, reversed) {
      const [left, top] = [(edges[0] - camera.cx) / camera.fx, (edges[1] - camera.cy) / camera.fy];
      const [right, bottom] = [(edges[2] - camera.cx) / camera.fx, (edges[3] - camera.cy) / camera.fy];
      // A telephoto lens is a parallel one whose scale is that at one distance.
      const k = telephoto ? camera.telephoto_distance_m : NEAREST_M;
      const sides = [left * k, right * k, -top * k, -bottom * k, NEAREST_M, FARTHEST_M];
      if (telephoto) matrix.makeOrthographic(...sides, coordinates, reversed);
      else matrix.makePerspective(...sides, coordinates, reversed);
    },
  };
}

/**
 * The eye of another film. Its plane is that film's picture.
 * @param {import('../store/shapes.js').FilmLens} camera
 * @param {number[]} T  From the first camera's frame to its own: three rows of four.
 */
export function filmEye(camera, T) {
  const eye = cameraEye(/** @type {any} */ (camera));
  const rows = [0, 4, 8].map((row) => T.slice(row, row + 3));
  const own = (p) => placed([p], T)[0];
  return {
    ...eye,
    rows,
    place: [0, 1, 2].map((k) => -rows.reduce((sum, row, i) => sum + row[k] * T[4 * i + 3], 0)),
    project: (p) => eye.project(own(p)),
    unitsPerMetre: (p) => eye.unitsPerMetre(own(p)),
  };
}

/** An eye with parallel rays, its rows those of R_view_camera. Its plane is in metres, from the
 * world's origin. */
export function parallelEye(name, rotations, middle) {
  const rows = rotations?.[name] ?? USUAL_VIEWS[name];
  const place = rotations?.origin ?? [0, 0, 0];
  const along = (row, p) => row[0] * (p[0] - place[0]) + row[1] * (p[1] - place[1]) + row[2] * (p[2] - place[2]);
  const depth = along(rows[2], middle);
  return {
    rows,
    place,
    project: (p) => [along(rows[0], p), along(rows[1], p), along(rows[2], p)],
    unitsPerMetre: () => 1,
    setProjection(matrix, edges, coordinates, reversed) {
      const [near, far] = [depth - HALF_DEPTH_M, depth + HALF_DEPTH_M];
      const sides = [edges[0], edges[2], -edges[1], -edges[3], near, far];
      matrix.makeOrthographic(...sides, coordinates, reversed);
    },
  };
}

/** Give a three.js camera the eye of a view and the stretch of its plane that the window shows. */
export function aim(camera, eye, window) {
  const [[a, b, c], [d, e, f], [g, h, i]] = eye.rows;
  const [x, y, z] = eye.place ?? [0, 0, 0];
  // R_view_camera with y and z turned over on both sides; its transpose is the camera's turn.
  camera.matrixWorld.set(a, -d, -g, x, -b, e, h, -y, -c, f, i, -z, 0, 0, 0, 1);
  camera.matrixWorldInverse.copy(camera.matrixWorld).invert();
  const low = window.toPlane([0, 0]);
  const high = window.toPlane([window.width, window.height]);
  const { projectionMatrix, projectionMatrixInverse } = camera;
  const { coordinateSystem, reversedDepth } = camera;
  eye.setProjection(projectionMatrix, [...low, ...high], coordinateSystem, reversedDepth);
  projectionMatrixInverse.copy(projectionMatrix).invert();
}
