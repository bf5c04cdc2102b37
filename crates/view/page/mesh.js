// Corners of a surface with normals: smooth, but for edges.

import { cross, dot, unit } from "./matrix.js";

// Cosine of the angle between faces from which on there is an edge.
const EDGE = 0.7;

// Places and normals, six numbers for each corner of each triangle.
export function shaded(places, corners) {
  const faces = corners.length / 3;
  const normals = [];
  const around = new Map();
  const at = (corner) => places.subarray(3 * corner, 3 * corner + 3);
  for (let face = 0; face < faces; face++) {
    const [a, b, c] = [0, 1, 2].map((k) => at(corners[3 * face + k]));
    const [u, v] = [b, c].map((p) => [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
    normals.push(cross(u, v));
    for (let k = 0; k < 3; k++) {
      const corner = corners[3 * face + k];
      if (!around.has(corner)) around.set(corner, []);
      around.get(corner).push(face);
    }
  }
  const units = normals.map(unit);
  const shadedCorners = new Float32Array(18 * faces);
  for (let face = 0; face < faces; face++) {
    for (let k = 0; k < 3; k++) {
      const corner = corners[3 * face + k];
      let sum = [0, 0, 0];
      for (const other of around.get(corner)) {
        if (dot(units[other], units[face]) > EDGE) {
          sum = sum.map((x, i) => x + normals[other][i]);
        }
      }
      shadedCorners.set(at(corner), 18 * face + 6 * k);
      shadedCorners.set(unit(sum), 18 * face + 6 * k + 3);
    }
  }
  return shadedCorners;
}
