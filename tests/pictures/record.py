#!/usr/bin/env python3
"""What may not change when the code is only moved: hashes of renders and exports, by any build of taut.

    python3 tests/pictures/record.py build/release/taut FOLDER [PART]   renders, exports, writes FOLDER/hashes.tsv; PART: only
                                                                        pictures whose name holds it, no exports
    python3 tests/pictures/record.py --compare FOLDER FOLDER        same? else the largest relative difference of each picture

A picture's hash is that of its pixels and of what `oiiotool --info -v` says about it, without name and times; an export's that of its
bytes. Hashes hold for one machine (the C library picks its functions by processor): record both builds on the same one. Real characters
come from the folder TAUT_ASSETS, else ../shared/assets, and are left out, visibly, where that is missing.
"""

import hashlib
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
ASSETS = pathlib.Path(os.environ.get("TAUT_ASSETS", ROOT.parent / "shared" / "assets"))
SMALL = ["-D", "render.width=96", "-D", "render.height=72", "--spp", "8"]

HEAD = """
[render]
width = 96
height = 72
spp = 8
frames = "1-24"
[camera]
position = [0.4, -3.2, 2.2]
look_at = [0, 0, 0.2]
"""
PANEL = """
[[mesh]]
file = "MESHES/panel.obj"
material = "m"
"""
SHEAR = """
[[mesh.deform]]
type = "shear"
plane = "xy"
amount = [[1, 0.0], [24, 1.2]]
"""
STUDIO = '\n[environment]\npreset = "studio"\n'
QUAD = "\n[[light]]\ntype = \"quad\"\ncorner = [1, -1, 3]\nu = [-2, 0, 0]\nv = [0, 2, 0]\nradiance = 8\n"
BODY = '\n[[mesh]]\nfile = "MESHES/body.obj"\nmaterial = "m"\ntranslate = [0, 0, 0.3]\nscale = 0.8\n'
TWIST = '\n[[mesh.deform]]\ntype = "twist"\naxis = "z"\nangle_deg = [[1, 0], [24, 160]]\n'
GROUND = '\n[material.ground]\ncolor = [0.3, 0.35, 0.4]\n\n[[mesh]]\nfile = "MESHES/ground.obj"\nmaterial = "ground"\ntranslate = [0, 0, -0.6]\n'
EMITTER = '\n[[mesh]]\nfile = "MESHES/ring.obj"\nname = "lamp"\nmaterial = "m"\ntranslate = [0, 0, 1.6]\nscale = 0.6\n\n[[light]]\ntype = "mesh"\nmesh = "lamp"\nradiance = [6, 5, 4]\ntwo_sided = true\n'


def material(text):
    return "\n[material.m]\n" + text + "\n"


METAL = material('type = "conductor"\nalpha = [0.08, 0.4]')
LIGHTS = "".join(
    "\n[[light]]\ntype = \"%s\"\n%s\n" % (kind, keys)
    for kind, keys in [
        ("sphere", "centre = [2, 0, 2]\nradius = 0.2\nradiance = 20\ncamera_visible = true"),
        ("directional", "direction = [0.3, 0.2, -1]\nirradiance = 2"),
        ("point", "position = [0, 0, 2]\nintensity = 3"),
        ("spot", "position = [0, -2, 2]\ndirection = [0, 1, -1]\nintensity = 4\nouter_deg = 30"),
    ])
MANY = "".join("\n[[light]]\ntype = \"point\"\nposition = [%g, %g, 1.5]\nintensity = 0.2\n" % (x * 0.3 - 1, y * 0.3 - 1)
               for x in range(6) for y in range(6))

# name, scene, arguments
SCENES = [
    ("sheared panel", HEAD + METAL + STUDIO + PANEL + SHEAR, ["--frames", "1,12,24"]),
    ("held fixed", HEAD + METAL + STUDIO + PANEL + SHEAR, ["--frames", "24", "-D", "mesh.0.follow=false"]),
    ("full model", HEAD + METAL + STUDIO + PANEL + SHEAR, ["--frames", "24", "--model", "full"]),
    ("tolerance 0.2", HEAD + METAL + STUDIO + PANEL + SHEAR, ["--frames", "24", "--tolerance", "0.2"]),
    ("aovs", HEAD + METAL + STUDIO + PANEL + SHEAR, ["--frames", "12", "--aov", "all"]),
    ("adaptive", HEAD + METAL + STUDIO + PANEL + SHEAR, ["--frames", "12", "--noise", "0.1", "--spp", "64"]),
    ("one thread", HEAD + METAL + QUAD + PANEL + SHEAR, ["--frames", "12", "-t", "1"]),
    ("crop and seed", HEAD + METAL + QUAD + PANEL + SHEAR, ["--frames", "12", "--crop", "10,20,70,60", "--seed", "7"]),
    ("motion blur", HEAD + METAL + QUAD + PANEL + SHEAR, ["--frames", "12", "-D", "render.shutter=4"]),
    ("blurred rigid", HEAD + METAL + QUAD + GROUND + BODY + "rotate_deg = [[1, [0, 0, 0]], [24, [90, 0, 180]]]\n",
     ["--frames", "12", "-D", "render.shutter=2"]),
    ("leaning", HEAD + METAL + QUAD + PANEL + "lean = true\n" + SHEAR.replace("xy", "xz"), ["--frames", "20"]),
    ("poisson", HEAD + METAL + "poisson = 0.4\n" + QUAD + PANEL + SHEAR, ["--frames", "20"]),
    ("walk", HEAD + material('type = "conductor"\nf0 = [0.9, 0.6, 0.3]\nalpha = [0.5, 0.9]\nmultiscatter = "walk"') + QUAD + PANEL + SHEAR,
     ["--frames", "20"]),
    ("compensation", HEAD + material('type = "conductor"\nmetal = "Cu"\nalpha = 0.6\nmultiscatter = "compensation"') + STUDIO + BODY + TWIST,
     ["--frames", "20"]),
    ("glass", HEAD + material('type = "dielectric"\nior = 1.4\nalpha = [0.05, 0.2]') + QUAD + STUDIO + GROUND + BODY + TWIST,
     ["--frames", "20"]),
    ("glass walk", HEAD + material('type = "dielectric"\nalpha = 0.4\nmultiscatter = "walk"') + STUDIO + BODY + TWIST, ["--frames", "9"]),
    ("separable glass", HEAD + material('type = "dielectric"\nalpha = 0.3\nmasking = "separable"') + STUDIO + BODY + TWIST,
     ["--frames", "9"]),
    ("coated", HEAD + material('type = "coated"\ncolor = [0.6, 0.2, 0.1]\nalpha = 0.1') + STUDIO + GROUND + BODY + TWIST,
     ["--frames", "12"]),
    ("metallic roughness", HEAD + material('type = "metallic_roughness"\ncolor = [0.5, 0.1, 0.1]\nmetallic = 0.3\nroughness = 0.5\nanisotropy = 0.6')
     + STUDIO + BODY + TWIST, ["--frames", "12"]),
    ("every light", HEAD + METAL + LIGHTS + QUAD + GROUND + PANEL + SHEAR, ["--frames", "12"]),
    ("many lights", HEAD + METAL + MANY + GROUND + PANEL + SHEAR, ["--frames", "12"]),
    ("emitter", HEAD + METAL + EMITTER + GROUND + BODY + TWIST, ["--frames", "12"]),
    ("constant sky", HEAD + METAL + "\n[environment]\nradiance = [0.4, 0.45, 0.5]\nscale = 2\n" + GROUND + BODY + TWIST, ["--frames", "12"]),
    ("subdivided", HEAD + METAL + STUDIO + BODY.replace("body", "twist_bar") + "subdivision = 2\ncrease_deg = 60\n" + TWIST,
     ["--frames", "1,20"]),
    ("planned level", HEAD + METAL + STUDIO + BODY.replace("body", "twist_bar") + 'subdivision = "auto"\n' + TWIST,
     ["--frames", "20", "--tolerance", "0.1"]),
    ("estimators", HEAD + METAL + STUDIO + "".join(PANEL.replace('"m"', '"m"\ngradient = "%s"\ntranslate = [0, 0, %g]' % (g, -z / 3)) + SHEAR
                                                   for z, g in enumerate(["face", "area", "angle", "least-squares", "analytic"])),
     ["--frames", "20"]),
    ("interpolations", HEAD + METAL + STUDIO + "".join(
        PANEL.replace('"m"', '"m"\ninterpolation = "%s"\ntranslate = [0, 0, %g]' % (g, -z / 3)) + SHEAR
        for z, g in enumerate(["stretch", "ds-dt", "cholesky", "log", "face"])), ["--frames", "20"]),
    ("rest at a frame", HEAD + METAL + STUDIO + PANEL + 'rest = "frame 8"\n' + SHEAR, ["--frames", "20"]),
    ("lattice and wave", HEAD + METAL + STUDIO + PANEL + '[[mesh.deform]]\ntype = "lattice"\nlower = [-1, -1, -1]\nupper = [1, 1, 1]\n'
     'points = [3, 3, 2]\noffsets = [[1, 1, 0, 0, 0, 0.4], [1, 1, 1, 0, 0, 0.4]]\n[[mesh.deform]]\ntype = "wave"\naxis = "x"\n'
     'direction = "z"\namplitude = 0.1\nwavelength = 0.7\nphase_deg = [[1, 0], [24, 360]]\n', ["--frames", "1,20"]),
    ("lens", HEAD.replace("look_at", "aperture_radius = 0.1\nfocus_distance = 3\nlook_at") + METAL + STUDIO + PANEL + SHEAR,
     ["--frames", "12"]),
    ("moving camera", HEAD.replace("position = [0.4, -3.2, 2.2]", "position = [[1, [0.4, -3.2, 2.2]], [24, [1.4, -2.2, 2.0]]]") + METAL + STUDIO
     + PANEL + SHEAR, ["--frames", "1,12", "-D", "render.shutter=1"]),
    ("box filter, one event", HEAD + METAL + QUAD + PANEL + SHEAR, ["--frames", "12", "-D", "render.filter=box", "-D", "render.max_events=1"]),
]
FILES = [
    ("demo panel", ROOT / "apps/demo/panel.toml", ["--frames", "1,24"]),
    ("demo body", ROOT / "apps/demo/body.toml", ["--frames", "1,20"]),
    ("demo plates", ROOT / "apps/demo/plates.toml", ["--frames", "1"]),
    ("bare mesh", ROOT / "meshes/body.obj", ["--frames", "1"]),
    ("fox", ASSETS / "anim/khronos/Fox.glb", ["--frames", "1,9"]),
    ("walking man", ASSETS / "anim/khronos/CesiumMan.glb", ["--frames", "1,20"]),
    ("knight", ASSETS / "anim/kaykit/Knight.glb", ["--frames", "5", "-D", "mesh.0.clip=3"]),
    ("morphs", ASSETS / "anim/khronos/AnimatedMorphSphere.glb", ["--frames", "1,30", "-D", "render.shutter=1"]),
    ("interpolation", ASSETS / "anim/khronos/InterpolationTest.glb", ["--frames", "10"]),
    ("anisotropy", ASSETS / "anim/khronos/AnisotropyRotationTest.glb", ["--frames", "1"]),
    ("skinned cylinder", ASSETS / "anim/blender_io/03_skinned_cylinder/03_skinned_cylinder.gltf", ["--frames", "12"]),
    ("cage", ASSETS / "static/spot_control_mesh.obj", ["--frames", "1", "-D", "mesh.0.subdivision=3"]),
    ("creased cage", ASSETS / "subd/shapes/catmark_cube_creases0.obj", ["--frames", "1", "-D", "mesh.0.subdivision=3"]),
    ("sequence", ASSETS / "seq/kick_obj/kick.####.obj", ["--frames", "4,6"]),
]
if ASSETS.is_dir():
    SCENES.append(("environment map", HEAD + METAL + '\n[environment]\nfile = "%s"\nrotation_deg = 30\n' % (ASSETS / "hdr/venice_sunset_1k.hdr")
                   + GROUND + BODY + TWIST, ["--frames", "12"]))
    SCENES.append(("point cache", HEAD + METAL + STUDIO + '[[mesh]]\nfile = "%s"\ncache = "%s"\nmaterial = "m"\n'
                   % (ASSETS / "seq/kick_obj/kick.0000.obj", ASSETS / "seq/kick_f00-60_step3.pc2"), ["--frames", "4,6"]))
EXPORTS = ["ply", "csv", "npz", "glb", "gltf", "usda"]
CACHES = ["usda", "pc2", "mdd"]


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit("%s\n%s%s" % (" ".join(map(str, command)), done.stdout, done.stderr))
    return done.stdout


def picture_hash(path):
    pixels = re.search(r"SHA-1: (\w+)", run("oiiotool", "--info", "--hash", path)).group(1)
    said = [line for line in run("oiiotool", "--info", "-v", path).splitlines() if not re.search(r"DateTime|renderSeconds|sceneHash|%s" % re.escape(str(path)), line)]
    return pixels[:20] + "-" + hashlib.sha256("\n".join(said).encode()).hexdigest()[:12]


def record(taut, folder, part):
    folder.mkdir(parents=True, exist_ok=True)
    jobs = [(name, text.replace("MESHES", str(ROOT / "meshes")), arguments) for name, text, arguments in SCENES]
    jobs = [job for job in jobs + FILES if part in job[0]]
    rows = []
    for name, scene, arguments in jobs:
        stem = name.replace(" ", "_").replace(",", "")
        if isinstance(scene, str):
            path = folder / (stem + ".toml")
            path.write_text(scene)
        else:
            path = scene
            if "####" not in path.name and not path.exists():
                print("left out, for there is no", path)
                continue
            if "####" in path.name and not path.parent.is_dir():
                print("left out, for there is no", path.parent)
                continue
        if "####" in path.name:  # a pattern is no scene of its own
            toml = folder / (stem + ".toml")
            toml.write_text(HEAD + METAL + STUDIO + '[[mesh]]\nfile = "%s"\nmaterial = "m"\n' % path)
            path = toml
        size = [] if "####" in str(scene) else SMALL
        spp = [] if "--spp" in arguments else size
        run(taut, "render", path, *(spp or size[:4]), *arguments, "-o", folder / (stem + ".####.exr"), "-q")
        for image in sorted(folder.glob(stem + ".[0-9][0-9][0-9][0-9].exr")):
            rows.append((image.name, picture_hash(image)))
    if not part:
        record_exports(taut, folder)
    for file in sorted(p for p in folder.iterdir() if p.name.startswith(("body.", "man."))):
        rows.append((file.name, hashlib.sha256(file.read_bytes()).hexdigest()[:32]))
    (folder / "hashes.tsv").write_text("".join("%s\t%s\n" % row for row in rows))
    print("%d pictures, %d files" % (sum(n.endswith(".exr") for n, _ in rows), sum(not n.endswith(".exr") for n, _ in rows)))


def record_exports(taut, folder):
    body = folder / "export.toml"
    body.write_text((HEAD + METAL + STUDIO + BODY + TWIST).replace("MESHES", str(ROOT / "meshes")))
    for convention in ["matrix", "alpha", "blender", "blender_anisotropic", "openpbr", "materialx", "khr"]:
        run(taut, "export", body, "--frames", "12", "--convention", convention, "-q",
            *sum((["-o", folder / ("body.%s.####.%s" % (convention, kind))] for kind in EXPORTS), []))
    run(taut, "export", body, "--frames", "1-24x11", "-q", *sum((["-o", folder / ("body." + kind)] for kind in CACHES), []))
    run(taut, "export", body, "--frames", "12", "--ascii", "--level", "1", "-q", "-o", folder / "body.text.####.ply")
    if (ASSETS / "anim").is_dir():
        run(taut, "export", ASSETS / "anim/khronos/CesiumMan.glb", "--frames", "1,12", "-q",
            *sum((["-o", folder / ("man.####." + kind)] for kind in EXPORTS), []))


def largest_difference(a, b):
    """Over all pixels and channels, |a - b| / max(|a|, 1e-6)."""
    stats = run("oiiotool", a, b, "--absdiff", a, "--abs", "--maxc", "1e-6", "--div", "--printstats")
    return max(float(x) for x in re.search(r"Stats Max: ([^(\n]*)", stats).group(1).split())


def compare(one, two):
    """Pictures that both have recorded, and what only one has."""
    tables = [dict(line.split("\t") for line in (folder / "hashes.tsv").read_text().splitlines()) for folder in (one, two)]
    differ = [name for name in tables[0] if tables[0][name] != tables[1].get(name)] + [n for n in tables[1] if n not in tables[0]]
    for name in differ:
        both = (one / name).exists() and (two / name).exists()
        pixels = tables[0].get(name, "").split("-")[0] != tables[1].get(name, "").split("-")[0]
        what = "only in one" if not both else "metadata" if name.endswith(".exr") and not pixels else \
            "%.3g" % largest_difference(one / name, two / name) if name.endswith(".exr") else "bytes"
        print("%s\t%s" % (name, what))
    print("%d of %d the same" % (len(tables[0]) - len([n for n in differ if n in tables[0]]), len(tables[0])))
    return 1 if differ else 0


if __name__ == "__main__":
    if len(sys.argv) == 4 and sys.argv[1] == "--compare":
        sys.exit(compare(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])))
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    record(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), sys.argv[3] if len(sys.argv) > 3 else "")
