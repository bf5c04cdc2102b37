// Draws a frame with WebGL2.

import { build, rendererOf } from "./gl.js";
import { shaded } from "./mesh.js";
import { add, multiply, norm, orthographic, pose, scale, sub, unit, view } from "./matrix.js";
import { Lines } from "./lines.js";
import { Occlusion } from "./occlusion.js";
import { drawOverlays } from "./overlays.js";
import { programs } from "./shaders.js";
import { Smooth } from "./smooth.js";
import { PointTextures } from "./textures.js";

const SHADOW = 1024;
// Where textures are bound, and the names by which shaders know them.
const [POINTS, COLORS, RADII, DENSITY, LINES, DEPTHS] = [1, 2, 3, 4, 5, 6];
const UNITS = { uShadow: 0, uPoints: POINTS, uColors: COLORS, uRadii: RADII, uDensity: DENSITY };
// Without a graphics card, hair of more points than these is always drawn in a hurry: a whole
// picture would keep everything waiting for half a second or more.
const MOST_POINTS = 25_000;
// More held roots of fibres than these are not marked.
const MOST_ROOTS = 30;

export class Painter {
  // Throws if the browser has no WebGL2.
  constructor(canvas) {
    this.canvas = canvas;
    // Whole pictures are drawn smooth into a buffer of their own, and those in a hurry need not be.
    const wishes = { antialias: false, alpha: false, powerPreference: "high-performance" };
    const gl = canvas.getContext("webgl2", wishes);
    if (!gl) throw new Error("no WebGL2");
    this.gl = gl;
    this.isSlow = /swiftshader|llvmpipe|softpipe|software|basic render/i.test(rendererOf(gl));
    this.marks = gl.createBuffer();
    this.marking = gl.createVertexArray();
    // What is drawn from textures has indices and no attributes.
    this.ribbons = this.makeIndices();
    this.coarse = this.makeIndices();
    this.lines = this.makeIndices();
    this.cloth = this.makeIndices();
    this.objects = [];
    this.occlusion = new Occlusion(gl, DENSITY);
    this.hairLines = new Lines(gl, [LINES, DEPTHS]);
    Object.assign(this, { smooth: new Smooth(gl), textures: new PointTextures(gl), programs: {} });
    this.makeShadow();
    gl.bindVertexArray(this.marking);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.marks);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 28, 0);
    gl.vertexAttribPointer(1, 4, gl.FLOAT, false, 28, 12);
    [0, 1].forEach((k) => gl.enableVertexAttribArray(k));
    gl.bindVertexArray(null);
  }

  // Whether hair that moves is drawn by the page itself, and hair that stands still too.
  get hurriesMoving() {
    return this.isSlow && this.layout !== undefined && !this.layout.springs;
  }

  get hurriesAlways() {
    return this.hurriesMoving && this.layout.count > MOST_POINTS;
  }

  makeIndices() {
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bindVertexArray(null);
    return { array, count: 0 };
  }

  fillIndices(indices, list) {
    const gl = this.gl;
    gl.bindVertexArray(indices.array);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, list, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    indices.count = list.length;
  }

  drawIndices(mode, indices) {
    const gl = this.gl;
    gl.bindVertexArray(indices.array);
    gl.drawElements(mode, indices.count, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(null);
  }

  makeShadow() {
    const gl = this.gl;
    this.depth = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.depth);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW, SHADOW);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
      gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
    }
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) {
      gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    }
    this.shadow = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadow);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.depth, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  setLayout(layout) {
    const gl = this.gl;
    this.layout = layout;
    [this.mostForce, this.frame] = [0, null];
    const { count, counts, radii, triangles } = layout;
    const colors = new Uint8Array(4 * count);
    const ribbons = new Uint32Array(2 * count + counts.length);
    const coarse = new Uint32Array(ribbons.length);
    const lines = new Uint32Array(count + counts.length);
    let [point, ribbon, few, line] = [0, 0, 0, 0];
    counts.forEach((own, strand) => {
      for (let k = 0; k < own; k++, point++) {
        for (let c = 0; c < 3; c++) colors[4 * point + c] = layout.colors[4 * strand + c];
        colors[4 * point + 3] = (k === 0 ? 1 : 0) + (k === own - 1 ? 2 : 0);
        ribbons[ribbon++] = 2 * point;
        ribbons[ribbon++] = 2 * point + 1;
        // A shadow needs not every point of a hair, and a hurried picture neither.
        if (layout.springs || k % 2 === 0 || k === own - 1) {
          lines[line++] = point;
          coarse[few++] = 2 * point;
          coarse[few++] = 2 * point + 1;
        }
      }
      // The largest number begins anew.
      ribbons[ribbon++] = coarse[few++] = lines[line++] = 0xffffffff;
    });
    this.fillIndices(this.ribbons, ribbons);
    this.fillIndices(this.coarse, coarse.subarray(0, few));
    this.fillIndices(this.lines, lines.subarray(0, line));
    this.fillIndices(this.cloth, triangles);
    const { textures } = this;
    textures.count = count;
    textures.make(POINTS, gl.RGBA16UI);
    textures.make(COLORS, gl.RGBA8UI);
    textures.fill(COLORS, [gl.RGBA_INTEGER, gl.UNSIGNED_BYTE], colors, 4);
    textures.make(RADII, gl.R32F);
    textures.fill(RADII, [gl.RED, gl.FLOAT], radii, 1);
    for (const object of this.objects) {
      gl.deleteBuffer(object.buffer);
      gl.deleteVertexArray(object.array);
    }
    this.objects = layout.objects.map((object) => this.makeObject(object));
  }

  makeObject({ places, corners }) {
    const gl = this.gl;
    const [array, buffer] = [gl.createVertexArray(), gl.createBuffer()];
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, shaded(places, corners), gl.STATIC_DRAW);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 24, 0);
    gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 24, 12);
    [0, 1].forEach((k) => gl.enableVertexAttribArray(k));
    gl.bindVertexArray(null);
    return { array, buffer, count: corners.length, corners: corners8(places) };
  }

  setFrame(frame) {
    if (!this.layout || frame.layout !== this.layout.number) return false;
    const gl = this.gl;
    this.frame = frame;
    this.most = [0, 0, 0];
    for (let k = 0; k < 4 * frame.count; k += 4) {
      for (let axis = 0; axis < 3; axis++) {
        if (frame.points[k + axis] > this.most[axis]) this.most[axis] = frame.points[k + axis];
      }
    }
    this.textures.fill(POINTS, [gl.RGBA_INTEGER, gl.UNSIGNED_SHORT], frame.points, 4);
    this.occlusion.isOld = true;
    return true;
  }

  // Place of a point of the frame, m.
  place(point) {
    const { points, origin, unit: step } = this.frame;
    return origin.map((x, k) => x + step * points[4 * point + k]);
  }

  // The box of all points, and of objects that are not much larger.
  box() {
    const { origin, unit: step, count } = this.frame;
    const low = count > 0 ? [...origin] : [-1, -1, -1];
    const high = count > 0 ? origin.map((x, k) => x + step * this.most[k]) : [1, 1, 1];
    const fibers = Math.max(norm(sub(high, low)), 1e-6);
    this.objects.forEach(({ corners }, index) => {
      const at = this.pose(index, [0, 0, 0]);
      const put = ([x, y, z]) => [0, 1, 2].map((row) => (
        at[12 + row] + at[row] * x + at[4 + row] * y + at[8 + row] * z));
      const all = corners.map(put);
      if (norm(sub(all[0], all[7])) > 2.5 * fibers) return;
      for (const place of all) {
        for (let k = 0; k < 3; k++) {
          low[k] = Math.min(low[k], place[k]);
          high[k] = Math.max(high[k], place[k]);
        }
      }
    });
    return [low, high];
  }

  // The pose of an object, relative to a place.
  pose(index, from) {
    const p = this.frame.poses.subarray(7 * index, 7 * index + 7);
    return pose(sub([p[0], p[1], p[2]], from), [p[3], p[4], p[5], p[6]]);
  }

  // Draws a picture; `look` says how: coloring, thickness, shadows, surfaces, marks, colors, hurry.
  draw(camera, look) {
    const gl = this.gl;
    const { width, height } = this.canvas;
    const target = look.hurried && this.isSlow ? null : this.smooth.of(width, height);
    const begin = () => {
      gl.bindFramebuffer(gl.FRAMEBUFFER, target);
      gl.viewport(0, 0, width, height);
    };
    begin();
    gl.clearColor(...look.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (this.frame) this.drawAll(camera, look, begin);
    if (target) this.smooth.show();
  }

  // `begin` goes on where the picture is drawn.
  drawAll(camera, look, begin) {
    const { gl } = this;
    const { width, height } = this.canvas;
    const seen = camera.matrices(width / height);
    const { right, up, back } = seen.axes;
    const toLight = unit(add(add(scale(right, -0.55), scale(up, 0.9)), scale(back, 0.75)));
    this.isBright = true;
    const shadow = look.shadows && !look.hurried ? this.drawShadow(camera, toLight) : null;
    this.isBright = !shadow;
    const occluded = look.shadows && !this.layout.springs;
    if (occluded) this.occlusion.fill(this.layout, this.frame, this.most, look.thickness);
    const common = {
      uClip: seen.clip, uEye: seen.eye,
      uLight: toLight,
      uOrigin: sub(this.frame.origin, camera.target),
      uUnit: this.frame.unit,
      uShadowClip: shadow?.clip ?? seen.clip,
      uShadowLook: shadow?.look ?? [0, 1, 1],
      ...this.occlusion.uniforms(occluded, camera.target),
      uColoring: look.coloring,
      uRange: [this.frame.low, this.frame.high],
    };
    begin();
    gl.enable(gl.DEPTH_TEST);
    gl.bindTexture(gl.TEXTURE_2D, this.depth);
    this.drawObjects(common, camera.target, look.object);
    const ribbon = {
      uPixel: (2 * seen.tangent) / height,
      uThickness: look.thickness,
      uThinnest: 0.55 * look.density,
      uRoundness: this.layout.springs ? 0.9 : 0.35,
    };
    if (look.hurried && this.hurriesMoving) {
      this.hairLines.draw(this.layout, this.frame, common, ribbon, occluded && this.occlusion);
    } else {
      this.use(this.layout.springs ? "fiber" : "hair", { ...common, ...ribbon });
      this.drawIndices(gl.TRIANGLE_STRIP, look.hurried ? this.coarse : this.ribbons);
    }
    if (look.surfaces && this.layout.triangles.length > 0) this.drawCloth(common, look.cloth);
    drawOverlays(this, common, camera.target, look);
    this.drawMarks(common, camera.target, look);
  }

  drawObjects(common, from, own) {
    const gl = this.gl;
    if (this.objects.length === 0) return;
    this.use("mesh", { ...common, uOwn: own });
    this.objects.forEach(({ array, count }, index) => {
      this.put("mesh", "uPose", this.pose(index, from));
      gl.bindVertexArray(array);
      gl.drawArrays(gl.TRIANGLES, 0, count);
    });
    gl.bindVertexArray(null);
  }

  drawCloth(common, own) {
    const gl = this.gl;
    this.use("cloth", { ...common, uOwn: own });
    [gl.BLEND, gl.POLYGON_OFFSET_FILL].forEach((what) => gl.enable(what));
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    // Springs lie in the cloth, and are to be seen on both of its sides.
    gl.polygonOffset(2, 16);
    this.drawIndices(gl.TRIANGLES, this.cloth);
    gl.depthMask(true);
    [gl.BLEND, gl.POLYGON_OFFSET_FILL].forEach((what) => gl.disable(what));
  }

  // What is fixed, what is held, and the way from there to the hand.
  drawMarks(common, from, look) {
    const gl = this.gl;
    const [dots, lines] = [[], []];
    const put = (list, place, color) => list.push(...sub(place, from), ...color, 1);
    const { springs, supports } = this.layout;
    // Roots of hair are many, and seen to be in the skin.
    const few = springs || supports.length < 2 * MOST_ROOTS;
    for (let k = 0; few && k < supports.length; k += 2) put(dots, this.place(supports[k]), look.fixed);
    for (const { point, to } of look.hands) {
      const place = point === undefined ? to : this.place(point);
      put(dots, place, look.held);
      if (to) [place, to].forEach((end) => put(lines, end, look.held));
    }
    if (look.ground !== null) this.grid(look.ground, (end) => put(lines, end, look.grid));
    this.drawList(common, lines, gl.LINES, 1);
    this.drawList(common, dots, gl.POINTS, (springs ? 11 : 7) * look.density);
  }

  // Dots or lines: place and color, seven numbers for each.
  drawList(common, list, mode, size) {
    const gl = this.gl;
    if (list.length === 0) return;
    this.use("mark", { uClip: common.uClip, uSize: size, uRound: mode === gl.POINTS ? 1 : 0 });
    gl.bindVertexArray(this.marking);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.marks);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(list), gl.STREAM_DRAW);
    gl.drawArrays(mode, 0, list.length / 7);
    gl.bindVertexArray(null);
  }

  // Ends of the lines of a level ground under all that is shown.
  grid(height, put) {
    const [low, high] = this.box();
    const middle = scale(add(low, high), 0.5);
    const half = Math.max(...sub(high, low));
    for (let k = -5; k <= 5; k++) {
      const at = (k / 5) * half;
      for (const [x, y] of [[at, -half], [at, half], [-half, at], [half, at]]) {
        put([middle[0] + x, middle[1] + y, height]);
      }
    }
  }

  // Depths as the light sees them. Light fades behind fibres, so that many look like a volume.
  drawShadow(camera, toLight) {
    const gl = this.gl;
    const [low, high] = this.box();
    const middle = sub(scale(add(low, high), 0.5), camera.target);
    const radius = 0.5 * norm(sub(high, low)) + 1e-6;
    const side = unit([-toLight[1], toLight[0], Math.abs(toLight[2]) > 0.99 ? 1 : 0]);
    const up = [
      toLight[1] * side[2] - toLight[2] * side[1],
      toLight[2] * side[0] - toLight[0] * side[2],
      toLight[0] * side[1] - toLight[1] * side[0],
    ];
    const place = add(middle, scale(toLight, 2 * radius));
    const clip = multiply(orthographic(radius, radius, 3 * radius), view(side, up, toLight, place));
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadow);
    gl.viewport(0, 0, SHADOW, SHADOW);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.bindTexture(gl.TEXTURE_2D, null);
    const dark = { uShadowLook: [0, 1, 1], uLight: toLight, uEye: [0, 0, 0], uShadowClip: clip };
    this.drawObjects({ uClip: clip, ...dark }, camera.target, [0, 0, 0]);
    const origin = sub(this.frame.origin, camera.target);
    this.use("fiberShadow", { uClip: clip, uOrigin: origin, uUnit: this.frame.unit });
    this.drawIndices(gl.LINE_STRIP, this.lines);
    return { clip, look: [1, 2 * radius, 0.09 * radius] };
  }

  // The program of a name, made when it is first used; without shadows the one that knows of none.
  find(name) {
    const own = this.isBright && programs[`${name}Bright`] ? `${name}Bright` : name;
    return (this.programs[own] ??= build(this.gl, programs[own]));
  }

  use(name, values) {
    this.gl.useProgram(this.find(name).program);
    for (const [uniform, unit_] of Object.entries(UNITS)) this.put(name, uniform, unit_);
    for (const [uniform, value] of Object.entries(values)) this.put(name, uniform, value);
  }

  put(name, uniform, value) {
    const gl = this.gl;
    const found = this.find(name).uniforms[uniform];
    if (!found) return;
    const { at, type } = found;
    if (type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(at, false, value);
    else if (type === gl.FLOAT_VEC3) gl.uniform3fv(at, value);
    else if (type === gl.FLOAT_VEC2) gl.uniform2fv(at, value);
    else if (type !== gl.FLOAT) gl.uniform1i(at, value);
    else gl.uniform1f(at, value);
  }
}

// The eight corners of the box of places.
function corners8(places) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let k = 0; k < places.length; k++) {
    low[k % 3] = Math.min(low[k % 3], places[k]);
    high[k % 3] = Math.max(high[k % 3], places[k]);
  }
  const corner = (bits) => [0, 1, 2].map((axis) => ((bits >> axis) & 1 ? high : low)[axis]);
  return [0, 1, 2, 3, 4, 5, 6, 7].map(corner);
}
