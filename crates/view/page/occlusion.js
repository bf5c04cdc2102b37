// How much hair is around: a coarse grid by which hair that lies deep is darker.

// Cells along each side of the grid. Those at its rim are empty.
const SIDE = 32;

export class Occlusion {
  constructor(gl, unit) {
    Object.assign(this, { gl, unit, isOld: true, thickness: 0, low: [0, 0, 0], cell: 1 });
    [this.depths, this.other, this.open] = [0, 1, 2].map(() => new Float32Array(SIDE ** 3));
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
  }

  // Finds for every cell how much light from all around reaches it.
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
        const [x, y, z] = [points[at], points[at + 1], points[at + 2]];
        const [u, v, w] = [x - points[from], y - points[from + 1], z - points[from + 2]];
        const cell = (2 + (x * perCell | 0))
          + SIDE * ((2 + (y * perCell | 0)) + SIDE * (2 + (z * perCell | 0)));
        depths[cell] += radii[point] * Math.sqrt(u * u + v * v + w * w);
      }
    }
    // Optical depths: the shadow of all hair in a cell over its face.
    const scale = (2 * thickness * step) / (this.cell * this.cell);
    for (let k = 0; k < depths.length; k++) depths[k] *= scale;
    this.smooth();
    this.look();
    gl.activeTexture(gl.TEXTURE0 + this.unit);
    gl.bindTexture(gl.TEXTURE_3D, this.texture);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, SIDE, SIDE, SIDE, gl.RED, gl.FLOAT, this.open);
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

  // The mean of what comes through along the six directions of the axes. From below less comes.
  look() {
    const { depths, open } = this;
    open.fill(0);
    [1, SIDE, SIDE * SIDE].forEach((step, axis) => {
      const [a, b] = [[SIDE, SIDE * SIDE], [1, SIDE * SIDE], [1, SIDE]][axis];
      const [up, down] = axis === 2 ? [0.24, 0.12] : [0.16, 0.16];
      for (let i = 0; i < SIDE; i++) {
        for (let j = 0; j < SIDE; j++) {
          const first = i * a + j * b;
          let whole = 0;
          for (let k = 0; k < SIDE; k++) whole += depths[first + k * step];
          let below = 0;
          for (let k = 0; k < SIDE; k++) {
            const cell = first + k * step;
            const own = depths[cell];
            // Most cells are empty, and light goes by them all.
            if (own > 0) {
              const middle = below + 0.5 * own;
              open[cell] += down * Math.exp(-middle) + up * Math.exp(middle - whole);
            } else {
              open[cell] += down + up;
            }
            below += own;
          }
        }
      }
    });
  }

  // What the texture holds.
  around() {
    return { cells: this.open, side: SIDE, cell: this.cell };
  }

  uniforms(isOn, target) {
    return {
      uDensityLow: this.low.map((x, k) => x - target[k]),
      uDensityCell: isOn ? this.cell : 0,
      uDensitySide: SIDE,
    };
  }
}
