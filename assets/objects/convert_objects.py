"""Small things from the free catalogues of Sweet Home 3D as GLB: metres, Y up, front +Z, origin in the middle of the
underside, at most LIMIT triangles. Kept as a record. Needs the unpacked catalogues (`unzip NAME.sh3f -d deb/NAME`), the
catalogue as CSV, and Python with trimesh, Pillow and fast_simplification.

    python convert_objects.py CATALOGUE.csv deb OUT
"""
import csv
import io
import os
import sys

import fast_simplification
import numpy as np
import trimesh
from PIL import Image

LIMIT = 3600  # triangles of one object: under 5,000, and quick to test for collisions
SIDE = 256  # pixels of a texture's longer side
LICENCE = {"BlendSwap-CC-0": "CC0", "BlendSwap-CC-BY": "CC-BY-3.0", "KatorLegaz": "CC-BY-3.0-US", "Scopia": "CC-BY-3.0"}

# kind, catalogue, model
SELECTION = """
laptop BlendSwap-CC-BY laptop
laptop KatorLegaz apple-ibook-2001
computer KatorLegaz apple-imac-1998
monitor Scopia apple_pc
desk_lamp Scopia desk_lamp1
desk_lamp Scopia desk_lamp2
cup BlendSwap-CC-0 caffe_final
cup BlendSwap-CC-BY coffee_cup
cup Scopia cup
glass KatorLegaz highball-glass
wine_glass BlendSwap-CC-BY glass
wine_glass BlendSwap-CC-BY cocktailGlass
glass BlendSwap-CC-0 beerGlass
bottle KatorLegaz red-wine-bottle-01
bottle BlendSwap-CC-BY beer_bottle
bottle BlendSwap-CC-0 yogurtBottle
milk BlendSwap-CC-0 tetrapak
plate KatorLegaz dinner-plate
salad Scopia bowlWithSalad
fork BlendSwap-CC-BY fork
knife BlendSwap-CC-BY knife
spoon BlendSwap-CC-BY spoon
kitchen_knife BlendSwap-CC-BY kitchenKnife
burger BlendSwap-CC-BY hamburger
hot_dog BlendSwap-CC-0 hotDog
fruit_bowl Scopia bowlWithFruits
fruit_bowl Scopia apples
cake Scopia birthday_cake
cupcake BlendSwap-CC-0 cupcake
fries Scopia frenchFries
cell_phone BlendSwap-CC-0 iphone
cell_phone BlendSwap-CC-BY mobile
phone Scopia phone
tv Scopia tv
bag BlendSwap-CC-0 handbag
bag BlendSwap-CC-BY backpack
clothes Scopia blouson
clothes Scopia short-shadows
clothes Scopia jupe
hat Scopia casquette
hat Scopia chapeau
plant BlendSwap-CC-BY succulentPlant
plant BlendSwap-CC-0 cactus
clock BlendSwap-CC-BY clock
pen Scopia pencil1
pen BlendSwap-CC-0 textMarker
box Scopia cardboard-box
toy BlendSwap-CC-0 teddyBear
toy BlendSwap-CC-BY toyTrain
toy BlendSwap-CC-0 woodToy
chopping_board BlendSwap-CC-BY choppingBoard
pot BlendSwap-CC-BY largePan
teapot Scopia teapot
kettle BlendSwap-CC-BY espressokettle
kettle BlendSwap-CC-BY boiler
microwave BlendSwap-CC-BY microwave
toaster Scopia toaster
scissors BlendSwap-CC-0 cissors_swap
headphones BlendSwap-CC-0 headphones
stapler KatorLegaz stapler
salt BlendSwap-CC-BY saltShaker
tray Scopia tray
glasses Scopia glasses
camera Scopia basic_camera
shoes BlendSwap-CC-0 slippers
shoes Scopia woman_shoes
""".split("\n")


def materials_of(obj, folder):
    known, current = {}, None
    for line in open(obj, errors="replace"):
        word = line.split()
        if not word or word[0] != "mtllib":
            continue
        path = os.path.join(folder, " ".join(word[1:]))
        if not os.path.exists(path):
            continue
        for entry in open(path, errors="replace"):
            field = entry.split()
            if not field:
                continue
            if field[0] == "newmtl":
                current = field[1]
                known[current] = {"kd": [0.8] * 3, "d": 1.0, "tex": None}
            elif current and field[0] == "Kd":
                known[current]["kd"] = [float(x) for x in field[1:4]]
            elif current and field[0] == "d":
                known[current]["d"] = float(field[-1])
            elif current and field[0] == "map_Kd":
                known[current]["tex"] = os.path.join(folder, " ".join(field[1:]))
    return known


def read_obj(path):
    points, uvs, parts, name = [], [], {}, "default"
    for line in open(path, errors="replace"):
        word = line.split()
        if not word:
            continue
        if word[0] == "v":
            points.append([float(x) for x in word[1:4]])
        elif word[0] == "vt":
            uvs.append([float(x) for x in word[1:3]])
        elif word[0] == "usemtl":
            name = word[1] if len(word) > 1 else "default"
        elif word[0] == "f":
            corners = []
            for item in word[1:]:
                split = item.split("/")
                p = int(split[0])
                t = int(split[1]) if len(split) > 1 and split[1] else 0
                corners.append((p - 1 if p > 0 else len(points) + p, t - 1 if t > 0 else (len(uvs) + t if t < 0 else -1)))
            for j in range(1, len(corners) - 1):
                parts.setdefault(name, []).append((corners[0], corners[j], corners[j + 1]))
    return np.array(points), np.array(uvs) if uvs else np.zeros((1, 2)), parts


def sized(points, parts, row):
    used = np.unique([c[0] for faces in parts.values() for f in faces for c in f])
    middle = (points[used].min(0) + points[used].max(0)) / 2
    turn = np.array([float(x) for x in row["rot"].split()]).reshape(3, 3) if row["rot"] else np.eye(3)
    points = (points - middle) @ turn.T
    low, high = points[used].min(0), points[used].max(0)
    size = np.array([float(row["w"]), float(row["h"]), float(row["d"])]) / 100
    points = (points - (low + high) / 2) / np.maximum(high - low, 1e-9) * size
    points[:, 1] += size[1] / 2
    return points, size


def simplified(points, faces, share):
    """Fewer triangles; texture coordinates are lost."""
    merged = trimesh.Trimesh(points, faces, process=True)
    if len(merged.faces) < 24:
        return merged.vertices, merged.faces
    keep = max(20, int(len(merged.faces) * share))
    v, f = fast_simplification.simplify(merged.vertices.astype(np.float32), merged.faces, target_count=keep, agg=4)
    return v, f


def average(path):
    return [c / 255 for c in np.asarray(Image.open(path).convert("RGB").resize((16, 16))).reshape(-1, 3).mean(0)]


def material(name, look, textured):
    color = look["kd"] if textured or not look["tex"] else average(look["tex"])
    alpha = look["d"] if look["d"] > 0 else 1
    arguments = dict(name=name, metallicFactor=0.0, roughnessFactor=0.6, doubleSided=True)
    arguments["baseColorFactor"] = [int(255 * min(1, max(0, x))) for x in (*color, alpha)]
    if alpha < 1:
        arguments["alphaMode"] = "BLEND"
    if textured:
        picture = Image.open(look["tex"]).convert("RGB")
        picture.thumbnail((SIDE, SIDE))
        data = io.BytesIO()
        picture.save(data, "JPEG", quality=82)
        data.seek(0)
        arguments["baseColorTexture"] = Image.open(data)
        arguments["baseColorFactor"][:3] = [255] * 3
    return trimesh.visual.material.PBRMaterial(**arguments)


def convert(kind, catalogue, base, rows, deb, out):
    row = next(r for r in rows if r["cat"] == catalogue and r["model"].split("/")[-1] == base + ".obj")
    path = os.path.join(deb, catalogue) + row["model"]
    folder = os.path.dirname(path)
    points, uvs, parts = read_obj(path)
    looks = materials_of(path, folder)
    points, size = sized(points, parts, row)
    total = sum(len(f) for f in parts.values())
    scene, left = trimesh.Scene(), 0
    for name, faces in parts.items():
        look = looks.get(name, {"kd": [0.8] * 3, "d": 1.0, "tex": None})
        if look["tex"] and not os.path.exists(look["tex"]):
            look["tex"] = None
        keys = sorted({c for f in faces for c in f})
        index = {c: i for i, c in enumerate(keys)}
        v = np.array([points[c[0]] for c in keys])
        f = np.array([[index[c] for c in face] for face in faces])
        uv = np.array([uvs[c[1]] if c[1] >= 0 else (0, 0) for c in keys])
        textured = bool(look["tex"])
        if total > LIMIT and len(f) > 60:
            v, f = simplified(v, f, LIMIT / total)
            textured = False
        mesh = trimesh.Trimesh(v, f, process=False)
        look_of = material(name, look, textured)
        mesh.visual = trimesh.visual.TextureVisuals(uv=uv if textured else np.zeros((len(v), 2)), material=look_of)
        scene.add_geometry(mesh, geom_name=name, node_name=name)
        left += len(f)
    # Simplification moves the underside by fractions of a millimetre.
    low = scene.bounds[0][1]
    middle = (scene.bounds[0] + scene.bounds[1]) / 2
    scene.apply_translation([-middle[0], -low, -middle[2]])
    file = f"{kind}__{base}__{catalogue}.glb"
    flat = trimesh.Scene()
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry].copy()
        mesh.apply_transform(transform)
        flat.add_geometry(mesh, geom_name=geometry, node_name=geometry)
    flat.export(os.path.join(out, file))
    w, h, d = size
    return dict(file=file, kind=kind, name=row["name"], catalogue=catalogue, source=row["model"], creator=row["creator"],
                licence=LICENCE[catalogue], width_m=round(w, 4), height_m=round(h, 4), depth_m=round(d, 4), triangles=left,
                triangles_before=total)


def main():
    table, deb, out = sys.argv[1:4]
    rows = list(csv.DictReader(open(table)))
    done = [convert(*line.split(), rows, deb, out) for line in SELECTION if line.strip()]
    done.sort(key=lambda d: d["file"])
    with open(os.path.join(out, "MANIFEST.csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(done[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(done)
    print(len(done), "models,", max(d["triangles"] for d in done), "triangles at most")


main()
