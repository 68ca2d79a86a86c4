showTables();
const charts = showPlots();
const view = new View();
addPanel(view);
window.packMesh = { report, cells, view, charts };  // for scripts and tests
