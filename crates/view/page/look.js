// How the picture looks: colors of its parts in the dark and in the light.

const DARK = {
  background: [0.08, 0.094, 0.118], object: [0.5, 0.55, 0.62], cloth: [0.45, 0.58, 0.75],
  grid: [0.24, 0.28, 0.34], box: [0.55, 0.85, 0.6],
};
const LIGHT = {
  background: [0.933, 0.941, 0.953], object: [0.66, 0.7, 0.76], cloth: [0.5, 0.62, 0.78],
  grid: [0.76, 0.79, 0.83], box: [0.1, 0.45, 0.2],
};
const SUPPORT = [0.93, 0.35, 0.24];
const HELD = [0.1, 0.55, 0.95];

const $ = (id) => document.getElementById(id);

export function lookOf(page, held, isDark, density) {
  const by = $("color").value;
  return {
    ...(isDark ? DARK : LIGHT),
    coloring: by === "own" || !page.state.colored ? 0 : by === "fiber" ? 2 : 1,
    thickness: 10 ** Number($("thickness").value),
    shadows: $("shadows").checked,
    surfaces: $("surfaces").checked,
    fixed: SUPPORT,
    held: HELD,
    hands: held ? [{ point: held.point, to: held.to }] : [],
    ground: page.about.ground ?? null,
    density,
  };
}

// A length of the picture: one, two or five times a power of ten.
export function showRuler(camera, height, format) {
  const pixel = camera.pixel(height);
  const power = 10 ** Math.floor(Math.log10(110 * pixel));
  const length = [5, 2, 1].map((k) => k * power).find((x) => x <= 110 * pixel) ?? power;
  $("ruler").firstElementChild.style.width = `${length / pixel}px`;
  $("ruler").lastElementChild.textContent = format(length, "m");
}
