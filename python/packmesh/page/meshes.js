// The cells as instanced meshes, by WebGL.

const clipVertex = `
  #include <clipping_planes_pars_vertex>
  attribute vec3 place; attribute vec4 turn; attribute vec4 tint; attribute float index;
  vec3 turned(vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }`;

const cellVertex = clipVertex + `
  varying vec3 vTint; varying vec3 vNormal;
  void main() {
    vTint = tint.rgb;
    vNormal = normalMatrix * turned(normal);
    vec4 mvPosition = modelViewMatrix * vec4(place + turned(position), 1.0);
    gl_Position = tint.a > 0.0 ? projectionMatrix * mvPosition : vec4(2.0, 2.0, 2.0, 1.0);
    #include <clipping_planes_vertex>
  }`;

// Inner sides, seen where a plane cuts a cell, are shown evenly lit: like the cut.
const cellFragment = `
  #include <clipping_planes_pars_fragment>
  varying vec3 vTint; varying vec3 vNormal;
  void main() {
    #include <clipping_planes_fragment>
    vec3 n = normalize(vNormal);
    float key = max(dot(n, normalize(vec3(-0.5, 0.75, 0.6))), 0.0), fill = max(dot(n, normalize(vec3(0.8, -0.1, 0.5))), 0.0);
    float shine = pow(max(dot(n, normalize(vec3(-0.28, 0.42, 0.9))), 0.0), 40.0);
    vec3 lit = vTint * (0.30 + 0.72 * key + 0.22 * fill + 0.12 * n.z) + 0.22 * shine;
    gl_FragColor = vec4(gl_FrontFacing ? lit : mix(vTint, vec3(0.0), 0.42), 1.0);
  }`;

// The selected cell, seen through the others.
const markFragment = `
  #include <clipping_planes_pars_fragment>
  varying vec3 vTint; varying vec3 vNormal;
  void main() {
    #include <clipping_planes_fragment>
    gl_FragColor = vec4(vTint, 0.25 + 0.55 * pow(1.0 - abs(normalize(vNormal).z), 2.0));
  }`;

const pickVertex = clipVertex + `
  varying vec3 vCode;
  void main() {
    float i = index + 1.0;
    vCode = vec3(mod(i, 256.0), mod(floor(i / 256.0), 256.0), floor(i / 65536.0)) / 255.0;
    vec4 mvPosition = modelViewMatrix * vec4(place + turned(position), 1.0);
    gl_Position = tint.a > 0.0 ? projectionMatrix * mvPosition : vec4(2.0, 2.0, 2.0, 1.0);
    #include <clipping_planes_vertex>
  }`;

const pickFragment = `
  #include <clipping_planes_pars_fragment>
  varying vec3 vCode;
  void main() {
    #include <clipping_planes_fragment>
    gl_FragColor = vec4(vCode, 1.0);
  }`;

const wallVertex = `
  #include <clipping_planes_pars_vertex>
  varying vec3 vNormal; varying vec3 vToEye;
  void main() {
    vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
    vNormal = normalMatrix * normal;
    vToEye = -mvPosition.xyz;
    gl_Position = projectionMatrix * mvPosition;
    #include <clipping_planes_vertex>
  }`;

// Nearly transparent seen from the front, denser towards the outline.
const wallFragment = `
  #include <clipping_planes_pars_fragment>
  varying vec3 vNormal; varying vec3 vToEye;
  void main() {
    #include <clipping_planes_fragment>
    float facing = abs(dot(normalize(vNormal), normalize(vToEye)));
    gl_FragColor = vec4(0.36, 0.47, 0.60, 0.05 + 0.40 * pow(1.0 - facing, 2.5));
  }`;

/** Edges of the templates' coarser forms [fraction of their radius], the finest first. */
const coarseness = [0, 0.28, 0.5, 0.9];

/** The context of a canvas: without smooth edges where the processor draws. */
function contextOf(canvas) {
  for (const quick of [true, false]) {
    const options = { alpha: true, depth: true, antialias: quick, failIfMajorPerformanceCaveat: quick,
      preserveDrawingBuffer: true };
    const context = canvas.getContext("webgl2", options) || canvas.getContext("webgl", options);
    if (context) return context;
  }
  throw new Error("no WebGL");
}

class MeshView {
  constructor(canvas, camera) {
    this.camera = camera;
    this.renderer = new THREE.WebGLRenderer({ canvas, context: contextOf(canvas), alpha: true });
    this.renderer.localClippingEnabled = true;
    this.renderer.setClearColor(0, 0);
    this.scene = new THREE.Scene();
    this.picked = new THREE.WebGLRenderTarget(1, 1);
    const shader = (vertexShader, fragmentShader, more) => new THREE.ShaderMaterial(
      { vertexShader, fragmentShader, clipping: true, clippingPlanes: [], ...more });
    this.cellMaterial = shader(cellVertex, cellFragment);
    this.pickMaterial = shader(pickVertex, pickFragment);
    this.markMaterial = shader(cellVertex, markFragment, { transparent: true, depthTest: false, depthWrite: false });
    this.wallMaterial = shader(wallVertex, wallFragment, { transparent: true, depthWrite: false, side: THREE.DoubleSide });
    this.lineMaterial = new THREE.LineBasicMaterial({ color: 0x8793a3, clippingPlanes: [] });
    this.tint = new Uint8Array(4 * cells.count);
    this.levels = coarseness.map(() => []);  // meshes of each species at each level
    this.triangles = coarseness.map(() => 0);
    this.cells = [];
    let first = 0;
    stored.species.forEach((one, s) => {
      if (one.cells) this.addSpecies(cells.templates[s], first, one.cells);
      first += one.cells;
    });
    this.wall = new THREE.Group();
    this.scene.add(this.wall);
    this.addWall();
  }

  addSpecies(template, first, count) {
    const instanced = (array, size, normalized) => new THREE.InstancedBufferAttribute(array, size, normalized);
    const shared = {
      place: instanced(cells.positions.subarray(3 * first, 3 * (first + count)), 3),
      turn: instanced(cells.orientations.subarray(4 * first, 4 * (first + count)), 4),
      tint: instanced(this.tint.subarray(4 * first, 4 * (first + count)), 4, true),
      index: instanced(Float32Array.from({ length: count }, (_, i) => first + i), 1),
    };
    this.cells.push(shared.tint);
    const normals = normalsOf(template), radius = radiusOf(template);
    coarseness.forEach((edge, level) => {
      const mesh = edge ? coarsened(template, normals, edge * radius) : { ...template, normals };
      const geometry = new THREE.InstancedBufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(mesh.vertices, 3));
      geometry.setAttribute("normal", new THREE.BufferAttribute(mesh.normals, 3));
      geometry.setIndex(new THREE.BufferAttribute(mesh.triangles, 1));
      for (const [name, attribute] of Object.entries(shared)) geometry.setAttribute(name, attribute);
      geometry.maxInstancedCount = count;
      const drawn = new THREE.Mesh(geometry, this.cellMaterial);
      Object.assign(drawn, { frustumCulled: false, userData: { first, count } });
      this.levels[level].push(drawn);
      this.triangles[level] += (count * mesh.triangles.length) / 3;
      this.scene.add(drawn);
    });
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
    for (const attribute of this.cells) attribute.needsUpdate = true;
  }

  /** Inner sides are drawn only where a plane cuts cells open. */
  setPlanes(planes) {
    for (const material of [this.cellMaterial, this.pickMaterial, this.markMaterial, this.wallMaterial, this.lineMaterial])
      material.clippingPlanes = planes;
    for (const material of [this.cellMaterial, this.pickMaterial]) {
      material.side = planes.length ? THREE.DoubleSide : THREE.FrontSide;
      material.needsUpdate = true;
    }
  }

  /** Most triangles in a picture that takes this time [s], by the times of two. */
  trianglesIn() {
    const gl = this.renderer.getContext(), last = coarseness.length - 1;
    const seconds = (level) => {
      const begin = performance.now();
      this.draw(this.triangles[level]);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits until it is drawn
      return (performance.now() - begin) / 1000;
    };
    seconds(last);  // compiles the shaders
    const few = seconds(last), more = seconds(last - 1);
    const each = Math.max(more - few, 0.0005) / (this.triangles[last - 1] - this.triangles[last] || 1);
    return (time) => this.triangles[last] + (time - few) / each;
  }

  resize(width, height) {
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height, false);
  }

  /** Shows a cell through all others; -1: none. */
  mark(index) {
    if (this.marked) {
      this.scene.remove(this.marked);
      this.marked.geometry.dispose();
      this.marked = null;
    }
    if (index < 0) return;
    const of = this.levels[0].filter((mesh) => mesh.userData.first <= index).pop().geometry;
    const geometry = new THREE.InstancedBufferGeometry(), one = (array, size, normalized) =>
      new THREE.InstancedBufferAttribute(array.slice(size * index, size * (index + 1)), size, normalized);
    for (const name of ["position", "normal"]) geometry.setAttribute(name, of.attributes[name]);
    geometry.setIndex(of.index);
    geometry.setAttribute("place", one(cells.positions, 3));
    geometry.setAttribute("turn", one(cells.orientations, 4));
    geometry.setAttribute("tint", one(this.tint, 4, true));
    geometry.maxInstancedCount = 1;
    this.marked = new THREE.Mesh(geometry, this.markMaterial);
    Object.assign(this.marked, { frustumCulled: false, renderOrder: 10 });
    this.scene.add(this.marked);
  }

  /** @param most triangles; if even the coarsest templates have more, a part of the cells is drawn unless `all` are needed */
  draw(most, all = true) {
    const level = this.triangles.findIndex((n, i) => n <= most || i === coarseness.length - 1);
    const share = all ? 1 : Math.min(1, most / (this.triangles[level] || 1));
    this.level = level;
    this.levels.forEach((meshes, i) => {
      for (const mesh of meshes) {
        mesh.visible = i === level;
        mesh.geometry.maxInstancedCount = Math.ceil(share * mesh.userData.count);
      }
    });
    this.renderer.render(this.scene, this.camera);
  }

  /** Index of the cell at a point of the canvas; -1: none. */
  pick(x, y) {
    const size = this.renderer.getSize(new THREE.Vector2()), code = new Uint8Array(4);
    this.camera.setViewOffset(size.x, size.y, x, y, 1, 1);
    for (const mesh of this.levels.flat()) {
      mesh.material = this.pickMaterial;
      mesh.geometry.maxInstancedCount = mesh.userData.count;
    }
    const others = [this.wall, this.marked].filter((one) => one && one.visible);
    for (const one of others) one.visible = false;
    this.renderer.setRenderTarget(this.picked);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    this.renderer.readRenderTargetPixels(this.picked, 0, 0, 1, 1, code);
    this.renderer.setRenderTarget(null);
    for (const mesh of this.levels.flat()) mesh.material = this.cellMaterial;
    for (const one of others) one.visible = true;
    this.camera.clearViewOffset();
    return code[0] + 256 * code[1] + 65536 * code[2] - 1;
  }
}
