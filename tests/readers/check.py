"""Opens what `generate` exports in programs that others wrote, and compares it with itself.

    generate --width 1024 --textures --cube 256 --globe 256 --tables --geography --film 20 --frames 20 --out FOLDER
    python3 -m venv readers && readers/bin/pip install -r tests/readers/requirements.txt
    readers/bin/python tests/readers/check.py FOLDER

`--everything` fails where the validator cannot be installed.

GDAL (rasterio, pyogrio) reads pictures and GeoJSON, GPlates (pygplates) rotations and outlines, pandas
tables, trimesh and Khronos' validator (where npm can install it) the model, Pillow films. Sub-plates are
the common ground: places, heights, plates and areas of the table must be those of all other files.
"""

import json
import math
import shutil
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy
import pandas
import pygplates
import pyogrio
import rasterio
import shapely
import trimesh
from PIL import Image

# Maps of another planet have no place on Earth.
warnings.filterwarnings("ignore", category=rasterio.errors.NotGeoreferencedWarning)
folder = Path(sys.argv[1])
planet = json.loads((folder / "planet.json").read_text())
radius_km = planet["radius_km"]
failures = []


def check(name, value, most, unit=""):
    """A figure that must not be larger than `most`."""
    good = value <= most
    print(f"{'ok  ' if good else 'FAIL'} {name}: {value:.6g} {unit}(at most {most:g})")
    if not good:
        failures.append(name)


def unit_vectors(lat, lon):
    lat, lon = numpy.radians(lat), numpy.radians(lon)
    return numpy.stack([numpy.cos(lat) * numpy.cos(lon), numpy.cos(lat) * numpy.sin(lon), numpy.sin(lat)], -1)


def read(name):
    with rasterio.open(folder / name) as picture:
        return picture.read()


def pixel(picture, lat, lon):
    """The pixel of a rectangle that holds a place."""
    _, height, width = picture.shape
    x = numpy.clip(((lon + 180) * width / 360).astype(int), 0, width - 1)
    y = numpy.clip(((90 - lat) * height / 180).astype(int), 0, height - 1)
    return picture[:, y, x]


def metres(grey):
    return grey.astype(float) - 32768


def tables():
    sub_plates = pandas.read_csv(folder / "sub_plates.csv")
    plates = pandas.read_csv(folder / "plates.csv")
    check("sub-plates missing", abs(len(sub_plates) - planet["sub_plates"]), 0)
    sphere = 4 * math.pi * radius_km**2
    check("areas of sub-plates, share off the sphere", abs(sub_plates.area_km2.sum() / sphere - 1), 1e-9)
    summed = sub_plates.groupby("plate").area_km2.sum()
    areas = plates.set_index("plate").area_km2
    check("areas of plates, largest share off", float((summed / areas - 1).abs().max()), 1e-9)
    # Rigid rotations make the velocities of the table, but for margins that bend.
    places = unit_vectors(sub_plates.latitude, sub_plates.longitude)
    poles = plates.set_index("plate").loc[sub_plates.plate]
    spin = unit_vectors(poles.pole_latitude, poles.pole_longitude) * numpy.radians(poles.deg_per_my.values)[:, None]
    velocity = numpy.cross(spin, places) * radius_km
    east = numpy.cross([0, 0, 1], places)
    east /= numpy.linalg.norm(east, axis=1)[:, None]
    off = numpy.abs((velocity * east).sum(1) - sub_plates.velocity_east_mm_yr)
    check("eastward velocity, median off the rigid plate", float(off.median()), 1e-3, "mm/yr ")
    return sub_plates, plates


def maps(sub_plates):
    elevation = read("elevation.png")
    check("bits of elevation.png missing", 0 if elevation.dtype == numpy.uint16 else 1, 0)
    there = metres(pixel(elevation, sub_plates.latitude.values, sub_plates.longitude.values)[0])
    # Maps add terrain, so that single places differ; most do not by much.
    off = numpy.abs(there - sub_plates.elevation_m)
    check("heights at sub-plates, median off the table", float(off.median()), 120, "m ")
    plate = pixel(read("plate.png"), sub_plates.latitude.values, sub_plates.longitude.values)[0]
    check("sub-plates on another plate in plate.png, share", float((plate != sub_plates.plate).mean()), 0.1)
    return elevation


def normals(elevation):
    """Slopes of the heights' own differences, where they are gentle enough to be resolved."""
    heights = metres(elevation[0])
    rows, columns = heights.shape
    lat = numpy.radians(90 - (numpy.arange(rows) + 0.5) * 180 / rows)[:, None]
    step = 1000 * radius_km * math.pi / rows
    east = (numpy.roll(heights, -1, 1) - numpy.roll(heights, 1, 1)) / (2 * step * numpy.cos(lat))
    north = numpy.zeros_like(heights)
    north[1:-1] = (heights[:-2] - heights[2:]) / (2 * step)
    normal = read("normal.png").astype(float) / 32767.5 - 1
    check("length of normals, largest off 1", float(numpy.abs((normal**2).sum(0) - 1).max()), 1e-4)
    inner = slice(rows // 10, -rows // 10)
    for name, slope, part in [("east", east, normal[0]), ("north", north, normal[1])]:
        off = (numpy.abs(-part / normal[2] - slope) * numpy.cos(lat))[inner]
        # Half a metre of rounding on both sides of two pixels, and steps of 16 bits of the normal.
        check(f"slope to the {name}, largest off the heights", float(off.max()), 0.5 / step + 5e-5)


def cubes(elevation, colour):
    """Random directions looked up as the specification of OpenGL tells cube maps to be."""
    rng = numpy.random.default_rng(1)
    scene = rng.normal(size=(20000, 3))
    scene /= numpy.linalg.norm(scene, axis=1)[:, None]
    x, y, z = scene.T
    lat, lon = numpy.degrees(numpy.arcsin(y)), numpy.degrees(numpy.arctan2(-z, x))
    axis = numpy.abs(scene).argmax(1)
    major = numpy.abs(scene).max(1)
    positive = numpy.take_along_axis(scene, axis[:, None], 1)[:, 0] > 0
    sign = numpy.where(positive, 1, -1)
    s = numpy.choose(axis, [-sign * z, x, sign * x]) / major
    t = numpy.choose(axis, [-y, sign * z, -y]) / major
    names = numpy.array(["px", "nx", "py", "ny", "pz", "nz"])
    face = 2 * axis + numpy.where(positive, 0, 1)
    heights, colours = numpy.zeros(len(scene)), numpy.zeros((3, len(scene)))
    for i, name in enumerate(names):
        here = face == i
        for kind, bands in [("elevation", 1), ("normal", 3), ("colour", 3)]:
            picture = read(f"{kind}_{name}.png")
            check_shape = picture.shape[0] == bands and picture.shape[1] == picture.shape[2]
            if not check_shape:
                failures.append(f"{kind}_{name}.png")
            side = picture.shape[1]
            column = numpy.clip(((s[here] + 1) / 2 * side).astype(int), 0, side - 1)
            row = numpy.clip(((t[here] + 1) / 2 * side).astype(int), 0, side - 1)
            if kind == "elevation":
                heights[here] = metres(picture[0, row, column])
            elif kind == "colour":
                colours[:, here] = picture[:, row, column]
    off = numpy.abs(heights - metres(pixel(elevation, lat, lon)[0]))
    check("heights of the cube, median off the map", float(numpy.median(off)), 60, "m ")
    off = numpy.abs(colours - pixel(colour, lat, lon))
    check("colours of the cube, median off the map", float(numpy.median(off)), 4)


def outlines(sub_plates, plates):
    frame = pyogrio.raw.read(folder / "plates.geojson")
    fields, geometry, values = frame[0]["fields"], shapely.from_wkb(frame[2]), frame[3]
    ids = values[list(fields).index("plate")]
    check("plates without an outline", len(set(plates.plate) - set(ids)), 0)
    invalid = [i for i, g in zip(ids, geometry) if not g.is_valid]
    check(f"invalid outlines {invalid or ''}", len(invalid), 0)
    shapely.prepare(geometry)
    points = shapely.points(sub_plates.longitude, sub_plates.latitude)
    misplaced = 0
    for plate, outline in zip(ids, geometry):
        inside = shapely.contains(outline, points)
        misplaced += int((inside != (sub_plates.plate == plate)).sum())
    check("sub-plates on the wrong side of an outline", misplaced, 0)
    areas = plates.set_index("plate").area_km2
    for plate, outline in zip(ids, geometry):
        off = abs(spherical_area(outline) / areas[plate] - 1)
        if off > 1e-3:
            check(f"area of plate {plate}, share off the table", off, 1e-3)
    total = sum(spherical_area(outline) for outline in geometry)
    check("areas of outlines, share off the sphere", abs(total / (4 * math.pi * radius_km**2) - 1), 1e-5)

    frame = pyogrio.raw.read(folder / "boundaries.geojson")
    fields, geometry, values = list(frame[0]["fields"]), shapely.from_wkb(frame[2]), frame[3]
    lengths = values[fields.index("length_km")]
    measured = [great_circles(line) for line in geometry]
    check("length of boundaries, share off", abs(sum(measured) / lengths.sum() - 1), 1e-4)
    kinds = set(values[fields.index("kind")])
    check(f"unknown kinds in {sorted(kinds)}", len(kinds - {"ridge", "trench", "transform", "collision"}), 0)
    poles = pyogrio.read_info(folder / "poles.geojson")
    check("poles missing", abs(poles["features"] - len(plates)), 0)


def spherical_area(outline):
    """Exact for sides that are straight on the plane of longitude and latitude, which these nearly are."""
    area = 0.0
    for polygon in shapely.get_parts(outline):
        for ring in [polygon.exterior, *polygon.interiors]:
            lon, lat = numpy.radians(numpy.array(ring.coords).T)
            sine = numpy.sin(lat)
            area -= float(((lon[1:] - lon[:-1]) * (sine[1:] + sine[:-1]) / 2).sum())
    return area * radius_km**2


def great_circles(line):
    length = 0.0
    for part in shapely.get_parts(line):
        lon, lat = numpy.array(part.coords).T
        places = unit_vectors(lat, lon)
        chords = numpy.linalg.norm(places[1:] - places[:-1], axis=1)
        length += float((2 * numpy.arcsin(chords / 2)).sum())
    return length * radius_km


def rotations(plates):
    model = pygplates.RotationModel(str(folder / "rotations.rot"))
    worst = 0.0
    for row in plates.itertuples():
        back = model.get_rotation(1.0, int(row.plate))
        forth = model.get_rotation(0.0, int(row.plate), 1.0)
        pole, angle = forth.get_euler_pole_and_angle()
        if angle < 0:
            pole, angle = pygplates.PointOnSphere([-c for c in pole.to_xyz()]), -angle
        expected = unit_vectors(row.pole_latitude, row.pole_longitude) * math.radians(row.deg_per_my)
        worst = max(worst, float(numpy.abs(numpy.array(pole.to_xyz()) * angle - expected).max()))
        if back.represents_identity_rotation() and row.deg_per_my > 1e-3:
            failures.append(f"plate {row.plate} rests")
    check("rotations of the last My, largest off the table", worst, 1e-8, "rad ")

    # No outline is taken back to before its plate came to be.
    for feature in pygplates.FeatureCollection(str(folder / "plates.geojson")):
        begin, end = feature.get_valid_time()
        if not (math.isfinite(begin) and end == 0):
            failures.append(f"plate {feature.get_reconstruction_plate_id()} has no valid time")
    # Outlines taken back by 1 My, and where the table says that a corner was.
    features = pygplates.FeatureCollection(str(folder / "plates.geojson"))
    check("outlines that GPlates does not read", abs(len(features) - len(plates)), 0)
    moved = []
    pygplates.reconstruct(features, model, moved, 1.0)
    check("outlines that GPlates does not move", 0 if moved else 1, 0)
    by_plate = plates.set_index("plate")
    worst = 0.0
    for geometry in moved:
        row = by_plate.loc[geometry.get_feature().get_reconstruction_plate_id()]
        axis = unit_vectors(row.pole_latitude, row.pole_longitude)
        angle = -math.radians(row.deg_per_my)
        now = numpy.array(geometry.get_present_day_geometry().get_points()[0].to_xyz())
        then = numpy.array(geometry.get_reconstructed_geometry().get_points()[0].to_xyz())
        turned = (
            now * math.cos(angle)
            + numpy.cross(axis, now) * math.sin(angle)
            + axis * axis.dot(now) * (1 - math.cos(angle))
        )
        worst = max(worst, float(numpy.abs(turned - then).max()))
    check("corners of outlines 1 My ago, largest off", worst, 1e-8, "radii ")


def model(elevation):
    scene = trimesh.load(folder / "planet.glb")
    data = (folder / "planet.glb").read_bytes()
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    exaggeration = document["meshes"][0]["extras"]["exaggeration"]
    parts = list(scene.geometry.values())
    check("faces of the cube missing", abs(len(parts) - 6), 0)
    worst, off = 0.0, []
    for part in parts:
        heights = part.vertex_attributes["_ELEVATION"].reshape(-1)
        expected = 1 + exaggeration * numpy.maximum(heights, 0) / (1000 * radius_km)
        lengths = numpy.linalg.norm(part.vertices, axis=1)
        worst = max(worst, float(numpy.abs(lengths - expected).max()))
        x, y, z = (part.vertices / lengths[:, None]).T
        lat, lon = numpy.degrees(numpy.arcsin(numpy.clip(y, -1, 1))), numpy.degrees(numpy.arctan2(-z, x))
        off.append(numpy.abs(heights - metres(pixel(elevation, lat, lon)[0])))
        picture = part.visual.material.baseColorTexture
        if picture.size[0] != picture.size[1]:
            failures.append("a texture is not square")
    check("radius of the model's vertices, largest off their heights", worst, 2e-6, "radii ")
    check("heights of the model, median off the map", float(numpy.median(numpy.concatenate(off))), 60, "m ")
    whole = trimesh.util.concatenate([trimesh.Trimesh(p.vertices, p.faces, process=False) for p in parts])
    whole.merge_vertices(digits_vertex=6)
    check("holes between the faces", 0 if whole.is_watertight else 1, 0)
    check("faces that look inwards", 0 if whole.volume > 4 else 1, 0)


def validator():
    if not shutil.which("npm"):
        print("     skipped: no npm to install Khronos' glTF validator with")
        if "--everything" in sys.argv:
            failures.append("Khronos' validator")
        return
    with tempfile.TemporaryDirectory() as place:
        install = ["npm", "install", "--silent", "--prefix", place, "gltf-validator@2.0.0-dev.3.10"]
        subprocess.run(install, check=True, stdout=subprocess.DEVNULL)
        script = (
            "const v=require('gltf-validator'),fs=require('fs');"
            "v.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])))"
            ".then(r=>console.log(JSON.stringify(r.issues)))"
        )
        command = ["node", "-e", script, str((folder / "planet.glb").resolve())]
        output = subprocess.run(command, cwd=place, check=True, capture_output=True, text=True).stdout
        issues = json.loads(output)
        for message in issues["messages"][:5]:
            print("    ", message)
        found = sum(issues[kind] for kind in ["numErrors", "numWarnings", "numInfos", "numHints"])
        check("what Khronos' validator finds", found, 0)


def films():
    frames = sorted(folder.glob("map_[0-9]*.png"))
    film = Image.open(folder / "history.png")
    check("pictures of the film missing", abs(film.n_frames - len(frames)), 0)
    for number, frame in enumerate(frames):
        film.seek(number)
        same = numpy.array_equal(numpy.asarray(film.convert("RGB")), numpy.asarray(Image.open(frame)))
        if not same:
            failures.append(f"picture {number} of the film")
    last = numpy.array_equal(numpy.asarray(Image.open(frames[-1])), numpy.asarray(Image.open(folder / "map.png")))
    check("last picture that is not map.png", 0 if last else 1, 0)


sub_plates, plates = tables()
elevation = maps(sub_plates)
normals(elevation)
cubes(elevation, read("colour.png"))
outlines(sub_plates, plates)
rotations(plates)
model(elevation)
validator()
films()
if failures:
    sys.exit(f"{len(failures)} failed: {', '.join(failures[:10])}")
