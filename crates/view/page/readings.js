// The numbers of the panel, and which plots there are.

import { quantity, word } from "./words.js";

// Fills a table with the numbers of a state; what is the same stays, as laying out anew takes time.
export function fillRows(body, state, frame) {
  const list = rows(state, frame);
  while (body.rows.length > list.length) body.deleteRow(-1);
  list.forEach((texts, index) => {
    const row = body.rows[index] ?? body.insertRow();
    texts.forEach((text, column) => {
      const cell = row.cells[column] ?? row.insertCell();
      if (cell.textContent !== String(text)) cell.textContent = text;
    });
  });
}

function rows(state, frame) {
  const seconds = (x) => quantity(x, "s");
  const list = [
    [word("time"), seconds(state.time)],
    [word("steps"), state.steps],
    [word("second"), state.second !== null && state.second !== undefined && seconds(state.second)],
    [word("frame"), state.frame !== undefined && `${state.frame + 1} / ${state.frames}`],
    [word("dt"), state.dt && seconds(state.dt)],
    [word("measured"), state.measured && `${quantity(state.measured)} ×`],
    [word("lag"), state.lag > 0.01 && seconds(state.lag)],
    [word("step_ms"), state.step_ms !== undefined && seconds(state.step_ms / 1000)],
    [word("iterations"), state.iterations],
    [word("halvings"), state.halvings || false],
    [word("kinetic"), energy(state.kinetic)],
    [word("elastic"), energy(state.elastic)],
    [word("gravitational"), energy(state.gravitational)],
    [word("contacts"), state.has_contacts && state.contacts],
    [word("unresolved"), state.has_contacts && state.unresolved],
    [word("residual"), state.has_contacts && quantity(state.residual)],
    ...extra(state),
    [word("points"), frame?.count],
    [word("error"), frame && `± ${quantity(0.5 * frame.unit, "m")}`],
    [word("pages"), state.pages > 1 && state.pages],
  ];
  return list.filter(([, value]) => value !== undefined && value !== false && value !== null);
}

const title = (text) => text.charAt(0).toUpperCase() + text.slice(1);

const energy = (x) => x !== undefined && quantity(x, "J");

// What the stepper itself reads, whose names end with units in brackets.
function extra(state) {
  return (state.names ?? []).map((name, index) => {
    const [, what, unit] = name.match(/^(.*) \((.*)\)$/) ?? [null, name, ""];
    return [title(word(what)), quantity(state.readings?.[index], unit.replace("^2", "²").replace("^3", "³"))];
  });
}

export function plots(about) {
  const read = (name) => (state) => state[name];
  const series = (name) => ({ name: word(name), read: read(name) });
  if (about.kind !== "live") return [];
  const lists = [{
    title: word("energies"), unit: "J",
    series: ["kinetic", "elastic", "gravitational"].map(series),
  }, {
    title: word("step_ms"), unit: "s",
    series: [{ name: word("step_ms"), read: (state) => state.step_ms / 1000 }],
  }];
  if (about.has_contacts) {
    lists.push({ title: word("contacts"), unit: "", series: [series("contacts")] });
    lists.push({ title: word("residual"), unit: "", series: [series("residual")] });
  }
  const area = (about.readings ?? []).findIndex((name) => /^(area|volume) \(/.test(name));
  if (area >= 0) {
    const of = (index) => ({
      name: about.readings[index].replace(/ \(.*/, ""),
      read: (state) => state.readings?.[index],
    });
    lists.push({ title: about.readings[area], unit: "", series: [of(area), of(area + 1)] });
  }
  return lists;
}
