#!/usr/bin/env bash
# Writes a closed round tube along x as ascii STL: scripts/make_tube.sh [length radius segments] > tube.stl
# The polygon has corners on the y and z axes (segments a multiple of 4), so that its width is exactly the diameter.
set -euo pipefail
export LC_ALL=C
exec awk -v length_="${1:-20}" -v radius="${2:-5}" -v n="${3:-64}" '
function number(v) { return sprintf("%.9g", v < 1e-12 && v > -1e-12 ? 0 : v) }
function facet(ax, ay, az, bx, by, bz, cx, cy, cz,   nx, ny, nz, l) {
  nx = (by - ay) * (cz - az) - (bz - az) * (cy - ay)
  ny = (bz - az) * (cx - ax) - (bx - ax) * (cz - az)
  nz = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
  l = sqrt(nx * nx + ny * ny + nz * nz)
  print "  facet normal " number(nx / l) " " number(ny / l) " " number(nz / l)
  print "    outer loop"
  print "      vertex " number(ax) " " number(ay) " " number(az)
  print "      vertex " number(bx) " " number(by) " " number(bz)
  print "      vertex " number(cx) " " number(cy) " " number(cz)
  print "    endloop"
  print "  endfacet"
}
BEGIN {
  if (length_ <= 0 || radius <= 0 || n < 4 || n % 4) {
    print "make_tube: length > 0, radius > 0 and a multiple of 4 segments are needed" > "/dev/stderr"
    exit 2
  }
  turn = 8 * atan2(1, 1)
  for (k = 0; k < n; ++k) {
    y[k] = radius * cos(turn * k / n)
    z[k] = radius * sin(turn * k / n)
  }
  print "solid tube"
  for (k = 0; k < n; ++k) {
    m = (k + 1) % n
    facet(0, y[k], z[k], length_, y[m], z[m], length_, y[k], z[k])
    facet(0, y[k], z[k], 0, y[m], z[m], length_, y[m], z[m])
    facet(0, 0, 0, 0, y[m], z[m], 0, y[k], z[k])
    facet(length_, 0, 0, length_, y[k], z[k], length_, y[m], z[m])
  }
  print "endsolid tube"
}'
