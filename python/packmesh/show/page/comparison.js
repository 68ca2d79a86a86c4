// The page of python3 -m packmesh compare: means of several reports, without cells.

document.getElementById("view").remove();
document.getElementById("title").textContent = document.title = report.title;
document.getElementById("subtitle").textContent = report.subtitle;
addCard("Mean and spread", tableOf(report.figures.heads, report.figures.rows),
  noteOf("Number: realisations that have the value; gaps above 1 µm have none. Order along an axis: mean of (3 cos² - 1) / 2 of the " +
    "angle between symmetry axis and that axis: 1 if all are parallel to it, 0 without order, -1/2 if all are perpendicular. " +
    "Curves: means; bands: one standard deviation between realisations."));
const realisations = report.realisations.rows.map(([name, ...others], i) => {
  const link = report.realisations.links[i];  // null: there is no page
  return [link === null ? name : element("a", { href: link }, name), ...others];
});
addCard("Realisations", tableOf(report.realisations.heads, realisations));
const charts = showPlots();
window.packMesh = { report, charts };  // for scripts and tests
