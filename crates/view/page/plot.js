// Small plots over time.

const SPAN = 20; // s of the clock that are kept
const COLORS = ["#4aa3ff", "#f2a33a", "#58c98b", "#d977c8"];

export class Plots {
  constructor(parent) {
    this.parent = parent;
    this.plots = [];
    this.past = [];
    this.frozen = false;
  }

  // Makes a plot for each list of series: a title, names of the series, unit and their readers.
  make(lists) {
    this.past = [];
    this.parent.replaceChildren();
    this.plots = lists.map(({ title, unit, series }) => {
      const box = document.createElement("div");
      box.className = "plot";
      const canvas = document.createElement("canvas");
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", title);
      const keys = document.createElement("div");
      keys.className = "keys";
      box.append(canvas, keys);
      this.parent.append(box);
      const plot = { canvas, keys, unit, series, at: null };
      canvas.addEventListener("pointermove", (event) => {
        plot.at = event.offsetX / canvas.clientWidth;
        this.draw();
      });
      canvas.addEventListener("pointerleave", () => {
        plot.at = null;
        this.draw();
      });
      return plot;
    });
  }

  push(state) {
    if (this.frozen) return;
    const now = performance.now() / 1000;
    const last = this.past[this.past.length - 1];
    // Back at the start, what was before is of another run.
    if (last && state.time < last.state.time) this.past = [];
    this.past.push({ now, state });
    while (this.past.length > 2 && this.past[0].now < now - SPAN) this.past.shift();
  }

  draw() {
    for (const plot of this.plots) drawPlot(plot, this.past, this.format);
  }
}

function drawPlot(plot, past, format) {
  const { canvas, series, unit } = plot;
  const density = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth * density, canvas.clientHeight * density];
  if (width === 0) return;
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const ink = canvas.getContext("2d");
  ink.clearRect(0, 0, width, height);
  if (past.length < 2) return;
  const values = series.map(({ read }) => past.map(({ state }) => read(state)));
  const all = values.flat().filter(Number.isFinite);
  let [low, high] = [Math.min(0, ...all), Math.max(0, ...all)];
  if (high - low < 1e-300) high = low + 1;
  const style = getComputedStyle(document.documentElement);
  const [first, last] = [past[0].now, past[past.length - 1].now];
  const x = (k) => ((past[k].now - first) / (last - first || 1)) * width;
  const y = (value) => height - 3 - ((value - low) / (high - low)) * (height - 18 * density);
  ink.lineWidth = density;
  ink.strokeStyle = style.getPropertyValue("--line");
  ink.beginPath();
  ink.moveTo(0, y(0));
  ink.lineTo(width, y(0));
  ink.stroke();
  ink.lineWidth = 1.6 * density;
  values.forEach((list, index) => {
    ink.strokeStyle = COLORS[index];
    ink.beginPath();
    list.forEach((value, k) => Number.isFinite(value) && ink.lineTo(x(k), y(value)));
    ink.stroke();
  });
  const read = plot.at === null ? past.length - 1 : nearest(past, first + plot.at * (last - first));
  if (plot.at !== null) {
    ink.strokeStyle = style.getPropertyValue("--soft");
    ink.lineWidth = density;
    ink.beginPath();
    ink.moveTo(x(read), 0);
    ink.lineTo(x(read), height);
    ink.stroke();
  }
  ink.fillStyle = style.getPropertyValue("--soft");
  ink.font = `${11 * density}px system-ui, sans-serif`;
  ink.fillText(format(high, unit), 2, 11 * density);
  const time = format(past[read].state.time, "s");
  ink.fillText(time, width - ink.measureText(time).width - 2, 11 * density);
  if (plot.keys.childElementCount !== series.length) {
    plot.keys.replaceChildren(...series.map(({ name }, index) => {
      const key = document.createElement("span");
      key.innerHTML = "<i></i><b></b>";
      key.firstChild.style.background = COLORS[index];
      key.dataset.name = name;
      return key;
    }));
  }
  series.forEach(({ name }, index) => {
    plot.keys.children[index].lastChild.textContent =
      `${name} ${format(values[index][read], unit)}`;
  });
}

function nearest(past, now) {
  let best = 0;
  past.forEach(({ now: at }, k) => {
    if (Math.abs(at - now) < Math.abs(past[best].now - now)) best = k;
  });
  return best;
}
