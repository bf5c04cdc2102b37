// Pointers on the picture: they turn, move and zoom the view, or pull and fix nodes.

// A node is taken that is nearer than this, in pixels: to a mouse, and to a finger.
const NEAR = { mouse: 16, pen: 20, touch: 34 };

export class Hand {
  // `page` gives the camera, the painter, the tool and what may be done, and takes orders.
  constructor(canvas, page) {
    this.canvas = canvas;
    this.page = page;
    this.pointers = new Map();
    this.held = null;
    this.keeps = false;
    const on = (name, act) => canvas.addEventListener(name, act.bind(this), { passive: false });
    on("pointerdown", this.down);
    on("pointermove", this.move);
    on("pointerup", this.up);
    on("pointercancel", this.up);
    on("wheel", this.wheel);
    on("contextmenu", (event) => event.preventDefault());
    on("dblclick", () => page.fit());
  }

  at(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  down(event) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    const [x, y] = this.at(event);
    this.pointers.set(event.pointerId, { x, y, button: event.button });
    if (this.pointers.size > 1) {
      this.drop();
      return;
    }
    const tool = event.button === 0 && !event.shiftKey ? this.page.tool(event) : "view";
    if (tool === "view") return;
    const point = this.pick(x, y, NEAR[event.pointerType] ?? NEAR.mouse);
    if (point === null) {
      if (tool === "hand") this.takeObject(x, y);
      return;
    }
    if (tool === "hand") this.take(point, x, y);
    else this.page.fix(point);
  }

  // The point of a strand that is nearest to pixels, and among near ones the one in front.
  pick(x, y, near) {
    const { camera, painter } = this.page;
    if (!painter?.frame) return null;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    let best = null;
    let least = Infinity;
    for (let point = 0; point < painter.frame.count; point++) {
      const [px, py, depth] = camera.project(painter.place(point), width, height);
      const off = Math.hypot(px - x, py - y);
      if (depth <= 0 || off > near) continue;
      const cost = off + (8 * (depth - camera.distance)) / camera.size;
      if (cost < least) [best, least] = [point, cost];
    }
    return best;
  }

  take(point, x, y) {
    const { camera, painter } = this.page;
    const place = painter.place(point);
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const to = camera.unproject(x, y, width, height, place);
    this.keeps = false;
    this.held = { point, to, depth: place };
    this.page.take(point, to);
  }

  // An object whose motion is given is dragged along the picture.
  takeObject(x, y) {
    const found = this.page.findObject(x, y);
    if (!found) return;
    this.keeps = false;
    this.held = { object: found.object, to: found.place, depth: found.place };
    this.page.takeObject(found.object, found.place);
  }

  move(event) {
    const before = this.pointers.get(event.pointerId);
    const [x, y] = this.at(event);
    if (!before) {
      const looks = event.pointerType === "mouse" && this.page.tool(event) !== "view";
      this.page.hover(looks && (this.pick(x, y, NEAR.mouse) !== null || Boolean(this.page.findObject(x, y))));
      return;
    }
    const [dx, dy] = [x - before.x, y - before.y];
    this.pointers.set(event.pointerId, { ...before, x, y });
    const { camera } = this.page;
    if (this.pointers.size === 2) {
      this.pinch(event.pointerId, before, { x, y });
    } else if (this.held && !this.keeps) {
      const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
      this.held.to = camera.unproject(x, y, width, height, this.held.depth);
      this.page.lead(this.held.to);
    } else if (before.button !== 0 || event.shiftKey) {
      camera.pan(dx, dy, this.canvas.clientHeight);
    } else if (this.page.turns(event)) {
      camera.turn(dx, dy);
    }
    this.page.redraw();
  }

  // Two fingers move and zoom.
  pinch(id, before, now) {
    const [[, other]] = [...this.pointers].filter(([key]) => key !== id);
    const span = (p) => Math.hypot(p.x - other.x, p.y - other.y) || 1;
    const { camera } = this.page;
    camera.zoom(span(before) / span(now));
    camera.pan((now.x - before.x) / 2, (now.y - before.y) / 2, this.canvas.clientHeight);
  }

  up(event) {
    this.pointers.delete(event.pointerId);
    if (this.held && !this.keeps) this.drop();
    this.page.redraw();
  }

  // Goes on pulling without the pointer.
  keep() {
    if (this.held) this.keeps = true;
  }

  drop() {
    if (!this.held) return;
    this.held = null;
    this.keeps = false;
    this.page.drop();
  }

  wheel(event) {
    event.preventDefault();
    this.page.camera.zoom(Math.exp(Math.sign(event.deltaY) * Math.min(0.25, Math.abs(event.deltaY) * 0.0015)));
    this.page.redraw();
  }
}
