// Distances between meshes, and coarser templates.

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const within = (x, least, most) => Math.min(Math.max(x, least), most);
const along = (a, d, t) => [a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2]];
const squared = (a) => dot(a, a);

/** Squared distance of the segments ab and cd (Ericson, Real-Time Collision Detection, 5.1.9). */
function betweenSegments(a, b, c, d) {
  const u = minus(b, a), v = minus(d, c), r = minus(a, c);
  const uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), ur = dot(u, r), vr = dot(v, r);
  const area = uu * vv - uv * uv;
  let s = area > 1e-12 * uu * vv ? within((uv * vr - ur * vv) / area, 0, 1) : 0;  // parallel: any
  let t = (uv * s + vr) / vv;
  if (t < 0 || t > 1) {
    t = within(t, 0, 1);
    s = within((uv * t - ur) / uu, 0, 1);
  }
  return squared(minus(along(a, u, s), along(c, v, t)));
}

/** Squared distance of a point to the inside of a triangle; infinite if it is nearest to an edge. */
function aboveTriangle(p, [a, b, c]) {
  const u = minus(b, a), v = minus(c, a), n = cross(u, v), r = minus(p, a), nn = squared(n);
  const s = dot(cross(r, v), n) / nn, t = dot(cross(u, r), n) / nn;
  return s >= 0 && t >= 0 && s + t <= 1 ? dot(r, n) ** 2 / nn : Infinity;
}

/** Whether the segment ab crosses a triangle. */
function crosses(a, b, triangle) {
  const n = cross(minus(triangle[1], triangle[0]), minus(triangle[2], triangle[0]));
  const from = dot(n, minus(a, triangle[0])), to = dot(n, minus(b, triangle[0]));
  if (from * to > 0 || from === to) return false;
  return aboveTriangle(along(a, minus(b, a), from / (from - to)), triangle) < Infinity;
}

/** Squared distance of two triangles, 0 if they meet. */
function betweenTriangles(p, q) {
  let least = Infinity;
  for (let i = 0; i < 3; ++i) {
    if (crosses(p[i], p[(i + 1) % 3], q) || crosses(q[i], q[(i + 1) % 3], p)) return 0;
    least = Math.min(least, aboveTriangle(p[i], q), aboveTriangle(q[i], p));
    for (let k = 0; k < 3; ++k) least = Math.min(least, betweenSegments(p[i], p[(i + 1) % 3], q[k], q[(k + 1) % 3]));
  }
  return least;
}

/** Radius of a mesh around its origin. */
function radiusOf(mesh) {
  let most = 0;
  for (let i = 0; i < mesh.vertices.length; i += 3) most = Math.max(most, Math.hypot(...mesh.vertices.subarray(i, i + 3)));
  return most;
}

/** The triangles of a cell, with centre and radius of each: those within `reach` of the ball around `middle`. */
function trianglesNear(cell, shift, middle, reach) {
  const { triangles } = cells.templates[cells.species[cell]], vertices = cells.verticesOf(cell), at = cells.position(cell).map((x, k) => x + shift[k]);
  const points = [];
  for (let i = 0; i < vertices.length; i += 3)
    points.push(along(at, turned(cells.orientations, cell, vertices.subarray(i, i + 3)), 1));
  const found = [];
  for (let i = 0; i < triangles.length; i += 3) {
    const corners = [points[triangles[i]], points[triangles[i + 1]], points[triangles[i + 2]]];
    const center = [0, 1, 2].map((k) => (corners[0][k] + corners[1][k] + corners[2][k]) / 3);
    const radius = Math.sqrt(Math.max(...corners.map((p) => squared(minus(p, center)))));
    if (squared(minus(center, middle)) < (reach + radius) ** 2) found.push({ corners, center, radius });
  }
  return found;
}

/** Distance of two cells, the second one shifted; null above `limit`. */
function gapBetween(a, b, shift, limit) {
  const radius = (cell) => cells.radii[cells.species[cell]];
  const atB = cells.position(b).map((x, k) => x + shift[k]);
  const ofA = trianglesNear(a, [0, 0, 0], atB, radius(b) + limit);
  const ofB = trianglesNear(b, shift, cells.position(a), radius(a) + limit);
  let bound = limit;  // the distance is at most that of two triangles' centres
  for (const p of ofA) for (const q of ofB) bound = Math.min(bound, Math.sqrt(squared(minus(p.center, q.center))));
  const pairs = [];
  for (const p of ofA)
    for (const q of ofB) {
      const least = Math.sqrt(squared(minus(p.center, q.center))) - p.radius - q.radius;
      if (least <= bound) pairs.push([least, p, q]);
    }
  pairs.sort((one, other) => one[0] - other[0]);
  let best = limit;
  for (const [least, p, q] of pairs) {
    if (least > best) break;
    best = Math.min(best, Math.sqrt(betweenTriangles(p.corners, q.corners)));
  }
  return best < limit ? best : null;
}

/** Drawn cells nearer than `limit` [µm] to a cell, periodic images included: index, gap, shift; nearest first. */
function neighboursOf(cell, limit) {
  cells.radii = cells.radii || cells.templates.map((_, s) => cells.radiusOf(s));
  const shifts = report.lumen.period.map((period) => (period > 0 ? [-period, 0, period] : [0]));
  const at = cells.position(cell), found = [];
  for (let other = 0; other < cells.count; ++other) {
    const reach = (cells.radii[cells.species[cell]] + cells.radii[cells.species[other]] + limit) ** 2;
    const p = cells.position(other);
    for (const x of shifts[0]) for (const y of shifts[1]) for (const z of shifts[2]) {
      if (other === cell && x === 0 && y === 0 && z === 0) continue;
      if (squared(minus([p[0] + x, p[1] + y, p[2] + z], at)) > reach) continue;
      const gap = gapBetween(cell, other, [x, y, z], limit);
      if (gap !== null) found.push({ index: other, gap, image: x !== 0 || y !== 0 || z !== 0 });
    }
  }
  return found.sort((a, b) => a.gap - b.gap);
}

/** Unit normals of the vertices, averaged over the triangles by area. */
function normalsOf(mesh) {
  const normals = new Float32Array(mesh.vertices.length), corner = (v) => mesh.vertices.subarray(3 * v, 3 * v + 3);
  for (let i = 0; i < mesh.triangles.length; i += 3) {
    const t = mesh.triangles.subarray(i, i + 3), a = corner(t[0]);
    const n = cross(minus(corner(t[1]), a), minus(corner(t[2]), a));
    for (const v of t) for (let k = 0; k < 3; ++k) normals[3 * v + k] += n[k];
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    for (let k = 0; k < 3; ++k) normals[i + k] /= length;
  }
  return normals;
}

/** Vertices and normals of each triangle by itself: smooth, except where triangles meet at an angle of more than 40°. */
function creased(mesh) {
  const corners = mesh.triangles.length, vertices = new Float32Array(3 * corners), normals = new Float32Array(3 * corners);
  const faces = [], facesAt = Array.from({ length: mesh.vertices.length / 3 }, () => []);
  for (let i = 0; i < corners; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => mesh.vertices.subarray(3 * mesh.triangles[i + k], 3 * mesh.triangles[i + k] + 3));
    const n = cross(minus(b, a), minus(c, a));
    for (let k = 0; k < 3; ++k) facesAt[mesh.triangles[i + k]].push(faces.length);
    faces.push({ n, length: Math.hypot(...n) || 1 });
  }
  for (let i = 0; i < corners; ++i) {
    const v = mesh.triangles[i], own = faces[Math.floor(i / 3)];
    let sum = [0, 0, 0];
    for (const f of facesAt[v])
      if (dot(own.n, faces[f].n) >= 0.76 * own.length * faces[f].length) sum = along(sum, faces[f].n, 1);
    const length = Math.hypot(...sum) || 1;
    vertices.set(mesh.vertices.subarray(3 * v, 3 * v + 3), 3 * i);
    normals.set(sum.map((x) => x / length), 3 * i);
  }
  return { vertices, normals };
}

/** A mesh with fewer triangles: vertices in the same cube of this edge that face the same way are merged.
 *  @return also the number of a vertex of each cube */
function coarsened(mesh, normals, edge) {
  const groups = new Map(), groupOf = [], sums = [], numbers = [];
  for (let i = 0; i < mesh.vertices.length; i += 3) {
    let key = "";
    for (let k = 0; k < 3; ++k) key += Math.round(mesh.vertices[i + k] / edge) + ",";
    key += normals[i + 1] > 0;
    if (!groups.has(key)) {
      groups.set(key, sums.length);
      sums.push([0, 0, 0, 0, 0, 0, 0]);
      numbers.push(i / 3);
    }
    const sum = sums[groups.get(key)];
    groupOf.push(groups.get(key));
    for (let k = 0; k < 3; ++k) {
      sum[k] += mesh.vertices[i + k];
      sum[3 + k] += normals[i + k];
    }
    ++sum[6];
  }
  const vertices = [], newNormals = [], triangles = [];
  for (const sum of sums) {
    const length = Math.hypot(sum[3], sum[4], sum[5]) || 1;
    for (let k = 0; k < 3; ++k) {
      vertices.push(sum[k] / sum[6]);
      newNormals.push(sum[3 + k] / length);
    }
  }
  for (let i = 0; i < mesh.triangles.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => groupOf[mesh.triangles[i + k]]);
    if (a !== b && b !== c && c !== a) triangles.push(a, b, c);
  }
  return { vertices: Float32Array.from(vertices), triangles: Uint32Array.from(triangles),
    normals: Float32Array.from(newNormals), numbers: Float32Array.from(numbers) };
}
