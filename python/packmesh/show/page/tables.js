// Figures and tables of the report.

function gapText(value, most) {
  if (value === 0) return "none, cells overlap";
  return value === null ? "more than " + shown(most) + " µm" : value.toFixed(4) + " µm";
}

function durationText(seconds) {
  if (seconds < 120) return shown(seconds, 3) + " s";
  const minutes = seconds / 60;
  return minutes < 120 ? shown(minutes, 3) + " min" : shown(minutes / 60, 3) + " h";
}

const noteOf = (text) => element("p", { class: "note" }, text);

const checked = report.outcome === "checked";

/** Cells that are not inside have no gap to the wall. */
function wallGapText(certificate) {
  return certificate.minimumWallGap === 0 ? "none, cells are not inside"
    : gapText(certificate.minimumWallGap, certificate.wallGapsMeasuredUpTo || certificate.gapsMeasuredUpTo);
}

function counted(n, one, many) {
  return shown(n) + " " + (n === 1 ? one : many);
}

/** What was found, in one line. */
function verdictText(certificate) {
  if (certificate.clean) return "certificate: no overlap, all inside";
  return "certificate: " + counted(certificate.overlapping, "overlapping pair", "overlapping pairs") + ", " +
    counted(certificate.misplaced, "cell", "cells") + " misplaced" +
    (certificate.selfIntersecting ? ", " + certificate.selfIntersecting + " self-intersecting" : "");
}

/** @param heads those that begin with '#' denote numeric columns; empty: no head */
function tableOf(heads, rows) {
  const numeric = heads.map((head) => head.startsWith("#"));
  const cell = (tag, text, i) => element(tag, numeric[i] ? { class: "n" } : {}, text);
  const body = element("table");
  if (heads.some((head) => head))
    body.append(element("tr", {}, ...heads.map((head, i) => cell("th", head.replace(/^#/, ""), i))));
  for (const row of rows) body.append(element("tr", {}, ...row.map((text, i) => cell("td", text, i))));
  return element("div", { class: "scroll" }, body);
}

/** Tables that are wider than the page are scrolled by keyboard, too: those alone are stops of the Tab key. */
function makeReachable() {
  for (const one of document.querySelectorAll(".scroll")) {
    if (one.scrollWidth > one.clientWidth) one.tabIndex = 0;
    else one.removeAttribute("tabindex");
  }
}
window.addEventListener("load", makeReachable);
window.addEventListener("resize", makeReachable);

function addCard(title, ...parts) {
  for (const part of parts)
    if (part.className === "scroll") Object.entries({ role: "region", "aria-label": title }).forEach((one) => part.setAttribute(...one));
  document.getElementById("tables").append(element("section", { class: "card" }, element("h2", {}, title), ...parts));
}

function showHead() {
  const config = report.configuration.config;
  document.getElementById("title").textContent = document.title =
    (report.outcome === "checked" ? "Check of cells in a " : "Packing of a ") + shown(report.lumen.description);
  document.getElementById("subtitle").textContent = "packMesh " + shown(report.program.version) + " (" +
    shown(report.program.commit) + ")" + (config === null ? "" : ", case " + shown(config)) +
    (report.outcome === "checked" ? "" : ", seed " + shown(report.configuration.seed));
}

/** Of one of several realisations: links to the reports before and after it, which have the same file name. */
function showRealisation() {
  const one = report.realisation, file = location.pathname.split("/").pop();
  if (!one) return;
  const link = (folder, text) => (folder === null ? [] : [" · ", element("a", { href: "../" + folder + "/" + file }, text)]);
  document.getElementById("subtitle").append(", ", element("span", { id: "realisation" },
    "realisation " + one.number + " of " + one.of, ...link(one.previous, "previous"), ...link(one.next, "next")));
}

function showTiles() {
  const tile = (value, what, kind = "") => document.getElementById("tiles").append(
    element("div", { class: "tile " + kind }, element("b", {}, value), element("span", {}, what)));
  const sum = (member) => report.species.reduce((all, one) => all + one[member], 0);
  const certificate = report.certificate, placed = sum("placed"), asked = sum("asked");
  const { ofLumen, keptOfLumen } = report.hematocrit[0], drops = report.hemocell && report.hemocell.dropped,
    fault = report.hemocell && report.hemocell.asExpected === false;
  if (drops) {
    tile(keptOfLumen.toFixed(4), "hematocrit of the lumen, of what HemoCell keeps", fault ? "bad" : "");
    tile(ofLumen.toFixed(4), "hematocrit of the lumen, of all cells");
  } else {
    tile(ofLumen.toFixed(4), "hematocrit of the lumen");
  }
  tile(String(placed), placed < asked ? "cells, of " + asked + " requested" : "cells");
  tile(certificate.clean ? "clean" : "not clean", verdictText(certificate), certificate.clean ? "good" : "bad");
  tile(gapText(certificate.minimumGap, certificate.gapsMeasuredUpTo), "smallest gap");
  const layer = report.measures.wall && report.measures.wall.cellFreeLayer[0].thickness;
  if (layer !== null) tile(layer.toFixed(2) + " µm", ["cell-free layer", leftOutText(report.measures)].filter((text) => text).join(", "));
  if (report.hemocell)
    tile(shown(report.hemocell.kept) + (drops ? " of " + placed : ""), "cells that HemoCell keeps",
      fault ? "bad" : drops ? "" : "good");
}

function showSpecies() {
  const lumen = report.lumen, lattice = lumen.lattice;
  let text = "Lumen: " + shown(lumen.description) + ", " + shown(lumen.volume) + " µm³";
  if (lumen.note) text += "; " + lumen.note;
  if (lattice)
    text += "; " + shown(lattice.fluidNodes) + " fluid nodes at dx " + shown(lattice.dx) + " µm: " +
      shown(lattice.fluidVolume) + " µm³";
  addCard("Cells",
    tableOf(["cell", "origin"].concat(checked ? ["#in the file"] : ["#requested", "#placed", "specified as"],
      ["#mesh volume [µm³]", "#vertices", "#volume fraction", "#HemoCell keeps"]),
    report.species.map((one) => [shown(one.name), shown(one.origin)].concat(
      checked ? [shown(one.placed)] : [shown(one.asked), shown(one.placed), shown(one.request)],
      [shown(one.meshVolume, 4), shown(one.vertices), one.volumeFraction.toFixed(5), shown(one.keptByHemoCell)]))),
    noteOf(text));
}

function showHematocrit() {
  const fluid = report.lumen.lattice !== null, drops = report.hemocell && report.hemocell.dropped > 0;
  const heads = ["red cells counted by", "#of the lumen"].concat(fluid ? ["#of the fluid nodes"] : [],
    drops ? ["#of the lumen, of what HemoCell keeps"] : []);
  addCard("Hematocrit", tableOf(heads, report.hematocrit.map((one) =>
    [shown(one.text), one.ofLumen.toFixed(4)].concat(fluid ? [one.ofFluidNodes.toFixed(4)] : [],
      drops ? [one.keptOfLumen.toFixed(4)] : []))));
}

function showCertificate() {
  const c = report.certificate, most = c.gapsMeasuredUpTo;
  const rows = [
    ["verdict", c.clean ? "clean: no two meshes share a point, all are inside the lumen" : "not clean"],
    ["cells examined", shown(c.cells)], ["pairs tested", shown(c.pairs)]];
  if (!c.clean)
    rows.push(["overlapping pairs", shown(c.overlapping)], ["cells not inside, or too near to the wall", shown(c.misplaced)]);
  if (c.selfIntersecting) rows.push(["cells that intersect themselves", shown(c.selfIntersecting)]);
  rows.push(["smallest gap between cells", gapText(c.minimumGap, most)]);
  if (report.lumen.wall) rows.push(["smallest gap to the wall", wallGapText(c)]);
  if (report.hemocell) {
    rows.push(["HemoCell keeps", shown(report.hemocell.kept) + " cells, deletes " + shown(report.hemocell.dropped)]);
    for (const one of report.hemocell.reasons) rows.push(["deleted by HemoCell", one.reason + ": " + counted(one.cells, "cell", "cells")]);
  }
  addCard("Certificate", tableOf(["", ""], rows),
    noteOf("Decided by exact arithmetic on the meshes that HemoCell builds, at the positions in the .pos files."));
}

/** How much cells with meshes of their own are deformed. */
function showDeformation() {
  const found = report.deformation;
  if (!found) return;
  const percent = (value) => (100 * value).toFixed(2), row = (name, key, text) => [name, text(found.largest[key]), text(found.median[key])];
  addCard("Deformation",
    tableOf(["of " + counted(found.cells, "cell", "cells"), "#largest", "#median"], [
      row("largest force on a vertex [pN]", "force", (value) => shown(value, 3)),
      ...((found.species || []).length > 1 ? found.species : []).map((one) => ["of " + one.name + " [pN]", shown(one.largest.force, 3), shown(one.median.force, 3)]),
      row("change of volume [%]", "volume", percent), row("change of area [%]", "area", percent),
      row("largest change of a triangle [%]", "triangle", percent), row("largest change of an edge [%]", "edge", percent)]),
    noteOf("Forces are those of HemoCell's membrane laws on the cells as they are."));
}

function showOrder() {
  addCard("Gaps and orientation",
    tableOf(["cell", "#smallest gap [µm]", "#median [µm]", "#mean [µm]", "#farther than " + shown(report.certificate.gapsMeasuredUpTo) + " µm", "#order S",
      "#eigenvalues of the order tensor", "#director"],
    report.measures.gaps.map((gaps, s) => {
      const order = report.measures.orientation[s];
      return [shown(gaps.name), shown(gaps.minimum, 3), shown(gaps.median, 3), shown(gaps.mean, 3), shown(gaps.beyond),
        shown(order.nematic, 3), shown(order.eigenvalues, 2), shown(order.director, 2)];
    })),
    noteOf("Gap: distance between the mesh of a cell and the nearest other one, as in the certificate. Order of the symmetry " +
      "axes: S = 1 if all are parallel, about 1/√cells if random. Bands of the profiles: one standard error."));
}

function showSettings() {
  const list = element("dl", { class: "settings" });
  const ofPacking = new Set(["seed", "method", "maxIterations", "maxTime", "hematocrit", "hematocritVolume", "builder", "escape",
    "rotate", "order", "soft", "maxForce", "maxVolumeChange", "maxAreaChange", "bestEffort", "realisations", "checkpointEvery", "growth", "growthFrames", "tile", "restart"]);
  for (const [name, value] of Object.entries(report.configuration))
    if (!checked || !ofPacking.has(name)) list.append(element("div", {}, element("dt", {}, name), element("dd", {}, shown(value))));
  addCard("Settings", list, noteOf("Names are those of packMesh --reference and --help; – stands for none."));
}

/** Quoted so that a shell takes it as one word. */
function quoted(word) {
  return /^[\w@%+=:,./-]+$/.test(word) ? word : "'" + word.replace(/'/g, "'\\''") + "'";
}

function showCommand() {
  const { times, statistics, repeated } = report, growth = statistics.growth;
  const effort = (growth ? growth.iterations : statistics.sweeps) + statistics.search;
  const parts = [element("pre", {}, report.command.map(quoted).join(" "))];
  if (report.outcome !== "checked")
    parts.push(noteOf("Run time " + durationText(times.wall) + " on " + times.ranks +
      (times.ranks === 1 ? " rank; " : " ranks; ") +
      effort + (growth ? " iterations of growth, " : " sweeps, ") + shown(statistics.repairs) +
      " rounds of repair. The same command and version write the same .pos files, on any number of ranks."));
  if (repeated)
    parts.push(noteOf("Repeated " + repeated.times.join(" × ") + " times: a box of " +
      repeated.boxSize.map((x) => shown(x)).join(" × ") + " µm with " + shown(repeated.cells) + " cells."));
  addCard("To reproduce", ...parts);
}

/** Of cells of which there is no report. */
function showCells() {
  document.getElementById("title").textContent = document.title = report.title;
  document.getElementById("subtitle").textContent = report.subtitle;
  addCard("Cells", tableOf(["cell", "#number", "#vertices"],
    report.species.map((one) => [shown(one.name), shown(one.placed), shown(one.vertices)])),
    noteOf("There is no report of these cells: gaps and certificate are not known. packMesh check config.xml --start <file> --report " +
      "report.json examines them in the lumen of a case."));
}

function showTables() {
  if (report.outcome === "cells") return showCells();
  showHead();
  showRealisation();
  showTiles();
  for (const show of [showSpecies, showHematocrit, showCertificate, showDeformation, showOrder, showSettings, showCommand]) show();
}
