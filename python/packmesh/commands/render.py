# SPDX-License-Identifier: AGPL-3.0-or-later
"""Pictures of packings by POV-Ray; needs no display.

    packmesh render [what] [picture.png] [width height] [options]

what is one of
  a folder      with the files of packMesh --vtp (default: the current one, also if only the picture is named)
  config.xml    the .pos files of a HemoCell case, as packMesh check config.xml --vtp would write them
  cells.h5      a state file (packMesh --state)
  cells.vtp     what catCells --vtp wrote
  cells.pov     a scene that was kept
  output        the output folder of a HemoCell run: its last step; with --every n a film of every n-th step
A state file and a run need h5py; for a case, the package must be installed with its C++ module.

  --scene cells.pov                 keep the scene, for POV-Ray itself
  --color species|gap|orientation   quantity shown by colour (orientation: symmetry axis along x red, y green, z blue)
  --max-gap d                       gaps of d µm and more are yellow (default: nine of ten cells have a smaller gap)
  --clip x=0.5                      cuts the scene at this fraction of the lumen's extent along x, y or z
  --show 1,5                        of what catCells wrote: draw only the cells of these objects
  --azimuth a --elevation e         direction of the camera [degrees]: azimuth 0 is +x, 90 is +y
  --turntable n                     n pictures around the scene: picture-000.png ..., and an animation if ffmpeg
                                    (picture.mp4) or ImageMagick (picture.gif) is installed
  --every n                         of a run: a picture of every n-th step, and an animation, as with --turntable
  --case config.xml                 of a run: its lumen and templates
  --quality draft|normal|fine       draft: hard edges; fine: smoother, soft shadows
  --size WxH                        the same as width height
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile

from packmesh.base import command, files
from packmesh.errors import InputError, OutputError
from packmesh.io import vtp
from packmesh.show import scene

OPTIONS = ("scene", "show", "color", "max-gap", "clip", "azimuth", "elevation", "turntable", "every", "case", "quality", "size")
QUALITIES = {"draft": ["-A"], "normal": ["+A0.2", "+AM2", "+R2"], "fine": ["+A0.05", "+AM2", "+R4", "Declare=Fine=1"]}
COLOURS = {"species": [], "gap": ["Declare=ColorBy=1"], "orientation": ["Declare=ColorBy=2"]}


def fail(text):
    raise command.UsageError(text)


def between(name, value, low, high):
    """The text of a number in that range."""
    if not re.fullmatch(r"-?[0-9]{0,9}\.?[0-9]{1,20}", value) or not low <= float(value) <= high:
        fail(f"{name}: expected a number in [{low}, {high}], found '{value}'")
    return value


def whole(name, value, low, high):
    if not re.fullmatch("[0-9]{1,6}", value):
        fail(f"{name}: expected a whole number in [{low}, {high}], found '{value}'")
    return int(between(name, value, low, high))


def one_of(name, value, choices):
    if value not in choices:
        fail(f"{name}: expected one of {' '.join(choices)}, found '{value}'")
    return value


def parse(arguments):
    """Positional words, and options by name."""
    words, options, left = [], {}, list(arguments)
    while left:
        word = left.pop(0)
        if not word.startswith("-"):
            words.append(word)
        elif word[2:] not in OPTIONS or not word.startswith("--"):
            fail(f"unknown option '{word}'; --help lists them")
        elif not left:
            fail(f"{word} needs a value")
        else:
            options[word[2:]] = left.pop(0)
    return words, options


def declarations(options):
    """What the scene is told."""
    told = []
    if "max-gap" in options:
        told.append("Declare=GapMost=" + between("--max-gap", options["max-gap"], 0.001, 1))
    if "clip" in options:
        found = re.fullmatch("([xyz])=(.+)", options["clip"])
        if not found:
            fail(f"--clip: expected an axis and a fraction such as x=0.5, found '{options['clip']}'")
        told += [f"Declare=ClipAxis={'xyz'.index(found[1]) + 1}", "Declare=ClipAt=" + between("--clip", found[2], 0, 1)]
    for name, least, most in (("azimuth", -360, 360), ("elevation", -89.9, 89.9)):
        if name in options:
            told.append(f"Declare={name.capitalize()}=" + between("--" + name, options[name], least, most))
    return told


def animation_of(base):
    """Of base-000.png and so on: a file with another ending beside them, None if no program makes it."""
    if shutil.which("ffmpeg"):
        made = base + ".mp4"
        words = [
            "ffmpeg", "-y", "-loglevel", "error", "-framerate", "15", "-i", base + "-%03d.png", "-vf",
            "scale=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p", made]
    elif shutil.which("magick"):
        made = base + ".gif"
        words = ["magick", "-delay", "7", "-loop", "0", *sorted(glob.glob(glob.escape(base) + "-[0-9]*.png")), made]
    else:
        files.say("No animation: neither ffmpeg nor ImageMagick is installed")
        return None
    if subprocess.run(words, check=False).returncode != 0:
        files.warn(f"No animation: {words[0]} failed")
        return None
    return made


def largest_gap(told, file):
    """The gap from which on cells are yellow: as stated, or of the scene."""
    for one in told:
        if one.startswith("Declare=GapMost="):
            return one.split("=")[2]
    with open(file, encoding="utf-8", errors="replace") as file:
        return next((found[1] for found in (re.match(r"#ifndef \(GapMost\) #declare GapMost = ([^;]*);", line)
                                            for line in file) if found), "?")


def write_case_files(what, folder):
    """The files of packMesh --vtp of a case, by the C++ module."""
    try:
        import packmesh
    except ImportError:
        raise command.UnusableError(
            f"{what}: the Python package packmesh is not installed with its C++ module; write the files for the picture by "
            "packMesh check config.xml --vtp, and render their folder") from None
    packmesh.Case(what).check(vtp=folder)


def read_cells(what):
    """The cells of all species in a state, a folder or a case, and the lumen. Raises InputError"""
    if what.endswith(".h5"):
        return scene.read_file(what)
    if os.path.isdir(what):
        return scene.read_packing(what)
    with tempfile.TemporaryDirectory() as folder:
        write_case_files(what, folder)
        return scene.read_packing(folder)


def is_run(what):
    """Whether this is the output folder of a HemoCell run."""
    return os.path.isdir(os.path.join(what, "hdf5"))


def write_film(what, case, every, folder):
    """Scenes of every n-th step of a run (None: the last one), with one camera. Their names. Raises InputError, OutputError"""
    from packmesh.run.hemocell_run import hemocell_output  # the rest of the module needs no NumPy

    run = hemocell_output(what, config=case)
    extents, scenes = None, []
    for step in run[::every] if every else [run[-1]]:
        species, lumen = scene.read_cells(step.packing().cells_file())
        extents = extents or scene.extents_of(species, lumen)
        scenes.append(os.path.join(folder, f"step-{len(scenes):03d}.pov"))
        scene.write(scenes[-1], scene.packing_scene(species, lumen, extents))
    return scenes


def write_scene(what, shown, target, color="species"):
    """Of anything but a scene or a run. Raises InputError, OutputError"""
    if what.endswith(".vtp"):
        surface = vtp.read(what)
        try:
            scene.write(target, scene.cat_scene(surface, shown))
        except InputError as error:
            raise InputError(f"{what}: {error}") from None
        return
    species, lumen = read_cells(what)
    if color == "gap" and species and not scene.has_gaps(species):
        raise InputError(f"--color gap: {what} has no gaps: its cells are not those of a finished packing")
    scene.write(target, scene.packing_scene(species, lumen))


def picture_of(what):
    """The name of the picture, unless it is stated."""
    if os.path.isdir(what):
        return os.path.join(what, "cells.png")
    base, ending = os.path.splitext(what)
    return os.path.join(os.path.dirname(what), "cells.png") if ending == ".xml" else base + ".png"


def size_of(words, options):
    """Width and height in pixels."""
    width, height = "1200", None
    if "size" in options:
        found = re.fullmatch("([0-9]+)x([0-9]+)", options["size"])
        if not found:
            fail(f"--size: expected WIDTHxHEIGHT such as 1200x800, found '{options['size']}'")
        width, height = found.groups()
    width = whole("width", words[2] if len(words) > 2 else width, 16, 20000)
    return width, whole("height", words[3] if len(words) > 3 else height or str(width * 2 // 3), 16, 20000)


def rendered(work, file, picture, size, arguments):
    """One picture in the folder `work`: POV-Ray may only write below the folder it runs in."""
    done = subprocess.run(["povray", "+Iscene.pov", "+O" + picture, f"+W{size[0]}", f"+H{size[1]}", *arguments, "-D", "-GA"],
                          cwd=work, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", check=False)
    if done.returncode != 0 or not os.path.isfile(os.path.join(work, picture)):
        print("\n".join(done.stdout.splitlines()[-20:]), file=sys.stderr)
        raise InputError(f"{file}: povray fails on it")


def contents_of(path):
    with open(path, "rb") as file:
        yield from iter(lambda: file.read(1 << 20), b"")


def render(frames, picture, size, arguments):
    """A picture of each scene, turned by an angle [degrees]; all are written, or none. Raises InputError, OutputError"""
    base, film = re.sub(r"\.png$", "", picture), len(frames) > 1
    with tempfile.TemporaryDirectory() as work, files.Outputs() as outputs:
        for frame, (file, turn) in enumerate(frames):
            shutil.copy(file, os.path.join(work, "scene.pov"))
            rendered(work, file, f"picture-{frame:03d}.png", size, [*arguments, f"Declare=Turn={turn:g}"])
            outputs.write(f"{base}-{frame:03d}.png" if film else picture,
                          contents_of(os.path.join(work, f"picture-{frame:03d}.png")))
        animation = animation_of(os.path.join(work, "picture")) if film else None
        if animation:
            outputs.write(base + os.path.splitext(animation)[1], contents_of(animation))
        outputs.commit()
    files.say(f"Wrote {base}-000.png to {base}-{len(frames) - 1:03d}.png" if film else f"Wrote {picture}")
    if animation:
        files.say(f"Wrote {base}{os.path.splitext(animation)[1]}")


def main(arguments=None):
    arguments = sys.argv[1:] if arguments is None else arguments
    if "-h" in arguments or "--help" in arguments:
        print(__doc__)
        return
    words, options = parse(arguments)
    if words and words[0].endswith(".png"):
        words.insert(0, ".")
    if len(words) > 4:
        fail(f"expected at most four words, found '{words[4]}'; --help lists them")
    told = declarations(options)
    turntable = whole("--turntable", options["turntable"], 2, 3600) if "turntable" in options else 0
    every = whole("--every", options["every"], 1, 999999) if "every" in options else None
    size = size_of(words, options)
    color = one_of("--color", options.get("color", "species"), COLOURS)
    quality = one_of("--quality", options.get("quality", "normal"), QUALITIES)
    shown = [whole("--show", one, 1, 999999) for one in options["show"].split(",")] if "show" in options else []
    what = words[0] if words else "."
    ending = "" if os.path.isdir(what) else os.path.splitext(what)[1]
    if not os.access(what, os.R_OK):
        raise InputError(f"there is no readable '{what}'")
    if not os.path.isdir(what) and ending not in (".pov", ".vtp", ".h5", ".xml"):
        fail(f"{what}: is none of what can be rendered: a folder, config.xml, a state (.h5), .vtp or .pov; --help explains")
    if ("every" in options or "case" in options) and not is_run(what):
        fail("--every, --case: are for the output folder of a run")
    if is_run(what) and ("scene" in options or (turntable and every)):
        fail("--scene, --turntable: not of a series of steps; packmesh run output --state cells.h5 keeps a step")
    if shown and ending != ".vtp":
        fail("--show: is for files of catCells --vtp")
    if ending == ".pov" and "scene" in options:
        fail(f"--scene: {what} is a scene")
    picture = os.path.realpath(words[1] if len(words) > 1 else picture_of(what))
    if not os.path.isdir(os.path.dirname(picture)):
        raise OutputError(f"there is no folder '{os.path.dirname(picture)}'")
    with tempfile.TemporaryDirectory() as work:
        file, scenes = what, []
        if is_run(what):
            if color == "gap":
                fail("--color gap: the gaps of cells of a run are not known")
            scenes = write_film(what, options.get("case"), every, work)
            file = scenes[0]
        elif ending != ".pov":
            file = options.get("scene", os.path.join(work, "cells.pov"))
            write_scene(what, shown, file, color)
            if "scene" in options:
                files.say(f"Wrote {file}")
        if not shutil.which("povray"):
            raise command.UnusableError("povray is not installed (Debian: povray)")
        turns = [(file, 360 * frame / (turntable or 1)) for frame in range(turntable or 1)]
        render([(one, 0) for one in scenes] if every else turns, picture, size, [*QUALITIES[quality], *told, *COLOURS[color]])
        if color == "gap":
            files.say(f"Colours: gap 0 dark violet, {largest_gap(told, file)} µm and more yellow")
