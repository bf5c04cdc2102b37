// What the program says of how all stands, put into words and numbers of the page.

import { showValues, showWind } from "./controls.js";
import { fillRows } from "./readings.js";
import { say } from "./say.js";
import { quantity, word } from "./words.js";

const $ = (id) => document.getElementById(id);
// Without a graphics card texts that change cost more than a rope: so long, ms, they may wait, but
// for what buttons and messages say.
const PATIENCE = 700;

export class Teller {
  // Tells the state of `page`, and in `charts` how it was; then `told` is called.
  constructor(page, charts, told) {
    Object.assign(this, { page, charts, told, last: 0 });
  }

  hear(state) {
    const { page } = this;
    const isAlike = pressed(page.state) === pressed(state);
    page.state = { ...state, names: page.about.readings, has_contacts: page.about.has_contacts };
    if (page.about.kind === "live") this.charts.push(page.state);
    const waits = state.runs && isAlike && page.painter.isSlow;
    clearTimeout(this.timer);
    const left = waits ? PATIENCE - (performance.now() - this.last) : 0;
    if (left > 0) this.timer = setTimeout(() => this.tell(), left);
    else this.tell();
  }

  tell() {
    const { page, charts } = this;
    const { state } = page;
    this.last = performance.now();
    $("run").querySelector("use").setAttribute("href", state.runs ? "#i-pause" : "#i-run");
    $("run").toggleAttribute("data-on", Boolean(state.runs));
    $("run").setAttribute("aria-label", word(state.runs ? "pause" : "run"));
    const behind = state.lag > 0.05 ? ` <small>−${quantity(state.lag, "s")}</small>` : "";
    const reached = state.measured ? ` <small>${quantity(state.measured)} ×</small>` : "";
    $("clock").innerHTML = state.time === undefined ? "" : `${quantity(state.time, "s")}${reached}${behind}`;
    if (state.speed && document.activeElement !== $("speed")) $("speed").value = String(state.speed);
    if (state.frames !== undefined) {
      $("slider").max = state.frames - 1;
      if (document.activeElement !== $("slider")) $("slider").value = state.frame;
      $("frame-text").textContent = `${state.frame + 1}/${state.frames}`;
      $("slider-box").hidden = state.frames < 2;
    }
    if (page.about.kind !== "gallery") fillRows($("readings"), state, page.painter.frame);
    if (page.about.kind === "live") {
      charts.draw();
      showValues(state.values ?? {});
    }
    showWind(state.wind);
    if (state.failure && page.failure !== state.failure) {
      say(word("failed", { message: state.failure }), true);
    } else if (!state.failure && page.failure) {
      say("");
    }
    page.failure = state.failure;
    $("over").setAttribute("aria-pressed", String(Boolean(state.over)));
    this.told();
  }
}

// What a button or a message says of a state.
const pressed = ({ runs, failure, frame, speed, over, colored }) => (
  [runs, failure, frame, speed, over, colored].join());
