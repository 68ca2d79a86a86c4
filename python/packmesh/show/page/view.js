// The interactive view: camera, clip planes, colours, selection.

const byId = (id) => document.getElementById(id);

class View {
  constructor() {
    this.modes = colorModes();
    this.mode = this.modes.species;
    this.hidden = new Set();  // species
    this.selected = -1;
    this.neighbours = [];
    this.alone = false;       // only the selected cell and its neighbours are drawn
    this.camera = new THREE.PerspectiveCamera(22, 1, 1, 1000);
    this.camera.up.set(0, 0, 1);
    const { low, high } = report.lumen;
    this.planes = new Map();  // by axis: those that cut something off
    this.size = minus(high, low);
    this.middle = along(low, this.size, 0.5);
    this.outline = this.outlineOf();
    this.addCanvas();
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    Object.assign(this.controls, { enableKeys: false, screenSpacePanning: true, rotateSpeed: 0.8 });
    this.controls.addEventListener("change", () => {
      this.touched = true;
      this.move();
    });
    this.look(this.size[1] > this.size[0] ? 22.8 : -67.2, 20.2);
    this.color(false);
    this.fitCanvas();
    new ResizeObserver(() => this.fitCanvas()).observe(byId("stage"));
  }

  addCanvas() {
    const add = () => {
      const canvas = element("canvas", { tabindex: 0, role: "img", "aria-label":
        "The cells in their lumen. Arrow keys turn, with Shift they move; + and - zoom; 0 shows all" });
      byId("stage").prepend(canvas);
      return canvas;
    };
    this.marks = element("canvas", { class: "marks", "aria-hidden": "true" });
    byId("stage").append(this.marks);
    byProcessor(this.marks);
    this.canvas = add();
    try {
      this.drawing = new MeshView(this.canvas, this.camera);
    } catch (error) {  // no WebGL; the canvas may be bound to it already
      this.canvas.remove();
      this.canvas = add();
      this.drawing = new OutlineView(this.canvas, this.camera);
    }
  }

  fitCanvas() {
    const { clientWidth: width, clientHeight: height } = this.canvas, pixels = Math.min(window.devicePixelRatio || 1, 2);
    if (!width || !height || (width === this.width && height === this.height && pixels === this.pixels)) return;
    Object.assign(this, { width, height, pixels });
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.drawing.resize(width, height);
    Object.assign(this.marks, { width: width * this.pixels, height: height * this.pixels });
    if (!this.touched) this.look(this.azimuth, this.elevation);
    this.move();
  }

  /** Points relative to the middle; a view of all of them shows the lumen, and cells of files outside it. */
  outlineOf() {
    const points = ["checked", "cells"].includes(report.outcome) ? this.cornersOfCells() : [];
    if (!stored.lumen) {
      for (let corner = 0; corner < 8; ++corner)
        points.push([0, 1, 2].map((k) => (corner & (1 << k) ? 0.5 : -0.5) * this.size[k]));
      return points;
    }
    const { vertices } = meshOf(stored.lumen);
    for (let i = 0; i < vertices.length; i += 3) points.push(minus(vertices.subarray(i, i + 3), this.middle));
    return points;
  }

  /** Of the box around all cells, as points relative to the middle. */
  cornersOfCells() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < cells.count; ++i) {
      const reach = Math.hypot(...report.species[cells.species[i]].size) / 2;
      minus(cells.position(i), this.middle).forEach((x, k) => {
        low[k] = Math.min(low[k], x - reach);
        high[k] = Math.max(high[k], x + reach);
      });
    }
    if (!cells.count) return [];
    return [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => [0, 1, 2].map((k) => (corner & (1 << k) ? high : low)[k]));
  }

  /** Shows everything from a direction [degrees]: azimuth 0 is +x, 90 is +y. */
  look(azimuth, elevation) {
    Object.assign(this, { azimuth, elevation });
    const [a, e] = [azimuth, elevation].map((degrees) => (degrees * Math.PI) / 180);
    const toEye = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    const right = [-Math.sin(a), Math.cos(a), 0], up = cross(toEye, right);
    const tall = Math.tan((this.camera.fov * Math.PI) / 360) * 0.94, wide = tall * this.camera.aspect;
    // Outermost planes through the eye's pyramid: to the right, left, above, below.
    const most = [-Infinity, -Infinity, -Infinity, -Infinity];
    for (const p of this.outline) {
      const x = dot(p, right), y = dot(p, up), z = dot(p, toEye);
      [x + wide * z, -x + wide * z, y + tall * z, -y + tall * z].forEach((plane, i) => { most[i] = Math.max(most[i], plane); });
    }
    const away = Math.max((most[0] + most[1]) / (2 * wide), (most[2] + most[3]) / (2 * tall));
    const target = along(along(this.middle, right, (most[0] - most[1]) / 2), up, (most[2] - most[3]) / 2);
    const reach = Math.hypot(...this.size);
    Object.assign(this.camera, { near: reach / 500, far: Math.max(20 * reach, 3 * away) });
    this.camera.updateProjectionMatrix();
    this.controls.target.set(...target);
    this.camera.position.set(...along(target, toEye, away));
    this.controls.update();
    this.touched = false;
  }

  /** Draws soon, coarse while things move, fine at rest. */
  move() {
    clearTimeout(this.rest);
    this.rest = setTimeout(() => this.draw(), 180);
    this.frame = this.frame || requestAnimationFrame(() => {
      this.frame = 0;
      this.camera.updateMatrixWorld();
      this.drawing.drawMoving();
      this.drawMarks();
    });
  }

  /** A fine picture, now. */
  draw() {
    clearTimeout(this.rest);
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.camera.updateMatrixWorld();
    this.drawing.drawStill();
    this.drawMarks();
  }

  drawMarks() {
    const context = this.marks.getContext("2d"), { clientWidth: width, clientHeight: height } = this.canvas;
    context.setTransform(this.pixels, 0, 0, this.pixels, 0, 0);
    context.clearRect(0, 0, width, height);
    this.scale = drawMarks(context, this.camera, this.camera.position.distanceTo(this.controls.target), width, height);
  }

  color(drawn = true) {
    const shown = new Set(this.neighbours.map((one) => one.index)), dim = this.selected >= 0 && !this.alone;
    this.drawing.setColors(cells.species.map((s, i) => {
      if (this.hidden.has(s) || (this.alone && this.selected >= 0 && i !== this.selected && !shown.has(i))) return null;
      if (i === this.selected) return [40, 170, 255];
      const color = this.mode.color(i);
      return dim && !shown.has(i) ? color.map((c) => 0.6 * c + 80) : color;
    }));
    this.drawing.mark(this.selected);
    showLegend(this.mode);
    if (drawn) this.draw();
  }

  setMode(key) {
    this.mode = this.modes[key];
    this.color();
  }

  /** Cuts off what is below `from` and above `to` [fractions of the extent] along an axis. */
  clip(axis, from, to) {
    const low = report.lumen.low[axis], size = this.size[axis];
    const normal = (sign) => new THREE.Vector3().setComponent(axis, sign), planes = [];
    if (from > 0) planes.push(new THREE.Plane(normal(1), -(low + from * size)));
    if (to < 1) planes.push(new THREE.Plane(normal(-1), low + to * size));
    this.planes.set(axis, planes);
    this.drawing.setPlanes([...this.planes.values()].flat());
    this.move();
  }

  select(index) {
    this.selected = index;
    this.neighbours = index >= 0 ? neighboursOf(index, report.certificate.gapsMeasuredUpTo) : [];
    this.color();
    showCell(this);
  }

  /** Pixels of a cell's centre on the canvas. */
  screenOf(index) {
    const p = new THREE.Vector3(...cells.position(index)).project(this.camera);
    return [((p.x + 1) / 2) * this.canvas.clientWidth, ((1 - p.y) / 2) * this.canvas.clientHeight];
  }

  turn(right, up) {
    const { position } = this.camera, { target } = this.controls, from = position.clone().sub(target);
    const a = Math.atan2(from.y, from.x) + right, e = within(Math.atan2(from.z, Math.hypot(from.x, from.y)) + up, -1.55, 1.55);
    position.set(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)).multiplyScalar(from.length()).add(target);
    this.controls.update();
  }

  shift(right, up) {
    const step = 0.05 * this.camera.position.distanceTo(this.controls.target);
    const move = new THREE.Vector3(right * step, up * step, 0).applyQuaternion(this.camera.quaternion);
    this.camera.position.add(move);
    this.controls.target.add(move);
    this.controls.update();
  }

  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
  }

  showAll() {
    this.look(this.size[1] > this.size[0] ? 22.8 : -67.2, 20.2);
    this.draw();
  }

  /** A canvas with the view, the axes and the scale. */
  picture() {
    this.draw();
    const made = element("canvas"), { width, height } = this.canvas;
    Object.assign(made, { width, height });
    const context = made.getContext("2d");
    context.drawImage(this.canvas, 0, 0);
    context.drawImage(this.marks, 0, 0, width, height);
    return made;
  }
}
