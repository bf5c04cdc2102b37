// Textures with a texel for each point, in rows of 2048, which shaders know too.

const ROW = 2048;

export class PointTextures {
  constructor(gl) {
    Object.assign(this, { gl, count: 0, textures: {} });
  }

  // Makes one for a unit, in place of the one before.
  make(unit, format) {
    const { gl, textures } = this;
    gl.deleteTexture(textures[unit] ?? null);
    textures[unit] = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, textures[unit]);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, ROW, Math.max(1, Math.ceil(this.count / ROW)));
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
      gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
    }
    gl.activeTexture(gl.TEXTURE0);
  }

  // Fills whole rows, then the rest; `each` numbers for a point.
  fill(unit, [format, type], numbers, each) {
    const { gl, count } = this;
    gl.activeTexture(gl.TEXTURE0 + unit);
    const [rows, rest] = [Math.floor(count / ROW), count % ROW];
    const put = (row, width, height) => {
      if (width * height === 0) return;
      const part = numbers.subarray(each * row * ROW);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, row, width, height, format, type, part);
    };
    put(0, ROW, rows);
    put(rows, rest, 1);
    gl.activeTexture(gl.TEXTURE0);
  }
}
