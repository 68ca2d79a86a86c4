// The page of packmesh run: figures of a run over time, and the profiles of its first and last steps.

document.getElementById("view").remove();
document.getElementById("title").textContent = document.title = report.title;
document.getElementById("subtitle").textContent = report.subtitle;

const times = report.steps.map((step) => 1e3 * step.time);
const speciesNames = [...new Set(report.steps.flatMap((step) => Object.keys(step.species)))];

/** A curve over time of what is known; null if nothing is. */
function curveOf(name, color, values) {
  const known = values.map((y, i) => [times[i], y]).filter(([, y]) => y !== null && y !== undefined);
  return known.length ? { name, color, x: known.map(([x]) => x), y: known.map(([, y]) => y) } : null;
}

const ofStep = (key, factor = 1) => report.steps.map((step) => (step[key] === null ? null : factor * step[key]));
const ofSpecies = (name, key, factor = 1) => report.steps.map((step) => {
  const value = (step.species[name] || {})[key];
  return value === null || value === undefined ? null : factor * value;
});
const eachSpecies = (key, factor) => speciesNames.map((name, s) => curveOf(name, colorOf(name, s), ofSpecies(name, key, factor)));

function timePlot(id, title, y, curves, kind = {}) {
  return { id, title, x: "time [ms]", y, curves: curves.filter((curve) => curve), points: true, ...kind };
}

function orderCurves() {
  const red = speciesNames.find((name) => name.includes("RBC")) || speciesNames[0];
  return ["x", "y", "z"].map((axis, k) => curveOf(axis, axisColors[axis],
    report.steps.map((step) => (step.species[red] && step.species[red].order ? step.species[red].order[k] : null))));
}

/** Of the first and the last step. */
function profilePlot(id, key, title, x) {
  const curves = [], last = report.steps.length - 1;
  for (const [i, text, dash] of last ? [[0, "first", [4, 3]], [last, "last", []]] : [[0, "", []]]) {
    const profile = report.steps[i][key];
    if (!profile) continue;
    for (const [name, fraction] of Object.entries(profile.fraction)) curves.push({
      name: (name + " " + text).trim(), color: colorOf(name, speciesNames.indexOf(name)), dash, y: fraction,
      x: middles(profile.begin, profile.width, fraction.length) });
  }
  return { id, title, x, y: "volume fraction", curves: magnified(curves) };
}

/** Of all steps until each. */
const sumsOf = (key) => report.steps.reduce((sums, step) => [...sums, (sums.length ? sums[sums.length - 1] : 0) + (step[key] || 0)], []);

function branchCurves() {
  const names = Object.keys(report.steps[0].branches || {}), colors = ["#5f6b76", "#b3261e", "#1f5fa8", "#2e7d32", "#8e24aa", "#c77700"];
  return names.map((name, k) => curveOf(name, colors[k % colors.length], report.steps.map((step) => step.branches[name])));
}

function runPlots() {
  const left = report.outlets.length ? [curveOf("left by outlets", "#7a8793", sumsOf("left"))] : [];
  return [
    timePlot("cells", "Cells", "number", [...eachSpecies("count"), ...left, curveOf("lost", "#1d2733", sumsOf("lost"))], { whole: true }),
    timePlot("hematocrit", "Hematocrit by deformed volumes", "hematocrit", [curveOf("lumen", "#b3261e", ofStep("hematocrit"))]),
    timePlot("branches", "Hematocrit of stem and branches", "hematocrit", branchCurves()),
    timePlot("layer", "Cell-free layer", "thickness [µm]", [curveOf("cell-free layer", "#1f5fa8", ofStep("cellFreeLayer"))]),
    timePlot("wall", "Cells with a centre within " + report.nearWall + " µm of the wall", "share of the cells", eachSpecies("nearWall")),
    timePlot("elongation", "Elongation of the cells", "elongation", eachSpecies("elongation")),
    timePlot("length", "Longest extent of a cell along an axis", "length [µm]", eachSpecies("length")),
    timePlot("order", "Order of the red cells' short axes along x, y, z", "order", orderCurves(), { signed: true }),
    timePlot("volume", "Mean change of volume", "change [%]", eachSpecies("volumeDrift", 100), { signed: true }),
    timePlot("area", "Mean change of area", "change [%]", eachSpecies("areaDrift", 100), { signed: true }),
    timePlot("overlaps", "Overlapping membranes", "pairs", [curveOf("pairs", "#b3261e", ofStep("overlaps")), curveOf("self-intersecting cells", "#8e24aa", ofStep("selfIntersecting"))], { whole: true }),
    timePlot("force", "Largest force on a vertex", "force [pN]", eachSpecies("force")),
    timePlot("flow", "Flow rate", "flow rate [µm³/ms]", [curveOf("flow rate", "#1f5fa8", ofStep("flow", 1e-3))]),
    profilePlot("axis", "along", "Volume fractions along " + report.axis, report.axis + " [µm]"),
    profilePlot("depth", "byDepth", "Volume fractions by distance to the wall", "distance to the wall [µm]"),
  ].filter((plot) => plot.curves.length);
}

function showRunTiles() {
  const tile = (value, what, kind = "") => document.getElementById("tiles").append(
    element("div", { class: "tile " + kind }, element("b", {}, value), element("span", {}, what)));
  const last = report.steps[report.steps.length - 1], first = report.steps[0], lost = report.lost.rows.length;
  const count = (step) => Object.values(step.species).reduce((sum, one) => sum + one.count, 0);
  const change = (key, digits, unit, what) => {
    if (last[key] !== null) tile(last[key].toFixed(digits) + unit, what + ", at first " + (first[key] === null ? "–" : first[key].toFixed(digits)));
  };
  tile(String(count(last)), "cells, at first " + count(first));
  if (report.outlets.length) tile(String(sumsOf("left").pop()), "cells left by outlets");
  tile(String(lost), "cells lost", lost ? "bad" : "good");
  change("hematocrit", 4, "", "hematocrit");
  change("cellFreeLayer", 2, " µm", "cell-free layer");
  if (last.selfIntersecting) tile(String(last.selfIntersecting), "self-intersecting cells", "bad");
  if (last.overlaps !== null) tile(String(last.overlaps), "overlapping pairs", last.overlaps ? "bad" : "good");
}

showRunTiles();
addCard("Steps", tableOf(report.table.heads, report.table.rows),
  noteOf("Length: longest extent of a red cell along x, y or z. Elongation: (a - b) / (a + b) of the two longer semi-axes of the ellipsoid with the same " +
    "moments, 0 for a cell at rest. Inclination: mean angle between longest axis and flow. Volume, area: mean change since " +
    "the first step. Layer: mean over sectors of the least distance of a red cell to the wall." +
    (report.outlets.length ? " Left: cells that disappeared at " + report.outlets.join("; ") + "." : "")));
if (report.lost.rows.length) addCard("Cells lost", tableOf(report.lost.heads, report.lost.rows));
const charts = runPlots().map(addPlot);
window.packMesh = { report, charts };  // for scripts and tests
