// Pictures by paths of light from the present camera, drawn by the program and coming in pass by
// pass; and a painter for browsers without WebGL2, which shows nothing else.

import { FIELD } from "./camera.js";
import { add, norm, scale, sub } from "./matrix.js";
import { word } from "./words.js";

// Samples of a pixel of a picture, and of one that stands in for WebGL2, and its width.
const SAMPLES = 256;
const FEW = 8;
const NARROW = 480;

export class Traced {
  // Pictures are shown in `image`, and how far they are in `badge`; `send` sends orders.
  constructor(image, badge, send) {
    Object.assign(this, { image, badge, send, number: 0, isOn: false, done: 0, waits: false });
  }

  // Asks for a picture of `width` and `height` in place of the one before.
  ask(camera, [width, height], thickness, samples = SAMPLES) {
    this.number++;
    Object.assign(this, { isOn: true, done: 0, waits: true, seen: view(camera) });
    this.badge.hidden = false;
    this.badge.textContent = word("tracing", { done: 0, samples });
    const aspect = width / height;
    this.send({
      do: "picture", number: this.number, eye: camera.eye(), target: camera.target,
      field: 2 * Math.atan(Math.tan(FIELD / 2) * aspect),
      size: [Math.max(1, Math.round(width)), Math.max(1, Math.round(height))], samples,
      thickness, plain: samples < SAMPLES,
    });
  }

  // Shows a pass, if it is still wanted.
  show({ number, done, samples, png }) {
    if (!this.isOn || number !== this.number) return;
    const before = this.image.src;
    this.image.src = URL.createObjectURL(png);
    if (before.startsWith("blob:")) URL.revokeObjectURL(before);
    this.image.hidden = false;
    Object.assign(this, { done, waits: false });
    this.badge.textContent = word(done < samples ? "tracing" : "traced", { done, samples });
  }

  end() {
    if (!this.isOn) return;
    this.isOn = this.waits = false;
    this.image.hidden = this.badge.hidden = true;
    this.send({ do: "end_picture" });
  }

  // Nothing comes of what was asked for last.
  fail() {
    this.waits = false;
  }

  // A picture is of the camera for which it was asked.
  follow(camera) {
    if (this.isOn && view(camera) !== this.seen) this.end();
  }
}

const view = (camera) => [...camera.eye(), ...camera.target].map((x) => x.toPrecision(9)).join();

// Has what the page asks of a painter; its pictures are small, and follow as fast as they are drawn.
export class PlainPainter {
  constructor(canvas, traced) {
    Object.assign(this, { canvas, traced, isPlain: true, frame: null, objects: [], wanted: false });
  }

  setLayout(layout) {
    this.layout = layout;
    this.frame = null;
  }

  setFrame(frame) {
    if (!this.layout || frame.layout !== this.layout.number) return false;
    this.wanted ||= this.frame?.number !== frame.number || !this.frame;
    this.frame = frame;
    return true;
  }

  place(point) {
    const { points, origin, unit: step } = this.frame;
    return origin.map((x, k) => x + step * points[4 * point + k]);
  }

  box() {
    const { count } = this.frame;
    let [low, high] = count > 0 ? [this.place(0), this.place(0)] : [[-1, -1, -1], [1, 1, 1]];
    for (let point = 1; point < count; point++) {
      const at = this.place(point);
      low = low.map((x, k) => Math.min(x, at[k]));
      high = high.map((x, k) => Math.max(x, at[k]));
    }
    // What lies in one place has a size still.
    if (norm(sub(high, low)) === 0) high = add(low, scale([1, 1, 1], 1e-3));
    return [low, high];
  }

  draw(camera, { thickness }) {
    const { traced, canvas } = this;
    if (!this.frame || traced.waits) return;
    if (!this.wanted && traced.isOn && view(camera) === traced.seen) return;
    this.wanted = false;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const part = Math.min(1, NARROW / width);
    traced.ask(camera, [part * width, part * height], thickness, FEW);
  }
}
