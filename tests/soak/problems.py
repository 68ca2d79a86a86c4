"""Random packing problems for scripts/soak.py, as plain data (JSON) that says all that is needed to run one again."""
import base64
import math
import struct

# --- meshes: points and triangles


def sphere_mesh(radius, rings=8):
    """A ball of quads cut in two, radius(direction) µm."""
    points, n = [], 2 * rings
    at = lambda u, v: (math.sin(u) * math.cos(v), math.sin(u) * math.sin(v), math.cos(u))
    points.append(at(0, 0))
    for i in range(1, rings):
        points += [at(math.pi * i / rings, 2 * math.pi * j / n) for j in range(n)]
    points.append(at(math.pi, 0))
    index = lambda i, j: 0 if i == 0 else len(points) - 1 if i == rings else 1 + (i - 1) * n + j % n
    triangles = []
    for i in range(rings):
        for j in range(n):
            a, b, c, d = index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)
            if b != c:
                triangles.append((a, b, c))
            if a != d:
                triangles.append((a, c, d))
    return [tuple(radius(p) * x for x in p) for p in points], triangles


def box_mesh(lo, hi):
    points = [tuple((lo, hi)[(corner >> k) & 1][k] for k in range(3)) for corner in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return points, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def tube_mesh(length, radius, rings, around, periods=1):
    """Closed at both ends; radius(x, angle) has the period `length`. Begins at x = -(periods // 2) * length."""
    points, triangles, columns = [], [], rings * periods + 1
    for i in range(columns):
        x = length * (i % rings) / rings + length * (i // rings - periods // 2)
        for j in range(around):
            r, angle = radius(length * (i % rings) / rings, 2 * math.pi * j / around), 2 * math.pi * j / around
            points.append((x, r * math.cos(angle), r * math.sin(angle)))
    for i in range(columns - 1):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = a + around, b + around
            triangles += [(a, b, d), (a, d, c)]
    first, last = len(points), len(points) + 1
    points += [(points[0][0], 0.0, 0.0), (points[-1][0], 0.0, 0.0)]
    for j in range(around):
        k = (j + 1) % around
        triangles.append((first, k, j))
        triangles.append((last, (columns - 1) * around + j, (columns - 1) * around + k))
    return points, triangles


def text_of(mesh, kind):
    """A mesh file, as bytes."""
    points, triangles = mesh
    number = lambda p: " ".join(repr(float(x)) for x in p)
    if kind == "off":
        text = f"OFF\n{len(points)} {len(triangles)} 0\n" + "".join(number(p) + "\n" for p in points)
        text += "".join("3 %d %d %d\n" % t for t in triangles)
    elif kind == "obj":
        text = "".join(f"v {number(p)}\n" for p in points)
        text += "".join("f %d %d %d\n" % tuple(i + 1 for i in t) for t in triangles)
    elif kind == "ply":
        text = (f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\n"
                f"property double z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
        text += "".join(number(p) + "\n" for p in points) + "".join("3 %d %d %d\n" % t for t in triangles)
    elif kind == "stl":
        text = "solid s\n"
        for t in triangles:
            text += "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {number(points[i])}\n" for i in t)
            text += "endloop\nendfacet\n"
        text += "endsolid s\n"
    else:
        text = b"\0" * 80 + struct.pack("<I", len(triangles))
        for t in triangles:
            text += struct.pack("<12fH", 0, 0, 0, *(x for i in t for x in points[i]), 0)
        return text
    return text.encode()


def single(mesh):
    """Coordinates as a binary STL has them."""
    return [struct.unpack("<3f", struct.pack("<3f", *p)) for p in mesh[0]], mesh[1]


# --- problems


def write_files(problem, folder):
    for name, text in problem.get("files", {}).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        data = base64.b64decode(text[7:]) if text.startswith("base64:") else text.encode()
        (folder / name).write_bytes(data)


def put(problem, name, data):
    try:
        problem["files"][name] = data.decode("ascii")
    except UnicodeDecodeError:
        problem["files"][name] = "base64:" + base64.b64encode(data).decode()


def number(x):
    return repr(round(float(x), 4))


def put_mesh(problem, rng, stem, mesh):
    """Writes a mesh in a kind of file drawn at random, and what it holds as <stem>_oracle.off. Returns the file"""
    kind = rng.choice(["off", "obj", "ply", "stl", "binary"])
    name = f"{stem}.{'stl' if kind == 'binary' else kind}"
    put(problem, name, text_of(mesh, kind))
    put(problem, f"{stem}_oracle.off", text_of(single(mesh) if kind == "binary" else mesh, "off"))
    return name


def lumen(problem, rng, oracle):
    """Returns volume [µm³] (None: not known to the last digit), point well inside, tags for <container>"""
    kind = rng.choices(["box", "walled box", "cylinder", "sphere", "vessel", "case"], [4, 3, 3, 2, 3, 5])[0]
    problem["kind"] = kind
    args = problem["args"]
    scale = rng.choice([1.0, 1.0, 1.0, 0.6, 1.4])
    size = [float(number(scale * rng.uniform(8.5, 20))) for _ in range(3)]
    if kind in ("box", "walled box"):
        problem["box"] = True
        args += [number(x) for x in size]
        walls = rng.choice(["x", "y", "z", "xy", "yz", "xz", "xyz"]) if kind == "walled box" else ""
        if walls:
            args += ["--walls", walls]
        periodic = rng.random() < 0.85 or len(walls) == 3
        args += ["--ends", "periodic"] if periodic and len(walls) < 3 else []
        # Along periodic axes all of it, along others what HemoCell keeps of the nodes at 0.5 µm.
        lo, hi, period = [], [], []
        for axis, x in zip("xyz", size):
            wraps, solid = periodic and axis not in walls, 0.5 if axis in walls else 0.0
            nodes = math.floor(2 * x + 1e-9) + (1 if solid else 0)
            lo.append(0.0 if wraps else solid - 0.25)
            hi.append(x if wraps else 0.5 * nodes - 0.25 - solid)
            period.append(x if wraps else 0)
        oracle.append("period " + " ".join(map(number, period)))
        far = [1e18 if p else 0 for p in period]
        oracle.append("inside box " + " ".join(repr(x - f)
                                               for x, f in zip(lo, far)) + " " + " ".join(repr(x + f) for x, f in zip(hi, far)))
        return math.prod(h - x for x, h in zip(lo, hi)), [x / 2 for x in size]
    if kind == "cylinder":
        axis, radius, length = rng.randrange(3), float(number(size[0] / 2 + rng.random())), size[1]
        periodic = rng.random() < 0.5
        args += ["--cylinder", "xyz"[axis], number(radius), number(length)]
        if periodic:
            args += ["--ends", "periodic"]
        center = [radius] * 3
        center[axis] = length / 2
        oracle.append("period " + " ".join(number(length) if periodic and k == axis else "0" for k in range(3)))
        oracle.append(f"inside cylinder {axis} {' '.join(map(repr, center))} {number(radius)} "
                      f"{'1e18' if periodic else number(length)}")
        return math.pi * radius**2 * length, center
    if kind == "sphere":
        radius = float(number(size[0] / 2 + 2))
        args += ["--sphere", number(radius)]
        oracle.append(f"inside sphere {radius} {radius} {radius} {radius}")
        return 4 / 3 * math.pi * radius**3, [radius] * 3
    if kind == "vessel":
        factor = rng.choice([1, 1, 10, 0.001])
        if rng.random() < 0.5:
            length, radius = size[0] + 4, size[1] / 2 + 1
            a, b, phase = rng.uniform(0, 0.3), rng.uniform(0, 0.12), rng.uniform(0, 6)
            profile = lambda x, angle: radius / factor * (1 + a * math.sin(2 * math.pi * x * factor / length + phase) + b * math
                                                          .cos(3 * angle + phase))
            rings, around = rng.choice([3, 6, 12]), rng.choice([7, 16, 24])
            mesh = tube_mesh(length / factor, profile, rings, around)
            periodic = rng.random() < 0.5
            args += ["--open-axis", "x"] if periodic or rng.random() < 0.5 else []
        else:
            a, b = rng.uniform(0, 0.25), rng.uniform(0, 0.2)
            mesh = sphere_mesh(lambda p: (size[0] / 2 + 2) / factor * (1 + a * p[2]**3 - b * p[0] * p[1]), 10)
            periodic = False
        name = put_mesh(problem, rng, "vessel", mesh)
        args += ["--vessel", name, str(factor)]
        if periodic:  # what is written in single precision may not repeat: five periods of what is read
            args += ["--ends", "periodic"]
            if problem["files"][name].startswith("base64:"):
                put(problem, name, text_of(mesh, "stl"))
            mesh = tube_mesh(length / factor, profile, rings, around, 5)
            oracle.append(f"period {length!r} 0 0")
        elif problem["files"][name].startswith("base64:"):
            mesh = single(mesh)
        put(problem, "lumen.off", text_of(([[factor * x for x in p] for p in mesh[0]], mesh[1]), "off"))
        oracle.append("inside mesh lumen.off")
        return None, [length / 2 if "length" in locals() else 0, 0, 0]
    return case(problem, rng, oracle, size)


def case(problem, rng, oracle, size):
    """A folder with config.xml: bodies, obstacles, regions."""
    body = rng.choice(["box", "cylinder", "sphere", "mesh"])
    low = [0.5, 0.5, 0.5]
    size = [x + 3 for x in size]
    if body == "box":
        center = [lo + x / 2 for lo, x in zip(low, size)]
        text = f'<box size="{" ".join(map(number, size))}" origin="0.5 0.5 0.5"/>'
        high = [lo + float(number(x)) for lo, x in zip(low, size)]
        oracle.append(f"inside box 0.5 0.5 0.5 {' '.join(map(repr, high))}")
    elif body == "cylinder":
        axis, radius = rng.randrange(3), float(number(size[0] / 2))
        center = [float(number(0.5 + radius))] * 3
        center[axis] = float(number(0.5 + size[1] / 2))
        text = (f'<cylinder axis="{"xyz"[axis]}" radius="{number(radius)}" length="{number(size[1])}" '
                f'center="{" ".join(map(number, center))}"/>')
        oracle.append(f"inside cylinder {axis} {' '.join(map(number, center))} {number(radius)} {number(size[1])}")
    elif body == "sphere":
        radius = float(number(size[0] / 2 + 1))
        center = [float(number(0.5 + radius))] * 3
        text = f'<sphere radius="{number(radius)}" center="{" ".join(map(number, center))}"/>'
        oracle.append(f"inside sphere {' '.join(map(number, center))} {number(radius)}")
    else:
        radius, a = size[0] / 2 + 1, rng.uniform(0, 0.2)
        mesh = sphere_mesh(lambda p: radius * (1 - a * p[2]**2))
        center = [float(number(0.6 + radius))] * 3
        name = put_mesh(problem, rng, "body", mesh)
        text = f'<mesh file="{name}" offset="{" ".join(map(number, center))}"/>'
        if problem["files"][name].startswith("base64:"):
            mesh = single(mesh)
        put(problem, "lumen.off", text_of(([[x + c for x, c in zip(p, center)] for p in mesh[0]], mesh[1]), "off"))
        oracle.append("inside mesh lumen.off")
    obstacles = ""
    for n in range(rng.choice([0, 0, 1, 1, 2])):
        where = [float(number(c + rng.uniform(-5, 5))) for c in center]
        kind, radius = rng.choice(["cylinder", "sphere", "mesh"]), float(number(rng.uniform(0.3, 3)))
        place = " ".join(map(number, where))
        if kind == "cylinder":
            axis = rng.randrange(3)
            obstacles += f'<cylinder axis="{"xyz"[axis]}" radius="{number(radius)}" length="80" center="{place}"/>'
            oracle.append(f"outside cylinder {axis} {place} {number(radius)} 80")
        elif kind == "sphere":
            obstacles += f'<sphere radius="{number(radius)}" center="{place}"/>'
            oracle.append(f"outside sphere {place} {number(radius)}")
        else:
            mesh = box_mesh((-radius, -1.0, -radius), (radius, 1.0, radius))
            put(problem, f"post{n}.off", text_of(mesh, "off"))
            placed = ([[x + c for x, c in zip(p, where)] for p in mesh[0]], mesh[1])
            put(problem, f"post{n}_oracle.off", text_of(placed, "off"))
            obstacles += f'<mesh file="post{n}.off" offset="{place}"/>'
            oracle.append(f"outside mesh post{n}_oracle.off")
    if obstacles:
        text += f"<obstacles>{obstacles}</obstacles>"
    region = ""
    if rng.random() < 0.25:
        region = (f'<region hematocrit="{rng.choice([0, 0.1, 0.3, 0.5])}"><sphere radius="{number(rng.uniform(2, 8))}" '
                  f'center="{" ".join(map(number, center))}"/></region>')
        problem["regions"] = True
    if body == "box":
        region += "<walls>xyz</walls>"
    nodes = int(2 * (max(size) + 6))
    newline = rng.choice(["\n", "\r\n"])
    problem["files"]["config.xml"] = newline.join([
        "<hemocell>", f"<domain><dx> 5e-7 </dx><nx>{nodes}</nx><ny>{nodes}</ny><nz>{nodes}</nz></domain>",
        f"<packing><container>{text}</container>", region, "</packing>", "</hemocell>", ""])
    problem["args"].insert(0, "config.xml")
    for name, radius, triangles, more in (("RBC", 3.91, 600, ""), ("WBC", 4, 600, ""),
                                          ("PLT", 1.25, 66, "<aspectRatio>0.434782608696</aspectRatio>")):
        problem["files"][f"{name}.xml"] = (f"<hemocell><MaterialModel><name>{name}</name><radius>{radius}e-6</radius>"
                                           f"<minNumTriangles>{triangles}</minNumTriangles>{more}</MaterialModel></hemocell>\n")
    return None, center


def random_problem(rng):
    problem = {"kind": "", "args": [], "files": {}, "ranks": rng.choices([1, 2, 3], [8, 1, 1])[0], "counts": {}}
    oracle, args = [], problem["args"]
    volume, center = lumen(problem, rng, oracle)
    wall = rng.choice([0, 0, 0, 0.1, 0.25, 1.0])
    clearance = rng.choice([0, 0, 0, 0.05, 0.25, 1.0])
    layer = rng.choice([0] * 6 + [0.5, 2])
    for option, value in (("--wall-clearance", wall), ("--clearance", clearance), ("--cell-free-layer", layer)):
        if value:
            args += [option, str(value)]
    has_wall = any(line.startswith("inside") for line in oracle)
    red_wall = max(wall, layer)
    oracle.append(f"clearance {clearance}")
    cells = []  # of the oracle
    cat = rng.random() < 0.06
    red = "model RBC 0.5"
    by_hematocrit = rng.random() < 0.6
    if by_hematocrit:
        value = rng.choice([rng.uniform(0.03, 0.3), rng.uniform(0.2, 0.45), rng.uniform(0.3, 0.5), rng.uniform(0.4, 0.95)])
        args += ["--hematocrit", number(value)]
        if volume and not problem.get("regions"):
            problem["hematocrit"], problem["volume"] = float(number(value)), volume
        cells.append(("RBC", red, red_wall))
        ratio = rng.choice([0, 0, 0.07, 0.5, 2])
        args += ["--plt_ratio", str(ratio)]
        problem["ratio"] = ratio
        if ratio:
            cells.append(("PLT", "model PLT 0.5", wall))
    else:
        count = rng.choice([1, 2, 3, rng.randrange(1, 12), rng.randrange(1, 60)])
        if rng.random() < 0.8:
            args += ["--rbc", str(count)]
            problem["counts"]["RBC"] = count
            cells.append(("RBC", red, red_wall))
        if rng.random() < 0.4 or not cells:
            count = rng.randrange(1, 20)
            args += ["--plt", str(count)]
            problem["counts"]["PLT"] = count
            cells.append(("PLT", "model PLT 0.5", wall))
    if rng.random() < 0.12:
        count = rng.randrange(1, 3)
        args += ["--wbc", str(count)]
        problem["counts"]["WBC"] = count
        cells.append(("WBC", "model WBC 0.5", wall))
    if rng.random() < 0.15:
        axes, count = [number(rng.uniform(0.5, 6)) for _ in range(3)], rng.randrange(1, 9)
        args += ["--cell", "egg", str(count), *axes]
        problem["counts"]["egg"] = count
        cells.append(("egg", f"ellipsoid {' '.join(axes)}", wall))
    if rng.random() < 0.2:
        shape, count = rng.randrange(4), rng.randrange(1, 9)
        if shape == 0:
            mesh = box_mesh((0, 0, 0), tuple(rng.uniform(0.5, 4) for _ in range(3)))
        elif shape == 1:
            dent = rng.uniform(0, 0.7)
            mesh = sphere_mesh(lambda p: 2.5 * (1 - dent * p[2]**4))
        elif shape == 2:
            mesh = sphere_mesh(lambda p: 2 * (1 + 0.5 * p[0] * p[1] + 0.3 * p[2]**3), rng.choice([4, 8, 12]))
        else:
            mesh = tube_mesh(rng.uniform(2, 7), lambda x, a: 0.6, 3, 8)
        scale = rng.choice([1, 1, 0.5, 1.3])
        name = put_mesh(problem, rng, "thing", mesh)
        args += ["--cell-mesh", "thing", str(count), name, "--mesh-scale", "thing", str(scale), "--mesh-frame", "thing", "file"]
        problem["counts"]["thing"] = count
        cells.append(("thing", f"mesh thing_oracle.off {scale}", wall))
    if rng.random() < 0.1:
        axis = [round(rng.uniform(-1, 1), 2) or 1.0 for _ in range(3)]
        spread = rng.choice([0, 5, 30, 90])
        args += ["--orient", cells[0][0], *map(str, axis), str(spread)]
        problem["orient"] = {cells[0][0]: (axis, spread)}
    if rng.random() < 0.06:
        args.append("--noRotate")
    how = rng.choices(["", "--fixed", "--start"], [16, 2, 2])[0]
    if how:
        name = cells[0][0]
        lines = []
        for _ in range(rng.randrange(1, 4)):
            lines.append([round(c + rng.uniform(-4, 4), 3) for c in center] + [float(rng.randrange(-90, 90)) for _ in range(3)])
        if rng.random() < 0.5:
            lines = lines[:1]
        problem["files"][f"before/{name}.pos"] = f"{len(lines)}\n" + "".join(" ".join(map(repr, line)) + "\n" for line in lines)
        args += [how, f"before/{name}.pos"]
        if how == "--fixed":
            problem["fixed"] = {name: lines}
    if cat:
        args += ["--method", "cat", "--builder", rng.choice(["chords", "cat-faces"])]
    args += ["--seed", str(rng.randrange(10**6)), "--max-time", "0.5"]
    if rng.random() < 0.1:
        args.append("--best-effort")
    for name, template, distance in cells:
        oracle.append(f"species {name}.pos {template} {distance if has_wall else 0}")
    problem["oracle"] = "\n".join(oracle) + "\n"
    return problem
