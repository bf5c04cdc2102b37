// How much hair is where: a coarse grid by which hair that lies deep is darker.

// Cells along each side of the grid. Those at its rim are empty.
const SIDE = 32;

export class Occlusion {
  constructor(gl, unit) {
    Object.assign(this, { gl, unit, isOld: true, thickness: 0 });
    this.depths = new Float32Array(SIDE ** 3);
    this.other = new Float32Array(SIDE ** 3);
    this.texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_3D, this.texture);
    gl.texStorage3D(gl.TEXTURE_3D, 1, gl.R16F, SIDE, SIDE, SIDE);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
      gl.texParameteri(gl.TEXTURE_3D, side, gl.LINEAR);
    }
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) {
      gl.texParameteri(gl.TEXTURE_3D, side, gl.CLAMP_TO_EDGE);
    }
    gl.activeTexture(gl.TEXTURE0);
    this.low = [0, 0, 0];
    this.cell = 1;
  }

  // Optical depths of the cells: the shadow of all hair in a cell over its face.
  fill(layout, frame, most, thickness) {
    if (!this.isOld && this.thickness === thickness) return;
    Object.assign(this, { isOld: false, thickness });
    const { gl, depths } = this;
    const { points, unit: step, origin, count } = frame;
    depths.fill(0);
    const size = Math.max(...most, 1);
    this.cell = (size * step) / (SIDE - 4);
    this.low = origin.map((x) => x - 2 * this.cell);
    const perCell = (SIDE - 4) / size;
    const { radii, counts } = layout;
    let point = 0;
    for (const own of counts) {
      for (let k = 0; k < own && point < count; k++, point++) {
        const at = 4 * point;
        // The way from the point before is that of this one.
        const from = k === 0 ? at : at - 4;
        const way = Math.hypot(
          points[at] - points[from], points[at + 1] - points[from + 1], points[at + 2] - points[from + 2]);
        const cell = (2 + (points[at] * perCell | 0))
          + SIDE * ((2 + (points[at + 1] * perCell | 0)) + SIDE * (2 + (points[at + 2] * perCell | 0)));
        depths[cell] += radii[point] * way;
      }
    }
    const scale = (2 * thickness * step) / (this.cell * this.cell);
    for (let k = 0; k < depths.length; k++) depths[k] = Math.min(1000, depths[k] * scale);
    this.smooth();
    gl.activeTexture(gl.TEXTURE0 + this.unit);
    gl.bindTexture(gl.TEXTURE_3D, this.texture);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, SIDE, SIDE, SIDE, gl.RED, gl.FLOAT, this.depths);
    gl.activeTexture(gl.TEXTURE0);
  }

  // Means over neighbors along each axis, lest cells are seen.
  smooth() {
    for (const step of [1, SIDE, SIDE * SIDE]) {
      const [from, to] = [this.depths, this.other];
      for (let k = step; k < from.length - step; k++) {
        to[k] = 0.5 * from[k] + 0.25 * (from[k - step] + from[k + step]);
      }
      [this.depths, this.other] = [to, from];
    }
  }

  uniforms(isOn, target) {
    return {
      uDensityLow: this.low.map((x, k) => x - target[k]),
      uDensityCell: isOn ? this.cell : 0,
      uDensitySide: SIDE,
    };
  }
}
