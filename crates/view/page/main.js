// The page: what is shown, and what its parts tell each other.

import { Camera } from "./camera.js";
import { COLORS, UNITS, colorName, faster, fillChoices, makeKnobs } from "./controls.js";
import { showGallery } from "./gallery.js";
import { Hand } from "./hand.js";
import { Hurry } from "./hurry.js";
import { listen } from "./keys.js";
import { Link, address } from "./link.js";
import { lookOf, showRuler } from "./look.js";
import { Painter } from "./painter.js";
import { pickObject } from "./pick.js";
import { Plots } from "./plot.js";
import { plots } from "./readings.js";
import { say, status } from "./say.js";
import { Teller } from "./teller.js";
import { PlainPainter, Traced } from "./traced.js";
import { languageNow, quantity, setLanguage, word } from "./words.js";

const $ = (id) => document.getElementById(id);
const canvas = $("picture");
const SIDES = ["front", "right", "back", "left", "top", "below"];
// After so long, ms, the gallery has its first pictures.
const CALM = 800;
const SIDEWAYS = { azimuth: 0.35, elevation: 0.15 };

// What may be read by tests too.
const page = {
  about: { kind: "none" }, state: {}, mine: false, frames: 0, hurry: new Hurry(),
  camera: new Camera(), tool: "view", isFit: false, stale: true, undrawn: 0,
  // It takes a while to make one: none is made before there is something to draw.
  get painter() { return (painter ??= makePainter()); },
};
window.rapunzel = page;
let painter = null;

page.traced = new Traced($("traced"), $("tracing"), (order) => link.send(order));

function makePainter() {
  try {
    return new Painter(canvas);
  } catch (error) {
    console.warn(error.message);
    return new PlainPainter(canvas, page.traced);
  }
}

const charts = new Plots($("plots"));
charts.format = quantity;
const redraw = () => (page.stale = true);
const teller = new Teller(page, charts, () => {
  showLegend();
  redraw();
});

const link = new Link({
  open: () => status(""),
  closed: () => status(word("connecting"), true),
  controls(text) {
    page.mine = text.mine;
    $("take-controls").hidden = text.mine;
    status(text.mine ? "" : word("watching"));
  },
  about: showAbout,
  layout(layout) {
    page.painter.setLayout(layout);
    page.layout = layout;
  },
  frame(frame) {
    page.frames++;
    if (page.painter.setFrame(frame)) {
      if (!page.isFit) fit();
      showLegend();
      redraw();
      page.undrawn++;
    } else {
      link.send({ do: "drawn", frames: 1 });
    }
  },
  picture: (picture) => page.traced.show(picture),
  state: (state) => teller.hear(state),
  complaint(text) {
    page.traced.fail();
    say(text.message, true);
  },
  saved(text) {
    page.saved = text;
    say(`${word("saved", text)}\n${word(text.exact ? "exact" : "bent")}`);
  },
});

function showAbout(about) {
  const isOther = about.title !== page.about.title || about.kind !== page.about.kind;
  page.about = about;
  document.body.dataset.kind = about.kind;
  $("title").textContent = about.scene || about.title || "Rapunzel";
  document.title = about.title ? `${about.title} – Rapunzel` : "Rapunzel";
  $("to-gallery").hidden = !about.has_gallery || about.kind === "gallery";
  $("gallery").hidden = about.kind !== "gallery";
  if (about.kind === "gallery") {
    // What is looked at next needs a painter, and has a look of its own.
    setTimeout(() => page.painter, CALM);
    $("color").value = "own";
    showGallery($("gallery"), about.scenes, about.left_out, (name) => link.send({ do: "open", name }));
  }
  if (about.kind === "building") {
    const part = about.part ? `: ${word(`part_${about.part}`, about)}` : " …";
    status(word("building") + part);
    return;
  }
  status(page.mine ? "" : word("watching"));
  const isLive = about.kind === "live";
  if (isOther) {
    // What was known is of what was shown before.
    page.state = {};
    page.isFit = false;
    page.traced.end();
    say("");
    page.tool = about.can_hold ? "hand" : "view";
    // Springs hang in a plane, which is seen best from the front.
    Object.assign(page.camera, about.can_hold ? { azimuth: 0, elevation: 0 } : SIDEWAYS);
    charts.make(plots(about));
    if (about.warning) say(about.warning);
  }
  makeKnobs(about.knobs ?? [], (knob, value) => link.send({ do: "set", knob, value }));
  $("slider-box").hidden = about.kind !== "recorded" || about.frames < 2;
  $("run").hidden = $("step").hidden = $("restart").hidden = $("speed-box").hidden =
    !isLive && $("slider-box").hidden;
  $("mode").hidden = !about.has_modes;
  $("save").hidden = !isLive;
  $("over").hidden = !about.two;
  $("plots-section").hidden = !isLive;
  $("trace").hidden = !["live", "recorded"].includes(about.kind) || page.painter.isPlain;
  $("contacts-box").hidden = !about.has_touches && !about.has_pushes;
  $("field-box").hidden = !about.has_charge;
  $("tool-hand").hidden = !about.can_pull && !about.can_drag;
  $("tool-pin").hidden = !about.can_hold;
  $("tools").hidden = !isLive;
  $("notes-section").hidden = !about.notes?.length;
  $("notes").textContent = (about.notes ?? []).join("\n");
  const lacks = {
    charge: isLive && !about.has_charge, contact: isLive && !about.has_contacts,
    strain: about.can_hold, curvature: about.can_hold,
  };
  fillChoices(COLORS.filter((name) => !lacks[name]));
  showTool();
  if (about.kind === "broken") {
    const problems = about.problems.map(({ path, message, line }) => (
      `${line ? `${word("line", { line })}: ` : ""}${path ? `${path}: ` : ""}${message}`));
    say([word("cannot"), ...(problems.length ? problems : [about.message])].join("\n"), true);
  } else if (isOther && !about.warning) {
    say(about.kind !== "gallery" && page.painter.isPlain ? word("noWebgl") : "");
  }
}

function showLegend() {
  const color = $("color").value;
  const { low, high } = painter?.frame ?? { low: 0, high: 0 };
  $("legend").hidden = color === "own" || color === "fiber" || !page.state.colored;
  $("legend-title").textContent = colorName(color);
  $("legend-low").textContent = quantity(low, UNITS[color]);
  $("legend-high").textContent = quantity(high, UNITS[color]);
}

function showTool() {
  for (const name of ["view", "hand", "pin"]) {
    $(`tool-${name}`).setAttribute("aria-checked", String(page.tool === name));
  }
}

function setTool(tool) {
  const may = { view: true, hand: page.about.can_pull || page.about.can_drag, pin: page.about.can_hold };
  if (may[tool]) page.tool = tool;
  showTool();
}

const hand = new Hand(canvas, {
  camera: page.camera,
  get painter() { return page.painter; },
  tool: (event) => (event.ctrlKey && page.tool === "view" ? "hand" : page.tool),
  turns: () => !hand.held || hand.keeps,
  take(point, to) {
    link.send({ do: "take", ...address(page.layout, point), to });
    redraw();
  },
  findObject: (x, y) => (page.about.can_drag
    ? pickObject(page.painter, page.camera, x, y, canvas.clientWidth, canvas.clientHeight) : null),
  takeObject(object, at) {
    link.send({ do: "take_object", object, at });
    redraw();
  },
  lead(to) {
    page.lead = to;
  },
  drop() {
    page.lead = null;
    link.send({ do: "drop" });
    redraw();
  },
  fix(point) {
    const { supports } = page.layout;
    const places = page.painter.place(point).join();
    let fixed = false;
    for (let k = 0; k < supports.length; k += 2) {
      fixed ||= page.painter.place(supports[k]).join() === places;
    }
    link.send({ do: "fix", ...address(page.layout, point), fixed: !fixed });
  },
  hover: (near) => (canvas.style.cursor = near ? "grab" : "default"),
  fit: () => fit(),
  redraw,
});
page.hand = hand;

function fit() {
  if (!painter?.frame) return;
  const [low, high] = page.painter.box();
  if (typeof page.about.ground === "number") low[2] = Math.min(low[2], page.about.ground);
  page.camera.fit(low, high, canvas.clientWidth / canvas.clientHeight);
  page.isFit = true;
  redraw();
}

function toggle() {
  link.send({ do: page.state.runs ? "pause" : "run" });
}

function color(name) {
  link.send({ do: "color", by: name === "own" ? null : name });
  redraw();
}

const dark = () => document.documentElement.dataset.theme === "dark";

function draw(now) {
  requestAnimationFrame(draw);
  if (!painter || page.about.kind === "gallery") return;
  const { hurry } = page;
  if (hurry.begin(now, painter)) redraw();
  if (page.lead) {
    link.send({ do: "move", to: page.lead });
    page.lead = null;
  }
  const whole = Math.min(2, window.devicePixelRatio || 1);
  const size = [canvas.clientWidth, canvas.clientHeight];
  if (page.size !== `${size} ${whole}`) redraw();
  if (!page.stale || size[0] === 0) return;
  page.size = `${size} ${whole}`;
  const hurried = hurry.is(painter);
  // Without a graphics card cloth costs what it covers.
  const density = hurried && painter.isSlow && !painter.hurriesMoving ? 0.5 * whole : whole;
  const [width, height] = size.map((x) => Math.max(1, Math.round(x * density)));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  page.stale = painter.isPlain;
  if (!painter.isPlain) page.traced.follow(page.camera);
  painter.draw(page.camera, { ...lookOf(page, hand.held, dark(), density), hurried });
  showRuler(page.camera, canvas.clientHeight, quantity);
  showForce();
  hurry.end(now, hurried);
  page.drawn = (page.drawn ?? 0) + 1;
  // Of frames that come between two pictures the last is drawn.
  if (page.undrawn > 0) link.send({ do: "drawn", frames: page.undrawn });
  page.undrawn = 0;
}

// How large the force of the longest arrow is.
function showForce() {
  const most = page.painter.frame?.pushes.length > 0 ? page.painter.mostForce : 0;
  $("force").hidden = !most;
  if (most) $("force").textContent = word("longestArrow", { force: quantity(most, "N") });
}

function show() {
  const level = $("volumes").value;
  const isShown = (id) => $(id).checked && !$(`${id}-box`).hidden;
  link.send({
    do: "show", contacts: isShown("contacts"), field: isShown("field"),
    volumes: level === "" ? null : Number(level),
  });
}

const thickness = () => 10 ** Number($("thickness").value);

function trace() {
  if (page.painter.isPlain || !page.painter.frame) return;
  if (page.traced.isOn) page.traced.end();
  else page.traced.ask(page.camera, [canvas.clientWidth, canvas.clientHeight], thickness());
}

function setTheme(name) {
  document.documentElement.dataset.theme = name;
  redraw();
}

function relabel() {
  setLanguage(languageNow());
  $("language").textContent = word("language").slice(0, 2);
  const keys = Object.entries(word("keys")).flatMap(([key, what]) => {
    const [term, detail] = [document.createElement("dt"), document.createElement("dd")];
    [term.textContent, detail.textContent] = [key, what];
    return [term, detail];
  });
  $("shortcuts").replaceChildren(...keys);
  charts.make(plots(page.about));
  if (page.about.kind !== "none") showAbout(page.about);
  if (page.state.time !== undefined) teller.tell();
}

const click = (id, act) => $(id).addEventListener("click", act);
const panel = () => {
  const off = document.body.dataset.panel !== "off";
  document.body.dataset.panel = off ? "off" : "on";
  $("panel-toggle").setAttribute("aria-expanded", String(!off));
};
const gallery = () => page.about.has_gallery && link.send({ do: "gallery" });
const save = () => page.about.kind === "live" && link.send({ do: "save" });
const mode = () => page.about.has_modes && link.send({ do: "mode" });
click("run", toggle);
click("step", () => link.send({ do: "step" }));
click("restart", () => link.send({ do: "restart" }));
click("fit", fit);
click("mode", mode);
click("save", save);
click("to-gallery", gallery);
click("trace", trace);
click("over", () => link.send({ do: "over", over: !page.state.over }));
click("take-controls", () => link.send({ do: "control" }));
click("fit-colors", () => link.send({ do: "fit_colors" }));
click("panel-toggle", panel);
click("help", () => $("sheet").showModal());
click("close-sheet", () => $("sheet").close());
click("theme", () => setTheme(dark() ? "light" : "dark"));
click("language", () => {
  setLanguage(languageNow() === "en" ? "de" : "en");
  relabel();
});
click("freeze", () => {
  charts.frozen = !charts.frozen;
  $("freeze").setAttribute("aria-pressed", String(charts.frozen));
});
for (const name of ["view", "hand", "pin"]) click(`tool-${name}`, () => setTool(name));
$("speed").addEventListener("change", (event) => link.send({ do: "speed", value: Number(event.target.value) }));
$("slider").addEventListener("input", (event) => link.send({ do: "seek", frame: Number(event.target.value) }));
$("color").addEventListener("change", (event) => color(event.target.value));
$("thickness").addEventListener("input", redraw);
for (const name of ["shadows", "surfaces"]) $(name).addEventListener("change", redraw);
for (const name of ["contacts", "volumes", "field"]) $(name).addEventListener("change", show);
click("message", () => say(""));

listen({
  space: toggle, ".": () => link.send({ do: "step" }), r: () => link.send({ do: "restart" }), f: fit,
  v: () => setTool("view"), h: () => setTool("hand"), p: () => setTool("pin"),
  k: () => hand.keep(), t: trace, o: () => $("over").hidden || $("over").click(),
  escape() {
    hand.drop();
    page.traced.end();
  },
  m: mode, s: save, g: gallery, b: panel,
  "?": () => $("sheet").showModal(), "+": () => faster(1), "-": () => faster(-1),
  c() {
    $("color").selectedIndex = ($("color").selectedIndex + 1) % $("color").length;
    color($("color").value);
  },
  turn(dx, dy, moves) {
    if (moves) page.camera.pan(3 * dx, 3 * dy, canvas.clientHeight);
    else page.camera.turn(dx, dy);
    redraw();
  },
  ...Object.fromEntries(SIDES.map((side, k) => [String(k + 1), () => {
    page.camera.look(side);
    fit();
  }])),
});

if (window.innerWidth < 700) panel();
setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
setLanguage(navigator.language.startsWith("de") ? "de" : "en");
relabel();
requestAnimationFrame(draw);
