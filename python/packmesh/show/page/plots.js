// Plots of the report, or of means of several (those have more errors), by Chart.js: dragging zooms, the numbers can be saved.

const middles = (begin, width, count) => Array.from({ length: count }, (_, i) => begin + (i + 0.5) * width);

/** With factors by which curves of volume fractions are drawn, so that few platelets are visible beside many red cells: one for each
 * colour, which is that of a species. */
function magnified(curves) {
  const highest = (some) => Math.max(...some.flatMap((curve) => curve.y)), most = highest(curves);
  return curves.map((curve) => {
    const own = highest(curves.filter((other) => other.color === curve.color)), factor = own > 0 && own < most / 8 ? roundBelow((0.6 * most) / own) : 1;
    return { ...curve, factor };
  });
}

function wallPlot(wall) {
  const layer = wall.cellFreeLayer[0].thickness;
  const requested = (wall.asked ? wall.asked.species : []).map((one, s) => one.fraction && {
    name: one.name + ", requested", color: colorOf(one.name, s), dash: [2, 3], y: one.fraction,
    x: middles(wall.begin, wall.width, one.fraction.length) }).filter((curve) => curve);
  return {
    id: "wall", title: "Volume fraction by distance to the wall", x: "distance to the wall [µm]", y: "volume fraction",
    curves: magnified(wall.species.map((one, s) => ({
      name: one.name, color: colorOf(one.name, s), y: one.fraction, error: one.error,
      x: middles(wall.begin, wall.width, one.fraction.length) })).filter((curve) => curve.y.some((y) => y !== 0)).concat(requested)),
    mark: layer === null ? null : { at: layer, text: "cell-free layer " + layer.toFixed(2) + " µm" },
  };
}

function axialPlot(axial) {
  return {
    id: "axes", title: "Hematocrit along the axes", x: "position [µm]", y: "hematocrit of the slice",
    curves: Object.entries(axial).map(([axis, profile]) => ({
      name: axis, color: axisColors[axis], y: profile.red, error: profile.error,
      x: middles(profile.begin, profile.width, profile.red.length) })),
  };
}

function gapPlot(gaps) {
  const curves = [];
  gaps.forEach((one, s) => {
    const all = one.counts.reduce((sum, n) => sum + n, one.beyond);
    if (all > 0)
      curves.push({ name: one.name, color: colorOf(one.name, s), steps: true, y: one.counts.map((n) => n / all),
        error: one.error && one.error.map((n) => n / all), x: middles(0, one.width, one.counts.length) });
  });
  // At first up to the value below which most of them lie.
  let last = 10;
  for (const curve of curves) curve.y.forEach((y, i) => { if (y >= 0.01) last = Math.max(last, i + 2); });
  return { id: "gaps", title: "Gap to the nearest other cell", x: "gap [µm]", y: "share of the cells", curves,
    upTo: gaps.length ? Math.min(last, gaps[0].counts.length) * gaps[0].width : undefined };
}

/** Of the species with the most cells. */
function orientationPlot(orientation) {
  const most = orientation.reduce((a, b) => (b.cells > a.cells ? b : a));
  const density = (counts) => counts.map((n) => (10 * n) / Math.max(1, most.cells));
  return {
    id: "orientation", title: most.name + ": direction of the symmetry axis n", x: "|cosine| between n and an axis",
    y: "density (1: no order)",
    curves: most.cosines.map((counts, k) => ({
      name: "xyz"[k], color: axisColors["xyz"[k]], x: middles(0, 0.1, 10), y: density(counts),
      error: most.errors && density(most.errors[k]) })),
  };
}

/** What profiles leave out, in words; empty: nothing. */
function leftOutText(measures) {
  if (!measures.leftOut) return "";
  return "without " + measures.leftOut + (measures.leftOut === 1 ? " cell that is" : " cells that are") + " not wholly inside";
}

function plotsOf(measures) {
  const leftOut = leftOutText(measures);
  const profiles = [measures.wall && wallPlot(measures.wall), axialPlot(measures.axial)].filter((plot) => plot);
  if (leftOut) for (const plot of profiles) plot.title += ", " + leftOut;
  return [...profiles, gapPlot(measures.gaps), orientationPlot(measures.orientation)];
}

/** A table of all curves; those with other positions get columns of their own. */
function csvOf(plot) {
  const columns = [], quote = (text) => '"' + text.replace(/"/g, '""') + '"';
  let previous = null;
  for (const curve of plot.curves) {
    if (!previous || previous.join() !== curve.x.join()) columns.push([quote(plot.x), curve.x]);
    previous = curve.x;
    columns.push([quote(curve.name), curve.y]);
    if (curve.error) columns.push([quote(curve.name + " " + (report.errors || "error")), curve.error]);
  }
  const rows = Math.max(0, ...columns.map(([, numbers]) => numbers.length));
  const lines = [columns.map(([name]) => name).join()];
  for (let i = 0; i < rows; ++i) lines.push(columns.map(([, numbers]) => (i < numbers.length ? numbers[i] : "")).join());
  return lines.join("\n") + "\n";
}

function datasetsOf(plot) {
  const sets = [];
  for (const curve of plot.curves) {
    const factor = curve.factor || 1, points = (x, y) => x.map((at, i) => ({ x: at, y: factor * y[i] }));
    sets.push({ label: curve.name + (factor > 1 ? " × " + factor : ""), name: curve.name, factor, data: points(curve.x, curve.y),
      borderColor: curve.color, backgroundColor: curve.color + "22",
      borderDash: curve.dash || [], borderWidth: 1.8, pointRadius: plot.points ? 2 : 0, pointHitRadius: 6, clip: plot.points ? 3 : undefined, stepped: curve.steps ? "middle" : false,
      fill: curve.steps ? "origin" : false });
    if (!curve.error) continue;
    const band = { borderWidth: 0, pointRadius: 0, pointHoverRadius: 0, pointHitRadius: 0, band: true,
      backgroundColor: curve.color + "2e", stepped: curve.steps ? "middle" : false };
    sets.push({ ...band, data: points(curve.x, curve.y.map((y, i) => Math.max(0, y - curve.error[i]))), fill: false });
    sets.push({ ...band, data: points(curve.x, curve.y.map((y, i) => y + curve.error[i])), fill: "-1" });
  }
  return sets;
}

/** The dashed line of a mark, with its text. */
const markPlugin = (mark) => ({
  id: "mark",
  afterDatasetsDraw(chart) {
    const { ctx, chartArea: area } = chart, x = chart.scales.x.getPixelForValue(mark.at);
    if (x < area.left || x > area.right) return;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = "#1d2733";
    ctx.lineWidth = 1;
    ctx.setLineDash([4, 3]);
    ctx.beginPath();
    ctx.moveTo(x, area.top);
    ctx.lineTo(x, area.bottom);
    ctx.stroke();
    ctx.font = "12px sans-serif";
    const left = x > (area.left + area.right) / 2;
    ctx.textAlign = left ? "right" : "left";
    ctx.lineWidth = 4;
    ctx.setLineDash([]);
    ctx.strokeStyle = "#fff";
    ctx.strokeText(mark.text, x + (left ? -6 : 6), area.top + 14);
    ctx.fillText(mark.text, x + (left ? -6 : 6), area.top + 14);
    ctx.restore();
  },
});

const whitePlugin = {
  id: "white",
  beforeDraw(chart) {
    chart.ctx.fillStyle = "#fff";
    chart.ctx.fillRect(0, 0, chart.width, chart.height);
  },
};

function showRange(chart, least, most) {
  Object.assign(chart.options.scales.x, { min: least, max: most });
  chart.update("none");
}

/** Dragging over a part of the plot shows that part; a double click shows all. */
function addZoom(chart, area, all) {
  const canvas = chart.canvas, shade = element("div", { class: "zoom" });
  area.append(shade);
  let from = null;
  const within = (event) => Math.min(Math.max(event.offsetX, chart.chartArea.left), chart.chartArea.right);
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.pointerType === "touch") return;
    from = within(event);
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (from === null) return;
    const to = within(event);
    Object.assign(shade.style, { display: "block", left: Math.min(from, to) + "px", width: Math.abs(to - from) + "px" });
  });
  canvas.addEventListener("pointerup", (event) => {
    if (from === null) return;
    const ends = [from, within(event)].sort((a, b) => a - b);
    from = null;
    shade.style.display = "none";
    if (ends[1] - ends[0] > 5) showRange(chart, ...ends.map((x) => chart.scales.x.getValueForPixel(x)));
  });
  canvas.addEventListener("dblclick", all);
}

/** Of all that values at these positions stand for: the layers that the positions are the middles of, unless they are points. */
function extentOf(x, points) {
  const half = points || x.length < 2 ? 0 : (x[1] - x[0]) / 2;
  return [x[0] - half, x[x.length - 1] + half].map((end) => Number(end.toFixed(9)));
}

/** Lines as they are drawn in the plot. */
function legendItems(chart) {
  return Chart.defaults.plugins.legend.labels.generateLabels(chart).map((item) =>
    ({ ...item, lineDash: chart.data.datasets[item.datasetIndex].borderDash, lineWidth: 2 }));
}

function addPlot(plot) {
  const canvas = element("canvas", { role: "img", "aria-label": plot.title + "; the button CSV saves its numbers" });
  const area = element("div", { class: "plot-area" }, canvas);
  const ends = plot.curves.flatMap((curve) => extentOf(curve.x, plot.points));
  const [least, most] = [Math.min(0, ...ends), Math.max(...ends)];
  const all = () => showRange(chart, least, plot.upTo || most);
  const scaled = (factor) => {
    const { min, max } = chart.scales.x, middle = (min + max) / 2, half = (factor * (max - min)) / 2;
    showRange(chart, Math.max(least, middle - half), Math.min(most, middle + half));
  };
  const button = (text, title, onclick) =>
    element("button", { type: "button", "aria-label": text + ": " + title + ", " + plot.title, title, onclick }, text);
  document.getElementById("plots").append(element("section", { class: "card" },
    element("div", { class: "plot-head" }, element("h2", {}, plot.title), element("span", {},
      button("+", "Zoom in", () => scaled(0.5)), " ", button("–", "Zoom out", () => scaled(2)), " ",
      button("All", "Show all", all), " ",
      button("PNG", "Save as picture", () => canvas.toBlob((blob) => download(blob, plot.id + ".png"))), " ",
      button("CSV", "Save the numbers", () => download(new Blob([csvOf(plot)], { type: "text/csv" }), plot.id + ".csv")))),
    area));
  byProcessor(canvas);
  const chart = new Chart(canvas, {
    type: "line",
    data: { datasets: datasetsOf(plot) },
    options: {
      animation: false, responsive: true, maintainAspectRatio: false, parsing: false, normalized: true,
      interaction: { mode: "nearest", axis: "x", intersect: false },
      scales: {
        x: { type: "linear", min: least, max: plot.upTo || most, title: { display: true, text: plot.x },
          grid: { color: "#e6eaf0" },
          ticks: { maxRotation: 0, autoSkipPadding: 12, includeBounds: false, callback: (x) => Number(x.toPrecision(3)) } },
        y: { min: plot.signed ? undefined : 0, title: { display: true, text: plot.y }, grid: { color: "#e6eaf0" },
          suggestedMax: plot.whole ? 5 : undefined, ticks: { precision: plot.whole ? 0 : undefined } },
      },
      plugins: {
        legend: { labels: { usePointStyle: true, pointStyle: "line", pointStyleWidth: 22, generateLabels: legendItems, filter: (item, data) => !data.datasets[item.datasetIndex].band } },
        tooltip: { filter: (item) => !item.dataset.band,
          callbacks: { title: (items) => (items.length ? plot.x.replace(/ \[.*/, "") + " " + shown(items[0].parsed.x, 4) : ""),
            label: (item) => item.dataset.name + ": " + shown(item.parsed.y / item.dataset.factor, 4) } },
      },
    },
    plugins: plot.mark ? [whitePlugin, markPlugin(plot.mark)] : [whitePlugin],
  });
  addZoom(chart, area, all);
  return chart;
}

const showPlots = () => (report.measures ? plotsOf(report.measures).map(addPlot) : []);
