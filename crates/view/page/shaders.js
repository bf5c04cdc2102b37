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

const PLACES = `
uniform vec3 uOrigin;
uniform float uUnit;
uniform mat4 uClip;
vec3 place(vec4 q) { return uOrigin + uUnit * q.xyz; }
`;

const FIBER_IN = `
layout(location = 0) in vec4 aBefore;
layout(location = 1) in vec4 aFrom;
layout(location = 2) in vec4 aTo;
layout(location = 3) in vec4 aAfter;
layout(location = 4) in float aRadiusFrom;
layout(location = 5) in float aRadiusTo;
layout(location = 6) in vec4 aColorFrom; // and in w: 1 for the first point of a strand, 2 the last
layout(location = 7) in vec4 aColorTo;
const vec4 NOWHERE = vec4(2., 2., 2., 1.);
`;

// A segment is a ribbon that faces the eye; neighbors share their edge.
const fiber = {
  vertex: `${HEAD}${PLACES}${FIBER_IN}
uniform vec3 uEye;
uniform float uPixel;
uniform float uThickness;
uniform float uThinnest;
out vec3 vPlace, vTangent, vSide, vColor;
out float vAcross, vValue, vCover;
void main() {
  if (aColorFrom.w >= 2.) { gl_Position = NOWHERE; return; }
  bool end = gl_VertexID >= 2;
  float across = (gl_VertexID & 1) == 0 ? -1. : 1.;
  vec3 from = place(aFrom), to = place(aTo);
  bool first = mod(aColorFrom.w, 2.) == 1., last = aColorTo.w >= 2.;
  vec3 before = first ? from : place(aBefore), after = last ? to : place(aAfter);
  vec3 here = end ? to : from;
  vec3 along = end ? after - from : to - before;
  vec3 tangent = normalize(dot(along, along) > 0. ? along : to - from + vec3(1e-12, 0., 0.));
  vec3 look = uEye - here;
  float far = length(look);
  vec3 side = cross(tangent, look / far);
  float long_ = length(side);
  side = long_ > 1e-4 ? side / long_ : vec3(1., 0., 0.);
  float pixel = far * uPixel, radius = (end ? aRadiusTo : aRadiusFrom) * uThickness;
  float half_ = max(radius, uThinnest * pixel);
  vCover = clamp(radius / half_, .45, 1.);
  vPlace = here; vTangent = tangent; vSide = side; vAcross = across;
  vColor = (end ? aColorTo : aColorFrom).rgb / 255.;
  vValue = (end ? aTo.w : aFrom.w) / 65535.;
  gl_Position = uClip * vec4(here + side * across * half_, 1.);
}`,
  fragment: `${HEAD}${COLORS}${LIGHT}
uniform vec3 uEye;
uniform float uRoundness;
in vec3 vPlace, vTangent, vSide, vColor;
in float vAcross, vValue, vCover;
out vec4 oColor;
void main() {
  vec3 t = normalize(vTangent), v = normalize(uEye - vPlace);
  vec3 side = normalize(vSide), up = normalize(cross(side, t));
  up *= sign(dot(up, v) + 1e-9);
  vec3 n = normalize(side * vAcross + up * sqrt(max(0., 1. - vAcross * vAcross)));
  vec3 own = colored(vColor, vValue);
  vec3 color = own * own;
  vec3 h = normalize(uLight + v);
  float tl = dot(t, uLight), th = dot(t, h), shift = dot(t + .18 * n, h);
  float sine = sqrt(max(0., 1. - tl * tl)), facing = max(dot(n, uLight), 0.);
  float diffuse = mix(.85 * sine, facing, uRoundness);
  float shine = pow(max(0., sqrt(max(0., 1. - th * th))), 90.);
  float glow = pow(max(0., sqrt(max(0., 1. - shift * shift))), 24.);
  float shadow = lit(vPlace);
  float gloss = uColoring == 0 ? 1. : .35;
  vec3 sum = color * (.30 + .85 * diffuse * shadow)
    + shadow * gloss * (.16 * shine * vec3(1.) + .55 * glow * color);
  oColor = vec4(sqrt(sum), vCover);
}`,
};

const fiberShadow = {
  vertex: `${HEAD}${PLACES}${FIBER_IN}
void main() {
  vec4 clip = uClip * vec4(place(gl_VertexID == 0 ? aFrom : aTo), 1.);
  gl_Position = aColorFrom.w >= 2. ? NOWHERE : clip;
}`,
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
  vertex: `${HEAD}${PLACES}
layout(location = 1) in vec4 aFrom;
out vec3 vPlace;
out float vValue;
void main() {
  vPlace = place(aFrom); vValue = aFrom.w / 65535.;
  gl_Position = uClip * vec4(vPlace, 1.);
}`,
  fragment: `${HEAD}${COLORS}${LIGHT}
uniform vec3 uEye, uOwn;
in vec3 vPlace;
in float vValue;
out vec4 oColor;
void main() {
  vec3 v = normalize(uEye - vPlace), n = normalize(cross(dFdx(vPlace), dFdy(vPlace)));
  n *= sign(dot(n, v) + 1e-9);
  vec3 own = colored(uOwn, vValue);
  float light = .4 + .6 * max(dot(n, uLight), 0.) * lit(vPlace);
  oColor = vec4(sqrt(own * own * light), .5);
}`,
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

export const programs = { fiber, fiberShadow, mesh, cloth, mark };
