// The cells as instanced meshes, by WebGL: coarse while things move, fine at rest.

/** Edges of the templates' coarser forms [fraction of their radius], the finest first. */
const coarseness = [0, 0.28, 0.5, 0.9];

/** Triangles in a picture at rest, and at first in one while things move: with a graphics processor, and where the processor draws. */
const mostTriangles = { hardware: { still: 1.5e7, moving: 2e6 }, software: { still: 1.2e6, moving: 2e5 } };
const leastMoving = 5e4, mostMoving = 1.5e7;

/** Time of a picture while things move [s]. */
const movingTime = 0.04;

const newContext = (canvas, options) => canvas.getContext("webgl2", options) || canvas.getContext("webgl", options);

/** Whether a graphics processor draws. Browsers that draw by the processor need not say that this is slow. */
function hasHardware() {
  const gl = newContext(element("canvas"), { failIfMajorPerformanceCaveat: true });
  if (!gl) return false;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  const freed = gl.getExtension("WEBGL_lose_context");
  if (freed) freed.loseContext();
  return !/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

/** The context of a canvas. Where the processor draws, edges are made smooth at rest alone, by more pixels. */
function contextOf(canvas, hardware) {
  const context = newContext(canvas, { alpha: true, depth: true, antialias: hardware, preserveDrawingBuffer: true });
  if (!context) throw new Error("no WebGL");
  return context;
}

/** The meshes of deformed cells as a texture, with the place of each cell's first vertex in it by species; null without such cells. */
function membranesOfAll() {
  if (!cells.own.some((one) => one)) return null;
  const width = 2048, sizes = cells.own.map((one) => (one ? one.vertices.length / 4 : 0));
  const height = Math.ceil(sizes.reduce((sum, size) => sum + size, 0) / width), texels = new Float32Array(4 * width * height);
  let first = 0;
  const own = cells.own.map((one, s) => {
    const template = cells.templates[s];
    if (!one) return template && new Float32Array(stored.species[s].cells).fill(-1);
    for (let i = 0; i < one.vertices.length; ++i)
      texels[4 * first + i] = i % 4 < 3 ? one.scale * one.vertices[i] : one.vertices[i] & 0xffff;
    const places = Float32Array.from(one.rows, (row) => (row < 0 ? -1 : first + (row * template.vertices.length) / 3));
    first += sizes[s];
    return places;
  });
  const texture = new THREE.DataTexture(texels, width, height, THREE.RGBAFormat, THREE.FloatType);
  texture.needsUpdate = true;
  return { own, uniforms: { membranes: { value: texture }, texels: { value: new THREE.Vector2(width, height) } } };
}

/** Some cells of a species, at all levels of coarseness; those that are drawn are the first `shown`. */
class Instances {
  /** @param shapes geometries of the template by level; @param count of cells at most; @param from arrays of all cells of the species */
  constructor(view, shapes, from, count, shared) {
    Object.assign(this, { from, count, shown: count });
    const array = (values, size) => (shared ? values : new values.constructor(size * count));
    this.attributes = {
      place: new THREE.InstancedBufferAttribute(array(from.place, 3), 3),
      turn: new THREE.InstancedBufferAttribute(array(from.turn, 4), 4),
      tint: new THREE.InstancedBufferAttribute(array(from.tint, 4), 4, true),
      index: new THREE.InstancedBufferAttribute(array(from.index, 1), 1),
      ...(from.own && { own: new THREE.InstancedBufferAttribute(array(from.own, 1), 1) }),
    };
    this.levels = shapes.map((shape) => {
      const geometry = new THREE.InstancedBufferGeometry();
      for (const [name, values] of Object.entries(shape.attributes)) geometry.setAttribute(name, values);
      geometry.setIndex(shape.index);
      for (const [name, attribute] of Object.entries(this.attributes)) geometry.setAttribute(name, attribute);
      const skin = new THREE.Mesh(geometry, view.cellMaterial), section = new THREE.Mesh(geometry, view.sectionMaterial);
      for (const mesh of [skin, section]) {
        Object.assign(mesh, { frustumCulled: false, visible: false });
        view.scene.add(mesh);
      }
      return { geometry, skin, section };
    });
  }

  /** Copies these cells, indices among those of the species. */
  choose(indices) {
    this.shown = indices.length;
    for (const [name, { array, itemSize: size }] of Object.entries(this.attributes)) {
      indices.forEach((i, to) => { for (let k = 0; k < size; ++k) array[size * to + k] = this.from[name][size * i + k]; });
      this.attributes[name].needsUpdate = true;
    }
  }

  /** @param level that is drawn; -1: none. @param share of the cells */
  show(level, share, cut) {
    this.levels.forEach(({ geometry, skin, section }, i) => {
      geometry.maxInstancedCount = Math.ceil(share * this.shown);
      skin.visible = i === level && geometry.maxInstancedCount > 0;
      section.visible = skin.visible && cut;
    });
  }
}

class MeshView {
  constructor(canvas, camera) {
    this.camera = camera;
    this.hardware = hasHardware();
    Object.assign(this, this.hardware ? mostTriangles.hardware : mostTriangles.software);
    this.renderer = new THREE.WebGLRenderer({ canvas, context: contextOf(canvas, this.hardware), alpha: true });
    this.renderer.localClippingEnabled = true;
    this.renderer.setClearColor(0, 0);
    this.scene = new THREE.Scene();
    this.picked = new THREE.WebGLRenderTarget(1, 1);
    this.planes = [];
    const membranes = membranesOfAll(), shader = (vertexShader, fragmentShader, { uniforms, ...more } = {}) => new THREE.ShaderMaterial(
      { vertexShader, fragmentShader, clipping: true, clippingPlanes: [], extensions: { derivatives: true }, ...more,
        defines: membranes ? { OWN_MESHES: 1 } : {}, uniforms: { ...uniforms, ...(membranes && membranes.uniforms) } });
    this.cellMaterial = shader(cellVertex, cellFragment);
    this.sectionMaterial = shader(sectionVertex, sectionFragment,
      { side: THREE.BackSide, uniforms: { reach: { value: 0 } }, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 4 });
    this.pickMaterial = shader(pickVertex, pickFragment);
    this.markMaterial = shader(cellVertex, markFragment, { transparent: true, depthTest: false, depthWrite: false });
    this.wallMaterial = shader(wallVertex, wallFragment, { transparent: true, depthWrite: false, side: THREE.DoubleSide });
    this.lineMaterial = new THREE.LineBasicMaterial({ color: 0x8793a3, clippingPlanes: [] });
    this.tint = new Uint8Array(4 * cells.count);
    this.triangles = coarseness.map(() => 0);
    this.species = [];
    let first = 0;
    stored.species.forEach((one, s) => {
      if (one.cells) this.addSpecies(cells.templates[s], first, one.cells, membranes && membranes.own[s]);
      first += one.cells;
    });
    this.wall = new THREE.Group();
    this.scene.add(this.wall);
    this.addWall();
  }

  addSpecies(template, first, count, own) {
    const normals = normalsOf(template), radius = radiusOf(template);
    const { reach } = this.sectionMaterial.uniforms;
    reach.value = Math.max(reach.value, cells.radiusOf(cells.species[first]));
    const each = [];
    const shapes = coarseness.map((edge, level) => {
      const mesh = edge ? coarsened(template, normals, edge * radius)
        : { ...template, normals, numbers: Float32Array.from({ length: normals.length / 3 }, (_, i) => i) };
      const shape = new THREE.BufferGeometry();
      shape.setAttribute("position", new THREE.BufferAttribute(mesh.vertices, 3));
      shape.setAttribute("normal", new THREE.BufferAttribute(mesh.normals, 3));
      if (own) shape.setAttribute("number", new THREE.BufferAttribute(mesh.numbers, 1));
      shape.setIndex(new THREE.BufferAttribute(mesh.triangles, 1));
      each.push(mesh.triangles.length / 3);
      this.triangles[level] += count * each[level];
      return shape;
    });
    const from = {
      place: cells.positions.subarray(3 * first, 3 * (first + count)), turn: cells.orientations.subarray(4 * first, 4 * (first + count)),
      tint: this.tint.subarray(4 * first, 4 * (first + count)), index: Float32Array.from({ length: count }, (_, i) => first + i),
      own,
    };
    this.species.push({ first, count, each, shapes, from, all: new Instances(this, shapes, from, count, true) });
  }

  addWall() {
    let geometry = new THREE.BufferGeometry();
    if (stored.lumen) {
      const mesh = creased(meshOf(stored.lumen));
      geometry.setAttribute("position", new THREE.BufferAttribute(mesh.vertices, 3));
      geometry.setAttribute("normal", new THREE.BufferAttribute(mesh.normals, 3));
      this.wall.add(new THREE.Mesh(geometry, this.wallMaterial));
    } else {
      const { low, high } = report.lumen, size = minus(high, low);
      geometry = new THREE.BoxBufferGeometry(...size).translate(...along(low, size, 0.5));
    }
    this.wall.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 40), this.lineMaterial));
    this.wall.children.forEach((one, i) => { one.renderOrder = i + 1; });
  }

  /** @param colors of each cell, red, green, blue 0 to 255; null: not drawn */
  setColors(colors) {
    colors.forEach((color, i) => this.tint.set(color ? [...color.map((c) => within(c, 0, 255)), 255] : [0, 0, 0, 0], 4 * i));
    for (const { all } of this.species) all.attributes.tint.needsUpdate = true;
  }

  setPlanes(planes) {
    this.planes = planes;
    for (const material of [this.cellMaterial, this.sectionMaterial, this.pickMaterial, this.markMaterial, this.wallMaterial,
      this.lineMaterial])
      material.clippingPlanes = planes;
  }

  resize(width, height) {
    Object.assign(this, { width, height });
    this.setPixels(1);
  }

  /** @param ratio pixels per pixel of the page, where the processor draws */
  setPixels(ratio) {
    const own = Math.min(window.devicePixelRatio || 1, 2), pixels = this.hardware ? own : Math.max(ratio, ratio > 1 ? own : 1);
    if (this.renderer.getPixelRatio() !== pixels) this.renderer.setPixelRatio(pixels);
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== this.width || size.y !== this.height) this.renderer.setSize(this.width, this.height, false);
  }

  /** Shows a cell through all others; -1: none. */
  mark(index) {
    if (this.marked) {
      this.scene.remove(this.marked);
      this.marked.geometry.dispose();
      this.marked = null;
    }
    if (index < 0) return;
    const { first, shapes, from } = this.species.filter((one) => one.first <= index).pop();
    const geometry = new THREE.InstancedBufferGeometry(), at = index - first, one = (array, size, normalized) =>
      new THREE.InstancedBufferAttribute(array.slice(size * at, size * (at + 1)), size, normalized);
    for (const [name, values] of Object.entries(shapes[0].attributes)) geometry.setAttribute(name, values);
    geometry.setIndex(shapes[0].index);
    geometry.setAttribute("place", one(from.place, 3));
    geometry.setAttribute("turn", one(from.turn, 4));
    geometry.setAttribute("tint", one(from.tint, 4, true));
    if (from.own) geometry.setAttribute("own", one(from.own, 1));
    geometry.maxInstancedCount = 1;
    this.marked = new THREE.Mesh(geometry, this.markMaterial);
    Object.assign(this.marked, { frustumCulled: false, renderOrder: 10 });
    this.scene.add(this.marked);
  }

  /** The finest level with at most so many triangles, or the coarsest. */
  levelWith(most) {
    return this.triangles.findIndex((n, i) => n <= most || i === coarseness.length - 1);
  }

  /** All cells at a level, or the first `share` of each species. */
  showAll(level, share = 1) {
    for (const { all, front, behind } of this.species) {
      all.show(level, share, this.planes.length > 0);
      for (const some of [front, behind]) if (some) some.show(-1, 0, false);
    }
  }

  /** A picture while things move, in about `movingTime`: coarse, and of a part of the cells if that takes too long. */
  drawMoving() {
    const begin = performance.now(), level = this.levelWith(this.moving);
    this.setPixels(1);
    this.showAll(level, Math.min(1, this.moving / (this.triangles[level] || 1)));
    this.renderer.render(this.scene, this.camera);
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits until it is drawn
    const seconds = (performance.now() - begin) / 1000;
    if (this.warm && (seconds < movingTime / 2 || seconds > 1.5 * movingTime))
      this.moving = within(this.moving * within(movingTime / seconds, 0.5, 1.5), leastMoving, mostMoving);
    this.warm = true;  // the first picture compiles the shaders
  }

  /** A picture at rest: all cells, fine; of many cells, those that are seen are fine and what is behind them is coarse. */
  drawStill() {
    this.setPixels(2);
    if (this.triangles[0] <= this.still) this.showAll(0);
    else this.showSeen();
    this.renderer.render(this.scene, this.camera);
  }

  showSeen() {
    const last = coarseness.length - 1, cut = this.planes.length > 0, seen = this.seenCells();
    const of = this.species.map(({ first, count }) => {
      const front = [], behind = [];
      for (let i = 0; i < count; ++i) if (this.tint[4 * (first + i) + 3]) (seen[first + i] ? front : behind).push(i);
      return { front, behind };
    });
    const level = coarseness.findIndex((_, i) => i === last ||
      this.species.reduce((sum, one, s) => sum + one.each[i] * of[s].front.length, 0) <= this.still);
    this.species.forEach((one, s) => {
      for (const part of ["front", "behind"]) {
        one[part] = one[part] || new Instances(this, one.shapes, one.from, one.count, false);
        one[part].choose(of[s][part]);
        one[part].show(part === "front" ? level : last, 1, cut);
      }
      one.all.show(-1, 0, false);
    });
  }

  /** Whether a pixel shows each cell: coarse ones, with their numbers as colours. */
  seenCells() {
    const target = new THREE.WebGLRenderTarget(this.width, this.height), codes = new Uint8Array(4 * this.width * this.height);
    this.showAll(this.levelWith(this.still / 2));
    this.renderCodes(target);
    this.renderer.readRenderTargetPixels(target, 0, 0, this.width, this.height, codes);
    target.dispose();
    const seen = new Uint8Array(cells.count + 1);
    for (let i = 0; i < codes.length; i += 4) seen[codes[i] + 256 * codes[i + 1] + 65536 * codes[i + 2]] = 1;
    return seen.subarray(1);
  }

  renderCodes(target) {
    const others = [this.wall, this.marked].filter((one) => one && one.visible);
    for (const one of others) one.visible = false;
    this.pickMaterial.side = this.planes.length ? THREE.DoubleSide : THREE.FrontSide;
    const skins = this.species.flatMap(({ all }) => all.levels);
    for (const { skin, section } of skins) {
      skin.material = this.pickMaterial;
      section.visible = false;
    }
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    this.renderer.setRenderTarget(null);
    for (const { skin } of skins) skin.material = this.cellMaterial;
    for (const one of others) one.visible = true;
  }

  /** Index of the cell at a point of the canvas; -1: none. */
  pick(x, y) {
    const code = new Uint8Array(4);
    this.camera.setViewOffset(this.width, this.height, x, y, 1, 1);
    this.showAll(this.levelWith(this.still));
    this.renderCodes(this.picked);
    this.camera.clearViewOffset();
    this.renderer.readRenderTargetPixels(this.picked, 0, 0, 1, 1, code);
    return code[0] + 256 * code[1] + 65536 * code[2] - 1;
  }
}
