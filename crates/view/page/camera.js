// A camera that looks at a place and goes around it; z is up.

import { add, cross, dot, multiply, perspective, scale, sub, view } from "./matrix.js";

// Angle between the lower and the upper edge of the picture.
export const FIELD = (30 * Math.PI) / 180;

export class Camera {
  constructor() {
    this.target = [0, 0, 0];
    this.distance = 1;
    this.azimuth = 0.35;
    this.elevation = 0.15;
    this.size = 1;
  }

  // Looks at all of a box from where it looks now.
  fit(low, high, aspect) {
    const middle = scale(add(low, high), 0.5);
    const sides = sub(high, low);
    this.size = Math.max(...sides, 1e-4);
    const { right, up, back } = this.axes();
    const half = (axis) => 0.5 * axis.reduce((sum, x, k) => sum + Math.abs(x) * sides[k], 0);
    const tangent = Math.tan(FIELD / 2);
    const needed = Math.max(half(up) / tangent, half(right) / (tangent * aspect));
    this.target = middle;
    this.distance = 1.12 * Math.max(needed, 0.02 * this.size) + half(back);
  }

  axes() {
    const [a, e] = [this.azimuth, this.elevation];
    const back = [Math.sin(a) * Math.cos(e), -Math.cos(a) * Math.cos(e), Math.sin(e)];
    const right = [Math.cos(a), Math.sin(a), 0];
    return { right, back, up: cross(back, right) };
  }

  eye() {
    return add(this.target, scale(this.axes().back, this.distance));
  }

  turn(dx, dy) {
    this.azimuth -= dx * 0.008;
    this.elevation = Math.min(1.55, Math.max(-1.55, this.elevation + dy * 0.008));
  }

  // Length of a pixel at the target.
  pixel(height) {
    return (2 * Math.tan(FIELD / 2) * this.distance) / height;
  }

  pan(dx, dy, height) {
    const { right, up } = this.axes();
    const step = this.pixel(height);
    this.target = add(this.target, add(scale(right, -dx * step), scale(up, dy * step)));
  }

  zoom(factor) {
    const farthest = 100 * this.size;
    this.distance = Math.min(farthest, Math.max(0.005 * this.size, this.distance * factor));
  }

  // Matrices for a picture, of places relative to the target.
  matrices(aspect) {
    const axes = this.axes();
    const eye = scale(axes.back, this.distance);
    const near = Math.max(0.01 * this.distance, this.distance - 8 * this.size);
    const projection = perspective(FIELD, aspect, near, this.distance + 40 * this.size);
    const clip = multiply(projection, view(axes.right, axes.up, axes.back, eye));
    return { clip, eye, axes, tangent: Math.tan(FIELD / 2) };
  }

  // Pixels of a place, and how far in front of the eye it is.
  project(place, width, height) {
    const { right, up, back } = this.axes();
    const from = sub(place, this.target);
    const depth = this.distance - dot(from, back);
    const unitLength = height / (2 * Math.tan(FIELD / 2) * depth);
    return [width / 2 + dot(from, right) * unitLength, height / 2 - dot(from, up) * unitLength, depth];
  }

  // The place at pixels that is as deep as another place.
  unproject(x, y, width, height, like) {
    const { right, up, back } = this.axes();
    const depth = this.distance - dot(sub(like, this.target), back);
    const step = (2 * Math.tan(FIELD / 2) * depth) / height;
    const across = add(scale(right, (x - width / 2) * step), scale(up, (height / 2 - y) * step));
    return add(add(this.target, across), scale(back, this.distance - depth));
  }

  // From one of the six sides: front, right, back, left, top or below.
  look(side) {
    const quarter = Math.PI / 2;
    const sides = {
      front: [0, 0], right: [quarter, 0], back: [2 * quarter, 0],
      left: [-quarter, 0], top: [0, 1.55], below: [0, -1.55],
    };
    [this.azimuth, this.elevation] = sides[side];
  }
}

