// Which object is under the pointer.

import { add, cross, dot, scale, sub, unit } from "./matrix.js";

// The object that is in front at pixels, and the place there; null where there is none.
export function pickObject(painter, camera, x, y, width, height) {
  if (!painter?.frame || !painter.layout) return null;
  const eye = camera.eye();
  const through = camera.unproject(x, y, width, height, camera.target);
  const along = unit(sub(through, eye));
  let best = null;
  painter.layout.objects.forEach(({ places, corners }, object) => {
    const [px, py, pz, qx, qy, qz, qw] = painter.frame.poses.subarray(7 * object, 7 * object + 7);
    // The ray in the frame of the object.
    const back = (v) => rotate([-qx, -qy, -qz, qw], v);
    const [from, way] = [back(sub(eye, [px, py, pz])), back(along)];
    for (let k = 0; k < corners.length; k += 3) {
      const at = (n) => places.subarray(3 * corners[k + n], 3 * corners[k + n] + 3);
      const far = meets(from, way, at(0), at(1), at(2));
      if (far !== null && (best === null || far < best.far)) best = { object, far };
    }
  });
  return best && { object: best.object, place: add(eye, scale(along, best.far)) };
}

function rotate([x, y, z, w], v) {
  const t = scale(cross([x, y, z], v), 2);
  return add(add(v, scale(t, w)), cross([x, y, z], t));
}

// How far along a ray it meets a triangle; null where it does not.
function meets(from, way, a, b, c) {
  const [u, v] = [sub(b, a), sub(c, a)];
  const p = cross(way, v);
  const size = dot(u, p);
  if (Math.abs(size) < 1e-300) return null;
  const s = sub(from, a);
  const q = cross(s, u);
  const [beta, gamma, far] = [dot(s, p) / size, dot(way, q) / size, dot(v, q) / size];
  return beta >= 0 && gamma >= 0 && beta + gamma <= 1 && far > 0 ? far : null;
}
