// How fibres, surfaces and marks are drawn.

const HEAD = `#version 300 es
precision highp float;
precision highp int;
`;

// Colors in [0, 1]: viridis for a scale, far hues for numbers of fibres.
const COLORS = `
uniform int uColoring;
uniform vec2 uRange;
vec3 viridis(float t) {
  const vec3 c[9] = vec3[9](
    vec3(68., 1., 84.), vec3(71., 44., 122.), vec3(59., 81., 139.), vec3(44., 113., 142.),
    vec3(33., 144., 141.), vec3(39., 173., 129.), vec3(92., 200., 99.), vec3(170., 220., 50.),
    vec3(253., 231., 37.));
  float s = clamp(t, 0., 1.) * 8.;
  int k = min(int(s), 7);
  return mix(c[k], c[k + 1], s - float(k)) / 255.;
}
vec3 hue(float turn) {
  return .5 + .4 * cos(6.2831853 * (turn - vec3(0., 1. / 3., 2. / 3.)));
}
vec3 colored(vec3 own, float value) {
  if (uColoring == 0) return own;
  if (uColoring == 1) return viridis(value);
  return hue(fract(mix(uRange.x, uRange.y, value) * .61803399));
}
`;

const LIGHT = `
uniform vec3 uLight;
uniform mat4 uShadowClip;
uniform highp sampler2D uShadow;
uniform vec3 uShadowLook; // whether there is one, depth of its box, length in which light fades
float lit(vec3 place) {
  if (uShadowLook.x == 0.) return 1.;
  vec3 s = (uShadowClip * vec4(place, 1.)).xyz * .5 + .5;
  float texel = 1. / float(textureSize(uShadow, 0).x), sum = 0.;
  for (int k = 0; k < 4; k++) {
    vec2 at = s.xy + texel * (vec2(k & 1, k >> 1) * 2. - 1.);
    float behind = (s.z - texture(uShadow, at).r) * uShadowLook.y - .12 * uShadowLook.z;
    sum += exp(-max(behind, 0.) / uShadowLook.z);
  }
  return mix(.28, 1., .25 * sum);
}
`;

// The same without a shadow. Without a graphics card a pixel pays for all that its program could
// do.
const BRIGHT = `
uniform vec3 uLight;
float lit(vec3 place) { return 1.; }
`;

// Light from all around, as far as hair lets it through.
const OPEN = `
uniform highp sampler3D uDensity;
uniform vec3 uDensityLow;
uniform float uDensityCell, uDensitySide;
float open(vec3 place) {
  if (uDensityCell == 0.) return 1.;
  vec3 at = (place - uDensityLow) / (uDensityCell * uDensitySide);
  return mix(.12, 1., textureLod(uDensity, at, 0.).r);
}
`;

// Points lie in textures, so that every vertex can look at its neighbors.
const PLACES = `
uniform highp usampler2D uPoints; // place in units, and value
uniform vec3 uOrigin;
uniform float uUnit;
uniform mat4 uClip;
ivec2 texel(int point) { return ivec2(point & 2047, point >> 11); }
vec3 place(int point) { return uOrigin + uUnit * vec3(texelFetch(uPoints, texel(point), 0).xyz); }
float value(int point) { return float(texelFetch(uPoints, texel(point), 0).w) / 65535.; }
`;

// Light on a fibre with a tangent, as seen on the side with a normal.
const SHADE = `
uniform vec3 uEye;
uniform float uRoundness;
vec3 shade(vec3 place, vec3 t, vec3 n, vec3 own) {
  vec3 color = own * own;
  vec3 h = normalize(uLight + normalize(uEye - place));
  float tl = dot(t, uLight), th = dot(t, h), shift = dot(t + .18 * n, h);
  float sine = sqrt(max(0., 1. - tl * tl)), facing = max(dot(n, uLight), 0.);
  float diffuse = mix(.85 * sine, facing, uRoundness);
  float shine = pow(max(0., sqrt(max(0., 1. - th * th))), 90.);
  float glow = pow(max(0., sqrt(max(0., 1. - shift * shift))), 24.);
  float shadow = lit(place);
  float gloss = uColoring == 0 ? 1. : .35;
  float around = open(place);
  vec3 sum = color * (.34 * around + .85 * diffuse * shadow * mix(.55, 1., around))
    + shadow * gloss * (.07 * shine * vec3(1.) + .9 * glow * color);
  return sqrt(sum);
}
`;

// A strand is a ribbon that faces the eye, with two vertices for each point.
const RIBBON = `${PLACES}
uniform highp usampler2D uColors; // and in w: 1 for the first point of a strand, 2 for the last
uniform highp sampler2D uRadii;
uniform float uPixel;
uniform float uThickness;
uniform float uThinnest;
struct Vertex { vec3 place, tangent, side, color; float across, value; };
Vertex ribbon(vec3 eye) {
  int point = gl_VertexID >> 1;
  float across = (gl_VertexID & 1) == 0 ? -1. : 1.;
  uvec4 own = texelFetch(uColors, texel(point), 0);
  vec3 here = place(point);
  vec3 before = (own.w & 1u) != 0u ? here : place(point - 1);
  vec3 after = (own.w & 2u) != 0u ? here : place(point + 1);
  vec3 along = after - before;
  vec3 tangent = dot(along, along) > 0. ? normalize(along) : vec3(0., 0., 1.);
  vec3 look = eye - here;
  float far = length(look);
  vec3 side = cross(tangent, look / far);
  float sine = length(side);
  side = sine > 1e-4 ? side / sine : vec3(1., 0., 0.);
  float radius = texelFetch(uRadii, texel(point), 0).r * uThickness;
  float half_ = max(radius, uThinnest * far * uPixel);
  gl_Position = uClip * vec4(here + side * across * half_, 1.);
  return Vertex(here, tangent, side, vec3(own.rgb) / 255., across, value(point));
}
`;

// Fibres that are seen from close by are lit at every pixel, as round.
const fiber = {
  vertex: `${HEAD}uniform vec3 uEye;${COLORS}${RIBBON}
out vec3 vPlace, vTangent, vSide, vColor;
out float vAcross;
void main() {
  Vertex v = ribbon(uEye);
  vPlace = v.place; vTangent = v.tangent; vSide = v.side; vColor = colored(v.color, v.value);
  vAcross = v.across;
}`,
  fragment: `${HEAD}uniform int uColoring;${LIGHT}
float open(vec3 place) { return 1.; } // they are few
${SHADE}
in vec3 vPlace, vTangent, vSide, vColor;
in float vAcross;
out vec4 oColor;
void main() {
  vec3 t = normalize(vTangent), side = normalize(vSide), up = normalize(cross(side, t));
  up *= sign(dot(up, uEye - vPlace) + 1e-9);
  vec3 n = normalize(side * vAcross + up * sqrt(max(0., 1. - vAcross * vAcross)));
  oColor = vec4(shade(vPlace, t, n, vColor), 1.);
}`,
};

// Hair is about a pixel wide, and lit at its points.
const hair = {
  vertex: `${HEAD}${COLORS}${LIGHT}${OPEN}${SHADE}${RIBBON}
out vec3 vColor;
void main() {
  Vertex v = ribbon(uEye);
  vec3 up = normalize(cross(v.side, v.tangent));
  up *= sign(dot(up, uEye - v.place) + 1e-9);
  vec3 n = normalize(.5 * v.across * v.side + up);
  vColor = shade(v.place, v.tangent, n, colored(v.color, v.value));
}`,
  fragment: `${HEAD}in vec3 vColor; out vec4 oColor; void main() { oColor = vec4(vColor, 1.); }`,
};

const fiberShadow = {
  vertex: `${HEAD}${PLACES}
void main() { gl_Position = uClip * vec4(place(gl_VertexID), 1.); }`,
  fragment: `${HEAD}out vec4 oColor; void main() { oColor = vec4(1.); }`,
};

const mesh = {
  vertex: `${HEAD}
layout(location = 0) in vec3 aPlace;
layout(location = 1) in vec3 aNormal;
uniform mat4 uPose, uClip;
out vec3 vPlace, vNormal;
void main() {
  vec4 at = uPose * vec4(aPlace, 1.);
  vPlace = at.xyz; vNormal = mat3(uPose) * aNormal;
  gl_Position = uClip * at;
}`,
  fragment: `${HEAD}${LIGHT}
uniform vec3 uEye, uOwn;
in vec3 vPlace, vNormal;
out vec4 oColor;
void main() {
  vec3 v = normalize(uEye - vPlace), n = normalize(vNormal);
  n *= sign(dot(n, v) + 1e-9);
  float rim = pow(1. - max(dot(n, v), 0.), 3.);
  float light = .34 + .66 * max(dot(n, uLight), 0.) * lit(vPlace);
  oColor = vec4(sqrt(uOwn * uOwn * light + .04 * rim), 1.);
}`,
};

// Faces of nets and bodies, whose corners are points of strands.
const cloth = {
  vertex: `${HEAD}${COLORS}${PLACES}
uniform vec3 uOwn;
out vec3 vPlace, vColor;
void main() {
  vPlace = place(gl_VertexID); vColor = colored(uOwn, value(gl_VertexID));
  gl_Position = uClip * vec4(vPlace, 1.);
}`,
  fragment: `${HEAD}${LIGHT}
uniform vec3 uEye;
in vec3 vPlace, vColor;
out vec4 oColor;
void main() {
  vec3 n = normalize(cross(dFdx(vPlace), dFdy(vPlace)));
  n *= sign(dot(n, uEye - vPlace) + 1e-9);
  float light = .4 + .6 * max(dot(n, uLight), 0.) * lit(vPlace);
  oColor = vec4(vColor * sqrt(light), .5);
}`,
};

// Edges of boxes between two corners.
const box = {
  vertex: `${HEAD}
layout(location = 0) in vec3 aLow;
layout(location = 1) in vec3 aHigh;
uniform mat4 uClip;
uniform vec3 uFrom;
void main() {
  int edge = gl_VertexID >> 1, axis = edge >> 2, k = edge & 3;
  bvec3 up;
  up[axis] = (gl_VertexID & 1) == 1;
  up[(axis + 1) % 3] = (k & 1) == 1;
  up[(axis + 2) % 3] = (k & 2) == 2;
  gl_Position = uClip * vec4(mix(aLow, aHigh, vec3(up)) - uFrom, 1.);
}`,
  fragment: `${HEAD}uniform vec3 uOwn; out vec4 oColor; void main() { oColor = vec4(uOwn, .55); }`,
};

const mark = {
  vertex: `${HEAD}
layout(location = 0) in vec3 aPlace;
layout(location = 1) in vec4 aColor;
uniform mat4 uClip;
uniform float uSize;
out vec4 vColor;
void main() {
  vColor = aColor;
  gl_Position = uClip * vec4(aPlace, 1.);
  gl_Position.z -= .0005 * gl_Position.w;
  gl_PointSize = uSize;
}`,
  fragment: `${HEAD}
uniform float uRound;
in vec4 vColor;
out vec4 oColor;
void main() {
  float r = uRound * 2. * length(gl_PointCoord - .5);
  if (r > 1.) discard;
  oColor = vec4(r > .72 ? vec3(1.) - .25 * vColor.rgb : vColor.rgb, vColor.a);
}`,
};

// The programs, and those of them that know of shadows without these.
export const programs = { box, fiber, fiberShadow, hair, mesh, cloth, mark };
const bright = (text) => text.replace(LIGHT, BRIGHT);
for (const [name, { vertex, fragment }] of Object.entries({ fiber, hair, mesh, cloth })) {
  programs[`${name}Bright`] = { vertex: bright(vertex), fragment: bright(fragment) };
}
