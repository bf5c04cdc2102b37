// What is shown on demand: contacts with their forces, bounding volumes, field lines.

import { add, cross, norm, scale, sub, unit } from "./matrix.js";

const CONTACT = [0.93, 0.16, 0.12];
const FORCE = [0.98, 0.62, 0.1];
const FIELD = [0.25, 0.6, 0.98];
// The longest arrow over the size of all.
const LONGEST = 0.12;

export function drawOverlays(painter, common, from, look) {
  const { gl, frame } = painter;
  const { pushes, boxes, lines } = frame;
  if (boxes.length > 0) drawBoxes(painter, common, from, look);
  const list = [];
  const put = (place, color) => list.push(...sub(place, from), ...color, 1);
  let at = 0;
  for (const count of lines.counts) {
    const point = (k) => lines.points.subarray(3 * (at + k), 3 * (at + k) + 3);
    for (let k = 1; k < count; k++) [k - 1, k].forEach((end) => put(point(end), FIELD));
    // An arrow in the middle tells where the field goes.
    if (count > 4) {
      const k = count >> 1;
      const size = 1.5 * norm(sub(point(k), point(k - 1)));
      arrowHead(point(k), unit(sub(point(k + 1), point(k - 1))), size, (end) => put(end, FIELD));
    }
    at += count;
  }
  const dots = [];
  const [low, high] = painter.box();
  const longest = LONGEST * norm(sub(high, low));
  const force = (k) => pushes.subarray(6 * k + 3, 6 * k + 6);
  const contacts = pushes.length / 6;
  for (let k = 0; k < contacts; k++) painter.mostForce = Math.max(painter.mostForce, norm(force(k)));
  for (let k = 0; k < contacts; k++) {
    const place = pushes.subarray(6 * k, 6 * k + 3);
    dots.push(...sub(place, from), ...CONTACT, 1);
    const way = scale(force(k), longest / (painter.mostForce || 1));
    const length = norm(way);
    if (length < 1e-3 * longest) continue;
    const end = add(place, way);
    put(place, FORCE);
    put(end, FORCE);
    arrowHead(end, unit(way), 0.25 * length, (corner) => put(corner, FORCE));
  }
  // What lies within the hair is seen too.
  if (contacts > 0) gl.disable(gl.DEPTH_TEST);
  painter.drawList(common, list, gl.LINES, 1);
  painter.drawList(common, dots, gl.POINTS, 4.5 * look.density);
  gl.enable(gl.DEPTH_TEST);
}

function arrowHead(end, along, size, put) {
  const side = unit(cross(along, Math.abs(along[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  for (const turn of [0.4, -0.4]) {
    put(end);
    put(add(end, add(scale(along, -size), scale(side, turn * size))));
  }
}

// The twelve edges of each box.
function drawBoxes(painter, common, from, look) {
  const { gl, frame } = painter;
  if (!painter.boxing) {
    painter.boxing = gl.createVertexArray();
    painter.boxes = gl.createBuffer();
    gl.bindVertexArray(painter.boxing);
    gl.bindBuffer(gl.ARRAY_BUFFER, painter.boxes);
    for (const k of [0, 1]) {
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 24, 12 * k);
      gl.vertexAttribDivisor(k, 1);
      gl.enableVertexAttribArray(k);
    }
    gl.bindVertexArray(null);
  }
  painter.use("box", { uClip: common.uClip, uFrom: from, uOwn: look.box });
  gl.bindVertexArray(painter.boxing);
  gl.bindBuffer(gl.ARRAY_BUFFER, painter.boxes);
  gl.bufferData(gl.ARRAY_BUFFER, frame.boxes, gl.STREAM_DRAW);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  gl.drawArraysInstanced(gl.LINES, 0, 24, frame.boxes.length / 6);
  gl.disable(gl.BLEND);
  gl.bindVertexArray(null);
}
