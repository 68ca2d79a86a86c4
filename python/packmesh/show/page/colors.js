// Colours of the cells, and their legend.

const scaleStops = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];  // viridis

/** Colour of 0 to 1 on a scale from dark violet to yellow. */
function onScale(t) {
  const s = 4 * within(t, 0, 0.99999), k = Math.floor(s);
  return scaleStops[k].map((c, i) => Math.round(c + (s - k) * (scaleStops[k + 1][i] - c)));
}

const rgbOf = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));

/** A brightness of its own for each cell, so that neighbours differ. */
const shadeOf = (number) => 0.84 + 0.3 * ((number * 0.6180339887) % 1);

const faults = (() => {
  const found = new Map(), add = (cell, text) => found.set(cell + 1, (found.get(cell + 1) || []).concat(text));
  for (const [a, b] of stored.overlapping) {
    add(a, a === b ? "meets its own periodic image" : "overlaps cell " + (b + 1));
    if (a !== b) add(b, "overlaps cell " + (a + 1));
  }
  for (const one of stored.misplaced) add(one.cell, one.reason);
  for (const cell of stored.selfIntersecting || []) add(cell, "intersects itself");
  return found;
})();

const sorted = (values) => Float32Array.from(values).sort();

/** Largest gap of the scale: the 90th percentile, rounded up. */
function mostGap() {
  const gaps = sorted(cells.gaps), most = gaps.length ? gaps[Math.floor(0.9 * (gaps.length - 1))] : 1;
  return [0.02, 0.05, 0.1, 0.2, 0.5].find((round) => most <= round) || 1;
}

function colorModes() {
  const modes = {
    species: {
      name: "species",
      color: (i) => {
        const s = cells.species[i];
        return rgbOf(colorOf(report.species[s].name, s)).map((c) => c * shadeOf(cells.number(i)));
      },
      keys: report.species.map((one, s) => [one.name, colorOf(one.name, s)]).filter((_, s) => stored.species[s].cells > 0),
    },
  };
  if (cells.gaps) {
    const gap = mostGap();
    modes.gap = { name: "gap to the nearest cell", color: (i) => onScale(cells.gaps[i] / gap), ends: ["0", "≥ " + gap + " µm"] };
  }
  const alongAxes = Object.values(axisColors).map(rgbOf);
  modes.orientation = { name: "orientation of the axis",
    color: (i) => cells.axis(i).reduce((sum, c, k) => sum.map((value, j) => value + c * c * alongAxes[k][j]), [0, 0, 0]),
    keys: Object.entries(axisColors).map(([axis, color]) => ["axis along " + axis, color]) };
  if (cells.localHematocrits) {
    const values = sorted(cells.localHematocrits), at = (share) => values[Math.round(share * (values.length - 1))] || 0;
    const least = at(0.02), most = Math.max(at(0.98), least + 1e-3);
    modes.hematocrit = { name: "local hematocrit", color: (i) => onScale((cells.localHematocrits[i] - least) / (most - least)),
      ends: [least.toFixed(3), most.toFixed(3)] };
  }
  if (cells.forces) {
    const most = Math.max(sorted(cells.forces)[cells.forces.length - 1] || 0, 1e-3);
    modes.force = { name: "largest force on a vertex", color: (i) => onScale(cells.forces[i] / most), ends: ["0", most.toPrecision(3) + " pN"] };
  }
  if (faults.size)
    modes.faults = { name: "violations", color: (i) => (faults.has(cells.number(i)) ? [220, 30, 30] : [200, 206, 214]),
      keys: [["overlaps, or not inside", "#dc1e1e"], ["others", "#c8ced6"]] };
  return modes;
}

function showLegend(mode) {
  const legend = document.getElementById("legend");
  legend.replaceChildren(element("div", {}, mode.name));
  if (mode.keys) {
    for (const [name, color] of mode.keys) {
      const swatch = element("span", { class: "swatch" });
      swatch.style.background = color;
      legend.append(element("span", { class: "key" }, swatch, name));
    }
    return;
  }
  const bar = element("div", { class: "bar" });
  bar.style.background = "linear-gradient(to right, " + scaleStops.map((c) => "rgb(" + c.join() + ")").join() + ")";
  legend.append(bar, element("div", { class: "ends" }, ...mode.ends.map((end) => element("span", {}, end))));
}
