// Hair as lines that the page draws itself. Where a browser draws without a graphics card, this
// takes a tenth of the time: triangles cost it most, and hair is about a pixel wide.

import { build } from "./gl.js";

// Depth where nothing is.
const NOTHING = 1;
const HEAD = "#version 300 es\nprecision highp float;\n";
const code = {
  vertex: `${HEAD}
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = vec4(4. * corner - 1., 0., 1.);
}`,
  fragment: `${HEAD}
uniform highp sampler2D uLines, uDepths;
out vec4 oColor;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(uDepths, at, 0).r;
  if (depth == 1.) discard;
  gl_FragDepth = depth;
  oColor = vec4(texelFetch(uLines, at, 0).rgb, 1.);
}`,
};
// Viridis in nine colors, as in the shaders.
const VIRIDIS = [
  [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129],
  [92, 200, 99], [170, 220, 50], [253, 231, 37],
];

export class Lines {
  // Colors and depths are textures of two units that nothing else uses.
  constructor(gl, units) {
    Object.assign(this, { gl, units, width: 0, height: 0, count: -1 });
    this.program = build(gl, code);
    this.array = gl.createVertexArray();
  }

  // Draws all strands as `common` and `hair` say to shaders, with light from all around as
  // `occlusion` knows it if it is given.
  draw(layout, frame, common, hair, occlusion) {
    const { gl } = this;
    const [, , width, height] = gl.getParameter(gl.VIEWPORT);
    this.resize(width, height, frame.count);
    this.shade(layout, frame, common, hair, occlusion);
    const [left, right, bottom, top] = this.trace(layout, frame.count);
    if (right <= left || top <= bottom) return;
    gl.useProgram(this.program.program);
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, width);
    [["uLines", this.bytes, gl.RGBA, gl.UNSIGNED_BYTE], ["uDepths", this.depths, gl.RED, gl.FLOAT]]
      .forEach(([name, numbers, format, type], k) => {
        gl.activeTexture(gl.TEXTURE0 + this.units[k]);
        const part = numbers.subarray(4 ** (1 - k) * (width * bottom + left));
        const size = [right - left, top - bottom];
        gl.texSubImage2D(gl.TEXTURE_2D, 0, left, bottom, ...size, format, type, part);
        gl.uniform1i(this.program.uniforms[name].at, this.units[k]);
      });
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindVertexArray(this.array);
    // What is around is of pictures before.
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(left, bottom, right - left, top - bottom);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
    gl.bindVertexArray(null);
  }

  resize(width, height, count) {
    const { gl } = this;
    if (width !== this.width || height !== this.height) {
      Object.assign(this, { width, height });
      this.colors = new Uint32Array(width * height);
      this.bytes = new Uint8Array(this.colors.buffer);
      this.depths = new Float32Array(width * height);
      this.textures?.forEach((texture) => gl.deleteTexture(texture));
      this.textures = [gl.RGBA8, gl.R32F].map((format, k) => {
        const texture = gl.createTexture();
        gl.activeTexture(gl.TEXTURE0 + this.units[k]);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
        for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
          gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
        }
        return texture;
      });
    }
    if (count === this.count) return;
    this.count = count;
    // Pixels, depth and width of every point, and its color.
    [this.x, this.y, this.z, this.wide] = [0, 1, 2, 3].map(() => new Float32Array(count));
    this.color = new Uint32Array(count);
  }

  // Where points are in the picture, and their light, as in the shader of hair.
  shade(layout, frame, common, hair, occlusion) {
    const { x, y, z, wide, color, width, height } = this;
    const { points, unit } = frame;
    const [clip, origin] = [common.uClip, common.uOrigin];
    const [ox, oy, oz] = origin;
    const [ex, ey, ez] = common.uEye;
    const [lx, ly, lz] = common.uLight;
    const { counts, radii } = layout;
    const own = layout.colors;
    const [low, high] = common.uRange;
    const coloring = common.uColoring;
    const glow = coloring === 0 ? 0.9 : 0.9 * 0.35;
    const gloss = coloring === 0 ? 0.07 : 0.07 * 0.35;
    const cells = occlusion && {
      ...occlusion.around(), from: common.uDensityLow,
    };
    let point = 0;
    for (let strand = 0; strand < counts.length; strand++) {
      const [red, green, blue] = [own[4 * strand], own[4 * strand + 1], own[4 * strand + 2]];
      const end = point + counts[strand];
      for (let first = point; point < end; point++) {
        const at = 4 * point;
        const px = ox + unit * points[at];
        const py = oy + unit * points[at + 1];
        const pz = oz + unit * points[at + 2];
        const w = clip[3] * px + clip[7] * py + clip[11] * pz + clip[15];
        x[point] = (0.5 + (0.5 * (clip[0] * px + clip[4] * py + clip[8] * pz + clip[12])) / w) * width;
        y[point] = (0.5 + (0.5 * (clip[1] * px + clip[5] * py + clip[9] * pz + clip[13])) / w) * height;
        // What is not before the eye is as far as nothing.
        z[point] = w > 0 ? 0.5 + (0.5 * (clip[2] * px + clip[6] * py + clip[10] * pz + clip[14])) / w : 2;
        const a = point > first ? at - 4 : at;
        const b = point < end - 1 ? at + 4 : at;
        let tx = points[b] - points[a];
        let ty = points[b + 1] - points[a + 1];
        let tz = points[b + 2] - points[a + 2];
        const along = 1 / (Math.sqrt(tx * tx + ty * ty + tz * tz) || 1);
        tx *= along;
        ty *= along;
        tz *= along;
        let vx = ex - px;
        let vy = ey - py;
        let vz = ez - pz;
        const far = Math.sqrt(vx * vx + vy * vy + vz * vz);
        wide[point] = (2 * radii[point] * hair.uThickness) / (far * hair.uPixel);
        vx /= far;
        vy /= far;
        vz /= far;
        const hx = lx + vx;
        const hy = ly + vy;
        const hz = lz + vz;
        const half = 1 / (Math.sqrt(hx * hx + hy * hy + hz * hz) || 1);
        const tl = tx * lx + ty * ly + tz * lz;
        const th = (tx * hx + ty * hy + tz * hz) * half;
        // The normal is what of the way to the eye is across the fibre.
        const tv = tx * vx + ty * vy + tz * vz;
        const across = Math.sqrt(Math.max(1e-9, 1 - tv * tv));
        const nh = (((vx - tv * tx) * hx + (vy - tv * ty) * hy + (vz - tv * tz) * hz) * half) / across;
        const nl = ((vx - tv * tx) * lx + (vy - tv * ty) * ly + (vz - tv * tz) * lz) / across;
        const shift = th + 0.18 * nh;
        const diffuse = 0.65 * 0.85 * Math.sqrt(Math.max(0, 1 - tl * tl)) + 0.35 * Math.max(0, nl);
        const shine = gloss * power(1 - th * th, 45);
        const warm = glow * power(1 - shift * shift, 12);
        const around = cells ? open(cells, px, py, pz) : 1;
        const light = 0.34 * around + 0.85 * diffuse * (0.55 + 0.45 * around) + warm;
        let r = red;
        let g = green;
        let c = blue;
        if (coloring !== 0) {
          const value = points[at + 3] / 65535;
          [r, g, c] = coloring === 1 ? viridis(value) : hue((low + (high - low) * value) * 0.61803399);
        }
        const white = 65025 * shine;
        color[point] = (byte(c * c * light + white) << 16)
          | (byte(g * g * light + white) << 8) | byte(r * r * light + white);
      }
    }
  }

  // Lines from point to point, nearer ones over farther ones; columns and rows in which they are.
  trace({ counts }, count) {
    const { x, y, z, wide, depths, width, height } = this;
    let left = Infinity;
    let right = -Infinity;
    let bottom = Infinity;
    let top = -Infinity;
    let widest = 1;
    for (let point = 0; point < count; point++) {
      if (z[point] > NOTHING) continue;
      left = Math.min(left, x[point]);
      right = Math.max(right, x[point]);
      bottom = Math.min(bottom, y[point]);
      top = Math.max(top, y[point]);
      widest = Math.max(widest, wide[point]);
    }
    const inside = (at, size) => Math.min(size, Math.max(0, Math.floor(at)));
    const box = [
      inside(left - widest - 1, width), inside(right + widest + 2, width),
      inside(bottom - widest - 1, height), inside(top + widest + 2, height),
    ];
    depths.fill(NOTHING, width * box[2], width * box[3]);
    let point = 0;
    for (const own of counts) {
      const end = Math.min(point + own, count);
      for (point++; point < end; point++) {
        if (z[point - 1] <= NOTHING && z[point] <= NOTHING) this.line(point - 1, point);
      }
    }
    return box;
  }

  line(a, b) {
    const { x, y, z, wide, color, colors, depths, width, height } = this;
    const span = Math.max(1, Math.round(0.5 * (wide[a] + wide[b])));
    if (Math.max(x[a], x[b]) < -span || Math.min(x[a], x[b]) > width + span) return;
    if (Math.max(y[a], y[b]) < -span || Math.min(y[a], y[b]) > height + span) return;
    let dx = x[b] - x[a];
    let dy = y[b] - y[a];
    const longest = Math.max(Math.abs(dx), Math.abs(dy));
    // Of what leads far out of the picture only the part in it.
    let from = 0;
    let to = 1;
    if (longest > width + height) {
      [from, to] = within(x[a], dx, -span, width + span, from, to);
      [from, to] = within(y[a], dy, -span, height + span, from, to);
      if (to <= from) return;
    }
    const steps = Math.max(1, Math.ceil((to - from) * longest));
    const part = (to - from) / steps;
    const steep = Math.abs(dy) > Math.abs(dx);
    const back = 0.5 * (span - 1);
    let px = x[a] + from * dx - (steep ? back : 0);
    let py = y[a] + from * dy - (steep ? 0 : back);
    let pz = z[a] + from * (z[b] - z[a]);
    const c = color[a];
    let [red, green, blue] = [c & 255, (c >> 8) & 255, (c >> 16) & 255];
    const d = color[b];
    const dr = ((d & 255) - red) * part;
    const dg = (((d >> 8) & 255) - green) * part;
    const db = (((d >> 16) & 255) - blue) * part;
    [red, green, blue] = [red + (from / part) * dr, green + (from / part) * dg, blue + (from / part) * db];
    dx *= part;
    dy *= part;
    const dz = (z[b] - z[a]) * part;
    const beside = steep ? 1 : 0;
    for (let k = 0; k < steps; k++) {
      for (let s = 0; s < span; s++) {
        const column = Math.floor(px + s * beside);
        const row = Math.floor(py + s * (1 - beside));
        if (column >= 0 && row >= 0 && column < width && row < height) {
          const pixel = row * width + column;
          if (pz < depths[pixel]) {
            depths[pixel] = pz;
            colors[pixel] = (blue << 16) | (green << 8) | red;
          }
        }
      }
      px += dx;
      py += dy;
      pz += dz;
      red += dr;
      green += dg;
      blue += db;
    }
  }
}

// The part of a way, between 0 and 1, that is between two bounds.
function within(start, way, low, high, from, to) {
  if (way === 0) return [from, to];
  const one = (low - start) / way;
  const other = (high - start) / way;
  return [Math.max(from, Math.min(one, other)), Math.min(to, Math.max(one, other))];
}

const byte = (squared) => Math.min(255, Math.sqrt(squared)) | 0;

// A power of what is in [0, 1], by an exponential that is good near 1, where there is any shine.
const power = (base, exponent) => (base > 0.5 ? Math.exp(exponent * Math.log(base)) : 0);

function viridis(value) {
  const s = 8 * Math.min(1, Math.max(0, value));
  const k = Math.min(7, Math.floor(s));
  return VIRIDIS[k].map((one, c) => one + (VIRIDIS[k + 1][c] - one) * (s - k));
}

const hue = (turn) => [0, 1, 2].map((k) => 255 * (0.5 + 0.4 * Math.cos(2 * Math.PI * (turn - k / 3))));

// How much light from all around comes to a place, in its cell.
function open({ cells, side, cell, from }, x, y, z) {
  const at = (k, of) => Math.min(side - 1, Math.max(0, Math.floor((k - of) / cell)));
  const k = at(x, from[0]) + side * (at(y, from[1]) + side * at(z, from[2]));
  return 0.12 + 0.88 * cells[k];
}
