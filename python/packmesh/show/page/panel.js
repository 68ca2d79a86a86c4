// What is beside the view: its controls, and the selected cell.

function showCell(view) {
  const box = byId("cell"), i = view.selected;
  box.replaceChildren();
  if (i < 0) return;
  const species = report.species[cells.species[i]], most = report.certificate.gapsMeasuredUpTo;
  const list = element("dl"), add = (name, value) => list.append(element("dt", {}, name), element("dd", {}, value));
  add("kind", species.name);
  if (species.file) add("in file", species.file + ", line " + cells.line(i));
  add("position [µm]", cells.position(i).map((x) => x.toFixed(3)).join(", "));
  add("symmetry axis", cells.axis(i).map((x) => x.toFixed(3)).join(", "));
  if (cells.gaps) add("gap to nearest", cells.gaps[i] >= most ? "more than " + most + " µm" : shown(cells.gaps[i], 4) + " µm");
  if (cells.localHematocrits) add("local hematocrit", cells.localHematocrits[i].toFixed(3));
  if (cells.forces) add("largest force", shown(cells.forces[i], 3) + " pN");
  const close = element("button", { type: "button", onclick: () => view.select(-1) }, "Deselect");
  box.append(element("h2", {}, "Cell " + cells.number(i) + " "), list);
  for (const text of faults.get(cells.number(i)) || []) box.append(element("p", { class: "fault" }, text));
  const setAlone = (event) => { view.alone = event.target.checked; view.color(); };
  const alone = element("input", { type: "checkbox", onchange: setAlone });
  alone.checked = view.alone;
  box.append(element("div", { class: "row" }, close, element("label", {}, alone, " only it and its neighbours")));
  const button = (index) => element("button", { type: "button", onclick: () => view.select(index) }, String(cells.number(index)));
  const rowOf = ({ index, gap, image }) => [element("span", {}, button(index),
    " " + report.species[cells.species[index]].name + (image ? " (periodic image)" : "")), gap.toFixed(4)];
  box.append(view.neighbours.length ? tableOf(["neighbour", "#gap [µm]"], view.neighbours.map(rowOf))
    : noteOf("No cell is nearer than " + most + " µm" + (stored.slice ? " among those drawn." : ".")));
}

function addClips(view) {
  const names = "xyz", { low, high } = report.lumen;
  for (let k = 0; k < 3; ++k) {
    const oninput = () => {
      const [from, to] = ends.map((one) => Number(one.value));
      const at = (share) => shown(low[k] + share * (high[k] - low[k]), 4) + " µm";
      [[ends[0], "≥", from], [ends[1], "≤", to]].forEach(([end, sign, share]) => {
        end.title = names[k] + " " + sign + " " + at(share);
        end.setAttribute("aria-valuetext", at(share));
      });
      view.clip(k, from, to);
    };
    const slider = (value, end) => element("input",
      { type: "range", min: 0, max: 1, step: 0.002, value, "aria-label": end + " " + names[k] + " shown", oninput });
    const ends = [slider(0, "least"), slider(1, "largest")];
    byId("clips").append(element("div", { class: "clip" }, element("span", {}, names[k]), ...ends));
  }
}

function addSwitches(view) {
  const box = byId("species");
  const add = (text, checked, onchange) => {
    const input = element("input", { type: "checkbox", onchange: () => onchange(input.checked) });
    input.checked = checked;
    box.append(element("label", {}, input, " " + text));
  };
  report.species.forEach((one, s) => {
    if (stored.species[s].cells)
      add(one.name, true, (on) => { view.hidden[on ? "delete" : "add"](s); view.color(); });
  });
  add("lumen", true, (on) => { view.drawing.wall.visible = on; view.move(); });
}

function addKeys(view) {
  const step = 0.08, keys = {
    ArrowLeft: () => view.turn(-step, 0), ArrowRight: () => view.turn(step, 0),
    ArrowUp: () => view.turn(0, step), ArrowDown: () => view.turn(0, -step),
    "+": () => view.zoom(0.9), "=": () => view.zoom(0.9), "-": () => view.zoom(1.11),
    0: () => view.showAll(), Escape: () => view.select(-1),
  };
  const shifted = {
    ArrowLeft: () => view.shift(-1, 0), ArrowRight: () => view.shift(1, 0),
    ArrowUp: () => view.shift(0, 1), ArrowDown: () => view.shift(0, -1),
  };
  view.canvas.addEventListener("keydown", (event) => {
    const action = (event.shiftKey && shifted[event.key]) || keys[event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action();
  });
}

function addPicking(view) {
  let from = null;
  view.canvas.addEventListener("pointerdown", (event) => { from = [event.offsetX, event.offsetY]; });
  view.canvas.addEventListener("pointerup", (event) => {
    if (!from || event.button !== 0 || Math.hypot(event.offsetX - from[0], event.offsetY - from[1]) > 4) return;
    view.select(view.drawing.pick(event.offsetX, event.offsetY));
  });
}

function addPanel(view) {
  const choice = byId("colorBy");
  for (const [key, mode] of Object.entries(view.modes)) choice.append(element("option", { value: key }, mode.name));
  choice.onchange = () => view.setMode(choice.value);
  addSwitches(view);
  addClips(view);
  addKeys(view);
  addPicking(view);
  byId("reset").onclick = () => view.showAll();
  const directions = { x: [0, 0], y: [90, 0], z: [-90, 89.99] };
  for (const button of document.querySelectorAll("[data-along]")) {
    button.title = "Look along " + button.dataset.along;
    button.setAttribute("aria-label", button.title);
    button.onclick = () => { view.look(...directions[button.dataset.along]); view.draw(); };
  }
  byId("savePicture").onclick = () => { view.picture().toBlob((blob) => download(blob, "packing.png")); };
  byId("number").max = cells.all;
  byId("find").onsubmit = (event) => {
    event.preventDefault();
    const index = cells.indexOf(Number(byId("number").value));
    view.select(index);
    if (index < 0) byId("cell").replaceChildren(noteOf("There is no such cell" + (stored.slice ? " among those drawn." : ".")));
  };
  let help = "Drag to turn, right-drag (two fingers) to move, scroll to zoom, click a cell.";
  if (stored.slice)
    help += " Shown are the " + cells.count + " of " + cells.all + " cells nearest to the middle along " + stored.slice + ".";
  if (view.drawing instanceof OutlineView) help += " This browser has no WebGL: cells are drawn as ellipsoids.";
  byId("help").textContent = help;
  window.addEventListener("beforeprint", () => { byId("still").src = view.picture().toDataURL("image/png"); });
}
