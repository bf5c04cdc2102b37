// The connection to the program: orders out, texts and pictures in.

const HEAD = 80;

export class Link {
  constructor(heard) {
    this.heard = heard;
    this.wait = 250;
    this.connect();
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait = 250;
      this.heard.open();
    };
    socket.onmessage = ({ data }) => this.read(data);
    socket.onclose = () => {
      this.heard.closed();
      setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(4000, 2 * this.wait);
    };
    this.socket = socket;
  }

  send(order) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(order));
  }

  read(data) {
    if (typeof data === "string") {
      const text = JSON.parse(data);
      this.heard[text.is]?.(text);
      return;
    }
    const mark = String.fromCharCode(...new Uint8Array(data, 0, 4));
    if (mark === "RPF1") this.heard.frame(readFrame(data));
    if (mark === "RPP1") this.heard.picture(readPicture(data));
    if (mark === "RPL1") this.heard.layout(readLayout(data));
  }
}

function readFrame(data) {
  const view = new DataView(data);
  const number = (at) => view.getFloat64(at, true);
  const points = view.getUint32(72, true);
  const objects = view.getUint32(76, true);
  return {
    layout: view.getUint32(4, true),
    number: Number(view.getBigUint64(8, true)),
    time: number(16),
    origin: [number(24), number(32), number(40)],
    unit: number(48),
    low: number(56),
    high: number(64),
    count: points,
    points: new Uint16Array(data, HEAD, 4 * points),
    poses: new Float32Array(data, HEAD + 8 * points, 7 * objects),
    ...readExtras(data, view, HEAD + 8 * points + 28 * objects),
  };
}

// Contacts (place and force), boxes (two corners) and lines (their points, one after another).
function readExtras(data, view, start) {
  const [pushes, boxes, lines, points] = [0, 4, 8, 12].map((k) => view.getUint32(start + k, true));
  let at = start + 16;
  const floats = (count) => {
    at += 4 * count;
    return new Float32Array(data, at - 4 * count, count);
  };
  const pushList = floats(6 * pushes);
  const boxList = floats(6 * boxes);
  const counts = new Uint32Array(data, at, lines);
  at += 4 * lines;
  return { pushes: pushList, boxes: boxList, lines: { counts, points: floats(3 * points) } };
}

function readPicture(data) {
  const [number, done, samples] = new Uint32Array(data.slice(4, 16));
  return { number, done, samples, png: new Blob([data.slice(16)], { type: "image/png" }) };
}

function readLayout(data) {
  const words = new Uint32Array(data);
  const floats = new Float32Array(data);
  let at = 8;
  const take = (count) => words.subarray(at, (at += count));
  const [strands, points, triangles, supports, objects] = words.subarray(3, 8);
  const layout = { number: words[1], springs: words[2] === 1, count: points };
  layout.counts = take(strands);
  layout.colors = new Uint8Array(data, 4 * at, 4 * strands);
  at += strands;
  layout.radii = floats.subarray(at, (at += points));
  layout.triangles = take(3 * triangles);
  layout.supports = take(2 * supports);
  layout.objects = [];
  for (let k = 0; k < objects; k++) {
    const [vertices, faces] = take(2);
    const places = floats.subarray(at, (at += 3 * vertices));
    layout.objects.push({ places, corners: take(3 * faces) });
  }
  layout.starts = new Uint32Array(strands);
  for (let k = 1; k < strands; k++) layout.starts[k] = layout.starts[k - 1] + layout.counts[k - 1];
  return layout;
}

// The strand of a point of the frame, and which of its points it is.
export function address({ starts }, point) {
  let [low, high] = [0, starts.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (starts[middle] <= point) low = middle;
    else high = middle - 1;
  }
  return { strand: low, point: point - starts[low] };
}
