// The cells as ellipses in perspective, on a plain canvas: where there is no WebGL.

class OutlineView {
  constructor(canvas, camera) {
    Object.assign(this, { canvas, camera, planes: [], wall: { visible: true }, colors: [], drawn: [] });
    this.context = canvas.getContext("2d");
    this.half = cells.templates.map((mesh) => mesh && [0, 1, 2].map((k) => {
      let most = 0;
      for (let i = k; i < mesh.vertices.length; i += 3) most = Math.max(most, Math.abs(mesh.vertices[i]));
      return most;
    }));
    const { low, high } = report.lumen, size = minus(high, low);
    const box = new THREE.BoxBufferGeometry(...size).translate(...along(low, size, 0.5));
    this.edges = new THREE.EdgesGeometry(box).attributes.position.array;
  }

  setColors(colors) { this.colors = colors; }

  setPlanes(planes) { this.planes = planes; }

  mark() {}

  resize(width, height) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    Object.assign(this, { width, height });
    Object.assign(this.canvas, { width: width * ratio, height: height * ratio });
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  /** Pixels of a point, relative to the camera. */
  onCanvas(p) {
    const focal = this.height / 2 / Math.tan((this.camera.fov * Math.PI) / 360);
    return [this.width / 2 - (focal * p[0]) / p[2], this.height / 2 + (focal * p[1]) / p[2], -focal / p[2]];
  }

  drawMoving() { this.drawStill(); }

  drawStill() {
    const { context } = this, toCamera = this.camera.matrixWorldInverse.elements;
    const seen = (v, w) => [0, 1, 2].map((k) =>
      toCamera[k] * v[0] + toCamera[4 + k] * v[1] + toCamera[8 + k] * v[2] + toCamera[12 + k] * w);
    const isCut = (p) => this.planes.some(({ normal, constant }) => dot([normal.x, normal.y, normal.z], p) + constant < 0);
    context.clearRect(0, 0, this.width, this.height);
    if (this.wall.visible) {
      context.strokeStyle = "#8793a3";
      context.beginPath();
      for (let i = 0; i < this.edges.length; i += 6) {
        context.moveTo(...this.onCanvas(seen(this.edges.subarray(i, i + 3), 1)).slice(0, 2));
        context.lineTo(...this.onCanvas(seen(this.edges.subarray(i + 3, i + 6), 1)).slice(0, 2));
      }
      context.stroke();
    }
    this.drawn = [];
    for (let i = 0; i < cells.count; ++i) {
      const at = cells.position(i), p = seen(at, 1);
      if (!this.colors[i] || p[2] > 0 || isCut(at)) continue;
      const half = this.half[cells.species[i]];
      const axes = [0, 1, 2].map((k) => seen(turned(cells.orientations, i, [0, 1, 2].map((j) => (j === k ? half[k] : 0))), 0));
      // The outline of an ellipsoid: axes of the symmetric matrix (a b; b c).
      const sum = (j, k) => axes.reduce((all, axis) => all + axis[j] * axis[k], 0), [a, b, c] = [sum(0, 0), sum(0, 1), sum(1, 1)];
      const middle = (a + c) / 2, spread = Math.hypot((a - c) / 2, b), [x, y, scale] = this.onCanvas(p);
      this.drawn.push({ i, depth: p[2], x, y,
        long: scale * Math.sqrt(middle + spread), short: scale * Math.sqrt(Math.max(middle - spread, 0)),
        angle: -Math.atan2(2 * b, a - c) / 2, light: 0.78 + (0.3 * Math.abs(axes[1][2])) / Math.hypot(...axes[1]) });
    }
    this.drawn.sort((a, b) => a.depth - b.depth);
    context.strokeStyle = "rgba(0, 0, 0, 0.45)";
    for (const one of this.drawn) {
      context.fillStyle = "rgb(" + this.colors[one.i].map((c) => Math.round(Math.min(255, c * one.light))).join() + ")";
      context.beginPath();
      context.ellipse(one.x, one.y, one.long, one.short, one.angle, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
  }

  pick(x, y) {
    for (let k = this.drawn.length - 1; k >= 0; --k) {
      const one = this.drawn[k], u = x - one.x, v = y - one.y, [s, c] = [Math.sin(one.angle), Math.cos(one.angle)];
      if (((c * u + s * v) / one.long) ** 2 + ((c * v - s * u) / one.short) ** 2 <= 1) return one.i;
    }
    return -1;
  }
}
