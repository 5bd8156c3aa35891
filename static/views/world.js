// The world, which stands still while the film's camera moves: points of it for the camera at the present
// frame, and back. T are rows of three by four, as the server sends them; null is the identity.

/** A point of one frame in another. @param {number[]} p @param {number[] | null} T */
export function moved(p, T) {
  if (!T) return p;
  const [x, y, z] = p;
  return [
    T[0] * x + T[1] * y + T[2] * z + T[3],
    T[4] * x + T[5] * y + T[6] * z + T[7],
    T[8] * x + T[9] * y + T[10] * z + T[11],
  ];
}

/** The same the other way round. @param {number[]} p @param {number[] | null} T */
export function movedBack(p, T) {
  if (!T) return p;
  const [x, y, z] = [p[0] - T[3], p[1] - T[7], p[2] - T[11]];
  return [T[0] * x + T[4] * y + T[8] * z, T[1] * x + T[5] * y + T[9] * z, T[2] * x + T[6] * y + T[10] * z];
}
