// Buttons, sliders and choices.

import { quantity, word } from "./words.js";

const $ = (id) => document.getElementById(id);
const SPEEDS = [0.01, 0.03, 0.1, 0.25, 0.5, 1, 2, 5, 10];
export const COLORS = ["own", "strain", "curvature", "tension", "speed", "contact", "charge", "fiber"];
export const UNITS = {
  strain: "", curvature: "1/m", tension: "N", speed: "m/s", contact: "N", charge: "C",
};

export const colorName = (color) => word(color === "speed" ? "speedOf" : color);

// The rows of speeds and colors, in the words of now.
export function fillChoices(colors) {
  const option = (value, text) => {
    const element = document.createElement("option");
    [element.value, element.textContent] = [value, text];
    return element;
  };
  const keep = [$("speed").value || "1", $("color").value || "own"];
  $("speed").replaceChildren(...SPEEDS.map((speed) => option(speed, `${quantity(speed)} ×`)));
  $("color").replaceChildren(...colors.map((color) => option(color, colorName(color))));
  [$("speed").value, $("color").value] = keep;
  if (!$("color").value) $("color").value = "own";
}

export function faster(by) {
  const at = SPEEDS.indexOf(Number($("speed").value));
  $("speed").value = SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, at + by))];
  $("speed").dispatchEvent(new Event("change"));
}

// A slider for each number of the scene that can be changed.
export function makeKnobs(knobs, set) {
  $("knobs-section").hidden = knobs.length === 0;
  $("knobs").replaceChildren(...knobs.map((knob) => makeKnob(knob, set)));
}

function makeKnob(knob, set) {
  const { low, high, by_factors: byFactors } = knob;
  const label = document.createElement("label");
  label.className = "knob";
  label.dataset.knob = knob.name;
  const name = document.createElement("span");
  name.textContent = word(knob.name);
  const value = document.createElement("span");
  value.className = "value";
  const field = document.createElement("input");
  Object.assign(field, { type: "number", min: low, max: high, step: "any" });
  field.setAttribute("aria-label", `${word(knob.name)} (${knob.unit || "1"})`);
  const unit = document.createElement("span");
  unit.className = "unit";
  unit.textContent = knob.unit;
  value.append(field, unit);
  const range = document.createElement("input");
  Object.assign(range, { type: "range", min: 0, max: 1000, step: 1 });
  range.setAttribute("aria-label", word(knob.name));
  const place = (x) => 1000 * (byFactors
    ? Math.log(x / low) / Math.log(high / low)
    : (x - low) / (high - low));
  const at = (p) => (byFactors
    ? low * (high / low) ** (p / 1000)
    : low + ((high - low) * p) / 1000);
  const tidy = (x) => Number(x.toPrecision(3));
  const show = (x) => {
    range.value = place(x);
    range.setAttribute("aria-valuetext", quantity(x, knob.unit));
    if (document.activeElement !== field) field.value = Number(x.toPrecision(6));
  };
  range.addEventListener("input", () => {
    const x = tidy(at(Number(range.value)));
    label.dataset.moved = performance.now();
    field.value = x;
    set(knob.name, x);
  });
  field.addEventListener("change", () => {
    const x = Math.min(high, Math.max(low, Number(field.value)));
    if (Number.isFinite(x)) set(knob.name, x);
  });
  label.show = show;
  show(knob.value);
  label.append(name, value, range);
  return label;
}

// Shows the values that the program has, but for sliders that are being moved.
export function showValues(values) {
  for (const label of $("knobs").children) {
    const x = values[label.dataset.knob];
    const still = performance.now() - (Number(label.dataset.moved) || -1e9) > 800;
    if (x !== undefined && still) label.show(x);
  }
}

// The wind and where it blows, seen from the front.
export function showWind(wind) {
  $("rose").hidden = !wind;
  if (!wind) return;
  const strength = Math.hypot(...wind);
  const [x, z] = [wind[0], wind[2] + (Math.hypot(wind[0], wind[2]) < 1e-6 ? wind[1] : 0)];
  const length = Math.hypot(x, z) || 1;
  const reach = 30 * Math.min(1, strength / 10);
  const tip = [(x / length) * reach, (-z / length) * reach];
  const wing = (turn) => {
    const angle = Math.atan2(tip[1], tip[0]) + turn;
    return `${tip[0] - 8 * Math.cos(angle)} ${tip[1] - 8 * Math.sin(angle)}`;
  };
  const arrow = `M${-tip[0]} ${-tip[1]}L${tip}M${wing(0.5)}L${tip}L${wing(-0.5)}`;
  $("needle").setAttribute("d", strength > 0.01 ? arrow : "");
  $("rose-text").textContent = `${word("wind")} ${quantity(strength, "m/s")}`;
}
