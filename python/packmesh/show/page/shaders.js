// Programs of the graphics processor: cells, their sections, the wall, and numbers of cells.

/** Distance to the nearest plane that cuts, in pixels on the surface: sections have an outline. */
const sectionDistance = `
  float toSection() {
    float nearest = 1e6;
    #if NUM_CLIPPING_PLANES > 0
      for (int i = 0; i < NUM_CLIPPING_PLANES; ++i) {
        float d = clippingPlanes[i].w - dot(vViewPosition, clippingPlanes[i].xyz);
        nearest = min(nearest, d / max(fwidth(d), 1e-6));
      }
    #endif
    return nearest;
  }`;

const instanceVertex = `
  #include <clipping_planes_pars_vertex>
  attribute vec3 place; attribute vec4 turn; attribute vec4 tint; attribute float index;
  vec3 turned(vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }
  #ifdef OWN_MESHES  // of deformed cells: four numbers a vertex in a texture, from that of own on; below 0: the template
    attribute float own; attribute float number;
    uniform sampler2D membranes; uniform vec2 texels;
    vec4 vertexOfOwn() {
      float at = own + number, row = floor((at + 0.5) / texels.x);
      return texture2D(membranes, vec2((at - row * texels.x + 0.5) / texels.x, (row + 0.5) / texels.y));
    }
    vec3 formed() { return own < 0.0 ? position : vertexOfOwn().xyz; }
    vec3 facing() {
      if (own < 0.0) return normal;
      float code = vertexOfOwn().w, high = floor(code / 256.0);
      vec2 flat2 = vec2(code - 256.0 * high, high) / 127.5 - 1.0;
      vec3 n = vec3(flat2, 1.0 - abs(flat2.x) - abs(flat2.y));
      if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
      return normalize(n);
    }
  #else
    vec3 formed() { return position; }
    vec3 facing() { return normal; }
  #endif`;

const cellVertex = instanceVertex + `
  varying vec3 vTint; varying vec3 vNormal;
  void main() {
    vTint = tint.rgb;
    vNormal = normalMatrix * turned(facing());
    vec4 mvPosition = modelViewMatrix * vec4(place + turned(formed()), 1.0);
    gl_Position = tint.a > 0.0 ? projectionMatrix * mvPosition : vec4(2.0, 2.0, 2.0, 1.0);
    #include <clipping_planes_vertex>
  }`;

const cellFragment = `
  #include <clipping_planes_pars_fragment>
  varying vec3 vTint; varying vec3 vNormal;` + sectionDistance + `
  void main() {
    float rim = toSection();  // before pixels are discarded: derivatives need neighbours
    #include <clipping_planes_fragment>
    vec3 n = normalize(vNormal);
    float key = max(dot(n, normalize(vec3(-0.5, 0.75, 0.6))), 0.0), fill = max(dot(n, normalize(vec3(0.8, -0.1, 0.5))), 0.0);
    float shine = pow(max(dot(n, normalize(vec3(-0.28, 0.42, 0.9))), 0.0), 40.0);
    vec3 lit = vTint * (0.30 + 0.72 * key + 0.22 * fill + 0.12 * max(n.z, 0.0)) + 0.22 * shine;
    gl_FragColor = vec4(mix(0.3 * vTint, lit, smoothstep(0.6, 1.6, rim)), 1.0);
  }`;

// The inner side of a cell that a plane cuts is seen exactly where its section is: it is drawn as the section, evenly. Cells that are
// not cut are left out, as their inner side may show at the outline.
const sectionVertex = instanceVertex + `
  #if NUM_CLIPPING_PLANES > 0
    uniform vec4 clippingPlanes[NUM_CLIPPING_PLANES];
  #endif
  uniform float reach;
  varying vec3 vTint;
  void main() {
    vTint = tint.rgb;
    vec4 mvPosition = modelViewMatrix * vec4(place, 1.0);
    bool isCut = false;
    #if NUM_CLIPPING_PLANES > 0
      for (int i = 0; i < NUM_CLIPPING_PLANES; ++i)
        isCut = isCut || abs(clippingPlanes[i].w + dot(mvPosition.xyz, clippingPlanes[i].xyz)) < reach;
    #endif
    mvPosition = modelViewMatrix * vec4(place + turned(formed()), 1.0);
    gl_Position = isCut && tint.a > 0.0 ? projectionMatrix * mvPosition : vec4(2.0, 2.0, 2.0, 1.0);
    #include <clipping_planes_vertex>
  }`;

const sectionFragment = `
  #include <clipping_planes_pars_fragment>
  varying vec3 vTint;` + sectionDistance + `
  void main() {
    float rim = toSection();  // before pixels are discarded: derivatives need neighbours
    #include <clipping_planes_fragment>
    gl_FragColor = vec4(vTint * mix(0.3, 0.92, smoothstep(0.6, 1.6, rim)), 1.0);
  }`;

// The selected cell, seen through the others.
const markFragment = `
  #include <clipping_planes_pars_fragment>
  varying vec3 vTint; varying vec3 vNormal;
  void main() {
    #include <clipping_planes_fragment>
    gl_FragColor = vec4(vTint, 0.25 + 0.55 * pow(1.0 - abs(normalize(vNormal).z), 2.0));
  }`;

const pickVertex = instanceVertex + `
  varying vec3 vCode;
  void main() {
    float i = index + 1.0;
    vCode = vec3(mod(i, 256.0), mod(floor(i / 256.0), 256.0), floor(i / 65536.0)) / 255.0;
    vec4 mvPosition = modelViewMatrix * vec4(place + turned(formed()), 1.0);
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

// Nearly transparent seen from the front, denser towards the outline; a line where it is cut.
const wallFragment = `
  #include <clipping_planes_pars_fragment>
  varying vec3 vNormal; varying vec3 vToEye;` + sectionDistance + `
  void main() {
    float rim = toSection();  // before pixels are discarded: derivatives need neighbours
    #include <clipping_planes_fragment>
    float facing = abs(dot(normalize(vNormal), normalize(vToEye)));
    float alpha = 0.05 + 0.40 * pow(1.0 - facing, 2.5);
    gl_FragColor = vec4(0.36, 0.47, 0.60, mix(0.9, alpha, smoothstep(0.6, 1.6, rim)));
  }`;
