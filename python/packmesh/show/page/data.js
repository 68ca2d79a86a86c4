// The data in the page, and how numbers are shown.

const report = JSON.parse(document.getElementById("report").textContent);
const stored = JSON.parse(document.getElementById("cells").textContent);

/** Bytes of base64 text; numbers in it are little-endian. */
function bytesOf(text) {
  const binary = atob(text), bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes.buffer;
}
const floatsOf = (text) => new Float32Array(bytesOf(text));
const wholesOf = (text) => new Uint32Array(bytesOf(text));
const shortsOf = (text) => new Int16Array(bytesOf(text));
const meshOf = (mesh) => ({ vertices: floatsOf(mesh.vertices), triangles: wholesOf(mesh.triangles) });

/** The cells that are drawn: index i is that of the arrays, cells.number(i) that among all cells, from 1 on. */
const cells = (() => {
  const counts = stored.species.map((one) => one.cells), species = [];
  counts.forEach((count, s) => { for (let i = 0; i < count; ++i) species.push(s); });
  const numbers = stored.numbers && wholesOf(stored.numbers);
  const before = [0];
  for (const one of report.species) before.push(before[before.length - 1] + one.placed);
  return {
    count: species.length,
    all: stored.cells,
    species,
    templates: stored.species.map((one) => (one.cells ? meshOf(one) : null)),
    /** Meshes of deformed cells by species: the row of each cell, -1: it has the template; four numbers a vertex. */
    own: stored.species.map(({ own }) => own && { ...own, rows: new Int32Array(bytesOf(own.rows)), vertices: shortsOf(own.vertices) }),
    positions: floatsOf(stored.positions),
    orientations: floatsOf(stored.orientations),
    gaps: stored.gaps && floatsOf(stored.gaps),  // null: not known
    localHematocrits: stored.localHematocrits && floatsOf(stored.localHematocrits),
    forces: stored.forces && floatsOf(stored.forces),  // largest on a vertex
    first: counts.map((_, s) => counts.slice(0, s).reduce((sum, count) => sum + count, 0)),
    /** Vertices of a cell in the frame of its template. */
    verticesOf(i) {
      const s = species[i], own = this.own[s], row = own ? own.rows[i - this.first[s]] : -1, { vertices } = this.templates[s];
      if (row < 0) return vertices;
      const size = vertices.length / 3, made = new Float32Array(vertices.length);
      for (let v = 0; v < size; ++v) for (let k = 0; k < 3; ++k) made[3 * v + k] = own.scale * own.vertices[4 * (row * size + v) + k];
      return made;
    },
    /** Of the largest sphere around the origin of a cell of a species. */
    radiusOf(s) {
      const mesh = this.templates[s], own = this.own[s];
      return Math.max(mesh ? radiusOf(mesh) : 0, own ? own.radius : 0);
    },
    number: (i) => (numbers ? numbers[i] : i) + 1,
    /** -1 if it is not drawn. */
    indexOf: (number) => {
      if (!numbers) return number >= 1 && number <= species.length ? number - 1 : -1;
      return numbers.indexOf(number - 1);
    },
    /** Line in the .pos file of its species. */
    line(i) { return this.number(i) - before[species[i]] + 1; },
    position(i) { return Array.from(this.positions.subarray(3 * i, 3 * i + 3)); },
    /** Unit symmetry axis: axis y of the template. */
    axis(i) { return turned(this.orientations, i, [0, 1, 0]); },
  };
})();

/** `v`, turned by the i-th of the quaternions x, y, z, w. */
function turned(quaternions, i, v) {
  const [x, y, z, w] = quaternions.subarray(4 * i, 4 * i + 4);
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]];
}

/** Text of a value of the report, with this many significant digits. */
function shown(value, digits = 6) {
  if (value === null || value === undefined) return "–";
  if (typeof value === "boolean") return value ? "true" : "false";
  if (typeof value === "number") return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(digits)));
  if (Array.isArray(value)) return value.length ? value.map((one) => shown(one, digits)).join(", ") : "–";
  if (typeof value === "object")
    return Object.entries(value).filter(([, one]) => one !== null && one.length !== 0).map(([key, one]) => key + " " + shown(one, digits)).join(", ");
  return value;
}

const axisColors = { x: "#b3261e", y: "#2f855a", z: "#1f5fa8" };

function colorOf(name, species) {
  const known = [["RBC", "#b3261e"], ["vRBC", "#b3261e"], ["PLT", "#d69e00"], ["WBC", "#64748b"]];
  const found = known.find(([prefix]) => name.startsWith(prefix));
  return found ? found[1] : ["#1f5fa8", "#2f855a", "#7b4397", "#d9730d", "#12848c", "#a0516b"][species % 6];
}

/** The largest of 1, 2, 5, 10, ... that is at most `most`. */
function roundBelow(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return Number(([5, 2, 1].find((digit) => digit * power <= most) * power).toPrecision(1));
}

/** An element with attributes and children; text is never read as markup. */
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes))
    if (key in made && typeof value === "function") made[key] = value;
    else made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** Lets the processor draw on a canvas. Without a graphics processor, an emulated one would take longer, and delay the view. */
const byProcessor = (canvas) => canvas.getContext("2d", { willReadFrequently: true });

function download(blob, name) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
