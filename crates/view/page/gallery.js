// The gallery of scenes that ship.

import { word } from "./words.js";

const KINDS = ["rope", "net", "body", "round", "fibers", "contact", "charge"];
const names = { contact: "contactKind", charge: "chargeKind" };

// `scenes` by their kinds, and after them what else ships, with why it is not here.
export function showGallery(parent, scenes, leftOut, open) {
  parent.replaceChildren();
  for (const kind of KINDS) {
    const own = scenes.filter((scene) => scene.kind === kind);
    if (own.length === 0) continue;
    const title = document.createElement("h2");
    title.textContent = word(names[kind] ?? kind);
    const cards = document.createElement("div");
    cards.className = "cards";
    cards.append(...own.map((scene) => card(scene, open)));
    parent.append(title, cards);
  }
  if (leftOut.length > 0) parent.append(others(leftOut));
}

function others(leftOut) {
  const part = document.createElement("section");
  const title = document.createElement("h2");
  title.textContent = word("leftOut");
  const list = document.createElement("dl");
  for (const why of new Set(leftOut.map((one) => one.why))) {
    const [term, detail] = [document.createElement("dt"), document.createElement("dd")];
    term.textContent = word(why);
    detail.textContent = leftOut.filter((one) => one.why === why).map((one) => one.name).join(", ");
    list.append(term, detail);
  }
  part.append(title, list);
  return part;
}

function card(scene, open) {
  const button = document.createElement("button");
  button.className = "card";
  button.dataset.name = scene.name;
  const picture = document.createElement("img");
  Object.assign(picture, { loading: "lazy", alt: "", src: `picture/${scene.name}` });
  const text = document.createElement("span");
  text.textContent = scene.title || scene.name;
  const name = document.createElement("small");
  name.textContent = scene.name;
  text.append(name);
  button.append(picture, text);
  button.addEventListener("click", () => open(scene.name));
  return button;
}
