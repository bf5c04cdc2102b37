// All words of the page, in English and German.

const WORDS = {
  en: {
    gallery: "Gallery", language: "DE – Deutsch", theme: "Dark or light", help: "Keys and hands",
    panel: "Show or hide the panel", picture: "Picture: drag to turn, arrow keys too",
    readings: "Numbers", plots: "Plots", looks: "Looks", knobs: "Sliders", notes: "Notes",
    freeze: "Freeze", colorBy: "Colors", thickness: "Thickness ×", shadows: "Shadows",
    surfaces: "Surfaces", showContacts: "Contacts and forces", showField: "Electric field lines",
    volumes: "Bounding volumes", volumesNone: "none", volumes0: "of segments",
    volumes1: "of 16 segments", volumes2: "of 256 segments", volumes8: "of everything",
    trace: "Picture", traceHint: "A picture by paths of light from here (T)", over: "Over each other",
    tracing: "{done} of {samples} samples", traced: "{done} samples", tracedAlt: "Picture by paths of light",
    longestArrow: "Longest arrow: {force}", fiber_charge: "Charge of a fibre", second: "Time of the second",
    part_surfaces: "surfaces", part_pores: "pores", part_pre_guides: "pre-guides",
    part_guides: "guides", part_hairs: "hairs", part_moving_apart: "fibres are moved apart",
    part_settling: "fibres settle, step {done} of at most {most}", run: "Run (space)", pause: "Pause (space)", step: "One step (.)",
    restart: "Back to the start (R)", speed: "Speed", frame: "Frame", tools: "Tools",
    toolView: "Turn the view (V)", toolHand: "Pull nodes (H)", toolPin: "Fix or release nodes (P)",
    fit: "Show all (F)", mode: "Next variant", save: "Save scene", close: "Close",
    fitColors: "Fit colors to the values of now", takeControls: "Take the controls",
    time: "Time", steps: "Steps", dt: "Step size", measured: "Speed reached", lag: "Behind by",
    step_ms: "Time for a step", iterations: "Newton iterations", halvings: "Halvings",
    kinetic: "Kinetic energy", elastic: "Elastic energy", gravitational: "Height energy",
    total: "Total energy", contacts: "Contacts", unresolved: "Unresolved", residual: "Residual",
    points: "Points", error: "Positions to", pages: "Pages", energies: "Energies", frames: "Frames",
    own: "as hair", strain: "strain", curvature: "curvature", tension: "tension",
    speedOf: "speed", contact: "contact force", charge: "charge", fiber: "fibre",
    frequency: "Natural frequency f0", damping: "Damping ratio", drag: "Drag δ",
    substeps: "Sub-steps I", area_control: "Area control τ", gravity: "Gravity",
    wind_x: "Wind x", wind_y: "Wind y", wind_z: "Wind z", gust_period: "Period of gusts",
    friction: "Friction", restitution: "Restitution", damping_time: "Damping time",
    humidity: "Humidity", temperature: "Temperature",
    area: "area A", "area at rest": "area A0", volume: "volume V", "volume at rest": "volume V0",
    rope: "Ropes", net: "Nets", body: "Bodies", round: "Ring and ball", fibers: "Fibres",
    contactKind: "Fibres in contact", chargeKind: "Charged fibres",
    leftOut: "What else ships", needs_files: "Scenes with files beside them: rapunzel new NAME, then rapunzel view",
    grows: "Scenes whose hair grows first: rapunzel new NAME, then rapunzel view",
    is_style: "Styles, which grow for a while: rapunzel new NAME, then rapunzel view",
    is_case: "Cases, which do not move: rapunzel new NAME, then rapunzel solve",
    connecting: "The program is not there. Waiting for it …", building: "Building",
    watching: "Another page has the controls", wind: "Wind",
    saved: "Saved: {file}\nRun it: rapunzel run {file}",
    exact: "The run repeats what happened here bit by bit.",
    bent: "Sliders were moved after the start: the scene begins with their values of now.",
    failed: "It stands still: {message}\nGo back to the start, or change a slider first.",
    cannot: "This cannot be shown:", line: "line {line}",
    noWebgl: "This browser has no WebGL2. The program draws the picture instead: smaller and slower.",
    handHelp: "With the hand, a node follows the pointer on a spring of bounded force. Press K while "
      + "pulling to keep pulling after you let go; Escape ends it. Fixed nodes are moved instead, "
      + "and objects whose motion is given are dragged.",
    keys: {
      "Space": "run or pause", ".": "one step", "R": "back to the start", "F": "show all",
      "1 … 6": "from the front, right, back, left, top, below", "V H P": "turn, pull, fix",
      "K": "keep pulling", "T": "picture by paths of light", "O": "two runs over each other", "Esc": "let go", "C": "next color", "M": "next variant",
      "+ −": "faster, slower", "S": "save the scene", "G": "gallery", "B": "panel", "?": "this sheet",
      "← ↑ → ↓": "turn; with Shift move", "Wheel": "nearer, farther",
    },
  },
  de: {
    gallery: "Galerie", language: "EN – English", theme: "Dunkel oder hell", help: "Tasten und Hände",
    panel: "Leiste zeigen oder verbergen", picture: "Bild: ziehen dreht, Pfeiltasten auch",
    readings: "Zahlen", plots: "Kurven", looks: "Aussehen", knobs: "Regler", notes: "Hinweise",
    freeze: "Anhalten", colorBy: "Farben", thickness: "Dicke ×", shadows: "Schatten",
    surfaces: "Flächen", showContacts: "Kontakte und Kräfte", showField: "Elektrische Feldlinien",
    volumes: "Hüllkörper", volumesNone: "keine", volumes0: "der Segmente",
    volumes1: "von 16 Segmenten", volumes2: "von 256 Segmenten", volumes8: "von allem",
    trace: "Bild", traceHint: "Ein Bild aus Lichtwegen von hier aus (T)", over: "Übereinander",
    tracing: "{done} von {samples} Proben", traced: "{done} Proben", tracedAlt: "Bild aus Lichtwegen",
    longestArrow: "Längster Pfeil: {force}", fiber_charge: "Ladung einer Faser", second: "Zeit des zweiten",
    part_surfaces: "Flächen", part_pores: "Poren", part_pre_guides: "Vorläufer von Leithaaren",
    part_guides: "Leithaare", part_hairs: "Haare", part_moving_apart: "Fasern werden getrennt",
    part_settling: "Fasern setzen sich, Schritt {done} von höchstens {most}", run: "Start (Leertaste)", pause: "Pause (Leertaste)",
    step: "Ein Schritt (.)", restart: "Zurück zum Anfang (R)", speed: "Tempo", frame: "Bild",
    tools: "Werkzeuge", toolView: "Ansicht drehen (V)", toolHand: "Knoten ziehen (H)",
    toolPin: "Knoten fixieren oder lösen (P)", fit: "Alles zeigen (F)", mode: "Nächste Variante",
    save: "Szene sichern", close: "Schließen", fitColors: "Farben an die Werte von jetzt anpassen",
    takeControls: "Bedienung übernehmen",
    time: "Zeit", steps: "Schritte", dt: "Schrittweite", measured: "Erreichtes Tempo",
    lag: "Rückstand", step_ms: "Dauer eines Schritts", iterations: "Newton-Iterationen",
    halvings: "Halbierungen", kinetic: "Kinetische Energie", elastic: "Elastische Energie",
    gravitational: "Lageenergie", total: "Gesamtenergie", contacts: "Kontakte",
    unresolved: "Ungelöst", residual: "Residuum", points: "Punkte", error: "Orte auf",
    pages: "Seiten", energies: "Energien", frames: "Bilder",
    own: "wie Haar", strain: "Dehnung", curvature: "Krümmung", tension: "Zugkraft",
    speedOf: "Geschwindigkeit", contact: "Kontaktkraft", charge: "Ladung", fiber: "Faser",
    frequency: "Eigenfrequenz f0", damping: "Dämpfungsgrad", drag: "Dämpfung δ",
    substeps: "Teilschritte I", area_control: "Flächenregelung τ", gravity: "Gravitation",
    wind_x: "Wind x", wind_y: "Wind y", wind_z: "Wind z", gust_period: "Periode der Böen",
    friction: "Reibung", restitution: "Stoßzahl", damping_time: "Dämpfungszeit",
    humidity: "Luftfeuchte", temperature: "Temperatur",
    load: "Lasten", dissipation: "Dämpfungsleistung", supports: "Leistung der Lager",
    "wind x": "Wind x jetzt", "wind y": "Wind y jetzt", "wind z": "Wind z jetzt",
    area: "Fläche A", "area at rest": "Fläche A0", volume: "Volumen V",
    "volume at rest": "Volumen V0",
    "work of friction": "Arbeit der Reibung", "work of closing": "Arbeit der Stöße",
    "work of gap repair": "Arbeit der Lückenschließung",
    "work of restitution": "Arbeit der Rückstöße", "work of adhesion": "Arbeit der Haftung",
    "work of compliance": "Arbeit der Nachgiebigkeit",
    "work of led objects": "Arbeit geführter Körper", "work of gravity": "Arbeit der Schwerkraft",
    "work of loads": "Arbeit der Lasten und Hände", "work of drag": "Arbeit der Luft",
    "work of damping": "Arbeit der Dämpfung", "work of supports": "Arbeit der Lager",
    "work of the integrator": "Arbeit des Zeitschritts", "work of the solver": "Arbeit des Lösers",
    rope: "Seile", net: "Netze", body: "Körper", round: "Ring und Kugel", fibers: "Fasern",
    contactKind: "Fasern in Kontakt", chargeKind: "Geladene Fasern",
    leftOut: "Was noch dabei ist", needs_files: "Szenen mit Dateien: rapunzel new NAME, dann rapunzel view",
    grows: "Szenen, deren Haar erst wächst: rapunzel new NAME, dann rapunzel view",
    is_style: "Frisuren, die eine Weile wachsen: rapunzel new NAME, dann rapunzel view",
    is_case: "Fälle, die sich nicht bewegen: rapunzel new NAME, dann rapunzel solve",
    connecting: "Das Programm ist nicht da. Warten …", building: "Wird aufgebaut",
    watching: "Eine andere Seite bedient", wind: "Wind",
    saved: "Gesichert: {file}\nAusführen: rapunzel run {file}",
    exact: "Der Lauf wiederholt das Geschehene Bit für Bit.",
    bent: "Regler wurden nach dem Anfang bewegt: Die Szene beginnt mit ihren Werten von jetzt.",
    failed: "Es steht still: {message}\nZurück zum Anfang, oder erst einen Regler ändern.",
    cannot: "Das kann nicht gezeigt werden:", line: "Zeile {line}",
    noWebgl: "Dieser Browser hat kein WebGL2. Das Programm zeichnet das Bild: kleiner und langsamer.",
    handHelp: "Mit der Hand folgt ein Knoten dem Zeiger an einer Feder mit begrenzter Kraft. K beim "
      + "Ziehen zieht nach dem Loslassen weiter; Escape beendet es. Fixierte Knoten werden "
      + "bewegt, und Körper mit vorgegebener Bewegung gezogen.",
    keys: {
      "Leertaste": "Start oder Pause", ".": "ein Schritt", "R": "zurück zum Anfang",
      "F": "alles zeigen", "1 … 6": "von vorn, rechts, hinten, links, oben, unten",
      "V H P": "drehen, ziehen, fixieren", "K": "weiterziehen", "T": "Bild aus Lichtwegen", "O": "zwei Läufe übereinander", "Esc": "loslassen",
      "C": "nächste Farbe", "M": "nächste Variante", "+ −": "schneller, langsamer",
      "S": "Szene sichern", "G": "Galerie", "B": "Leiste", "?": "dieses Blatt",
      "← ↑ → ↓": "drehen; mit Umschalt schieben", "Rad": "näher, ferner",
    },
  },
};

let language = "en";

export function setLanguage(name) {
  language = WORDS[name] ? name : "en";
  document.documentElement.lang = language;
  for (const element of document.querySelectorAll("[data-text]")) {
    element.textContent = word(element.dataset.text);
  }
  for (const element of document.querySelectorAll("[data-hint]")) element.title = word(element.dataset.hint);
  for (const element of document.querySelectorAll("[data-alt]")) element.alt = word(element.dataset.alt);
  for (const element of document.querySelectorAll("[data-label]")) {
    element.title = word(element.dataset.label);
    element.setAttribute("aria-label", element.title);
  }
}

export const languageNow = () => language;

// A word, with values put in for names in braces.
export function word(name, values = {}) {
  const text = WORDS[language][name] ?? name;
  if (typeof text !== "string") return text;
  return text.replace(/\{(\w+)\}/g, (_, key) => values[key] ?? "");
}

// A number in a few digits, with a prefix of its unit.
export function quantity(x, unit = "") {
  if (x === null || x === undefined || !Number.isFinite(x)) return "–";
  const prefixes = ["p", "n", "µ", "m", "", "k", "M", "G"];
  const plain = unit === "" || unit === "°C" || unit.startsWith("1/") || /[²³]/.test(unit);
  const size = Math.abs(x);
  if (plain || size === 0 || size < 1e-12) {
    const text = size !== 0 && (size < 1e-3 || size >= 1e6) ? x.toExponential(2) : digits(x);
    return unit ? `${text} ${unit}` : text;
  }
  const power = Math.min(7, Math.max(0, Math.floor(Math.log10(size) / 3 + 1e-9) + 4));
  return `${digits(x / 1000 ** (power - 4))} ${prefixes[power]}${unit}`;
}

function digits(x) {
  const size = Math.abs(x);
  if (x === 0) return "0";
  const after = size >= 100 || Number.isInteger(x) ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3;
  return x.toLocaleString(language, { maximumFractionDigits: after, useGrouping: false });
}
