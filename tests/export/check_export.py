"""Reads one frame of `taut export` in every format, with readers of its own, and compares them value by value.

    python3 check_export.py FOLDER FRAME

FOLDER holds m.npz, m.csv, m.ply (binary), t.ply (text), m.glb and m.usda of one object. Prints the arrays of the .npz and what
was compared. Needs numpy; neither a USD nor a glTF library: the grammar of .usda is checked by the parser below.
"""

import json
import re
import struct
import sys

import numpy


def read_ply(path):
    """{property: array} of the vertices, faces, face materials; text and binary_little_endian."""
    data = open(path, "rb").read()
    head, body = data.split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    text = "format ascii 1.0" in lines
    names, element, counts = [], None, {}
    for line in lines:
        words = line.split()
        if words[0] == "element":
            element = words[1]
            counts[element] = int(words[2])
        elif words[0] == "property" and element == "vertex":
            assert words[1] == "float", line
            names.append(words[2])
    vertices, faces = counts["vertex"], counts["face"]
    if text:
        rows = body.decode().splitlines()
        table = numpy.array([row.split() for row in rows[:vertices]], dtype=numpy.float32)
        face_rows = numpy.array([row.split() for row in rows[vertices:]], dtype=numpy.int64)
        assert len(face_rows) == faces and (face_rows[:, 0] == 3).all()
        triangles, materials = face_rows[:, 1:4], face_rows[:, 4]
    else:
        table = numpy.frombuffer(body, "<f4", vertices * len(names)).reshape(vertices, -1)
        dtype = [("n", "u1"), ("v", "<i4", 3), ("m", "<i4")]
        face_rows = numpy.frombuffer(body, dtype, faces, offset=table.nbytes)
        assert table.nbytes + face_rows.nbytes == len(body) and (face_rows["n"] == 3).all()
        triangles, materials = face_rows["v"], face_rows["m"]
    return {name: table[:, i] for i, name in enumerate(names)}, triangles, materials


def read_csv(path):
    rows = open(path, encoding="utf-8").read().splitlines()
    table = numpy.array([row.split(",") for row in rows[1:]], dtype=numpy.float32)
    return {name: table[:, i] for i, name in enumerate(rows[0].split(","))}


def read_glb(path):
    """[{attribute: array}] of the first mesh's primitives, with "indices", and the JSON."""
    data = open(path, "rb").read()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON" and size % 4 == 0
    gltf = json.loads(data[20 : 20 + size])
    binary_size, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0" and 28 + size + binary_size == len(data)
    binary = data[28 + size :]

    def accessor(number):
        a = gltf["accessors"][number]
        view = gltf["bufferViews"][a["bufferView"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[a["type"]]
        values = numpy.frombuffer(binary, {5126: "<f4", 5125: "<u4"}[a["componentType"]], a["count"] * width, view["byteOffset"])
        return values.reshape(-1, width) if width > 1 else values

    primitives = []
    for primitive in gltf["meshes"][0]["primitives"]:
        primitives.append({name: accessor(n) for name, n in primitive["attributes"].items()})
        primitives[-1]["indices"] = accessor(primitive["indices"]).reshape(-1, 3)
    return primitives, gltf


class Usda:
    """A parser of the subset of .usda that is written: a layer header, prims, attributes with metadata and time samples."""

    TOKEN = re.compile(r'\s*(?:(#usda 1\.0)|("""(?:.|\n)*?"""|"[^"\n]*")|(-?(?:inf|nan|\d[\d.e+-]*))|([A-Za-z_][\w:.]*(?:\[\])?)|([(){}\[\],=:]))')

    def __init__(self, text):
        self.tokens = []
        at = 0
        text = text.rstrip()
        while at < len(text):
            match = self.TOKEN.match(text, at)
            assert match, "unknown token at " + repr(text[at : at + 40])
            self.tokens.append((match.lastindex, match.group(match.lastindex)))
            at = match.end()
        self.at = 0

    def peek(self):
        return self.tokens[self.at][1] if self.at < len(self.tokens) else None

    def take(self, expected=None):
        kind, value = self.tokens[self.at]
        assert expected is None or value == expected, (expected, value)
        self.at += 1
        return kind, value

    def value(self):
        kind, token = self.take()
        if kind == 2:
            return token.strip('"')
        if kind == 3:
            return float(token)
        if token == "{":
            samples = {}
            while self.peek() != "}":
                time = self.value()
                self.take(":")
                samples[time] = self.value()
                if self.peek() == ",":
                    self.take()
            self.take("}")
            return samples
        assert token in "[(", token
        items = []
        while self.peek() not in ("]", ")"):
            items.append(self.value())
            if self.peek() == ",":
                self.take()
        self.take("]" if token == "[" else ")")
        return items

    def metadata(self):
        found = {}
        if self.peek() != "(":
            return found
        self.take("(")
        while self.peek() != ")":
            kind, name = self.take()
            assert kind == 4, name
            self.take("=")
            found[name] = self.value()
        self.take(")")
        return found

    def prim(self):
        self.take("def")
        kind, type_name = self.take()
        kind, name = self.take()
        assert kind == 2, name
        prim = {"type": type_name, "name": name.strip('"'), "attributes": {}, "children": [], "metadata": self.metadata()}
        self.take("{")
        while self.peek() != "}":
            if self.peek() == "def":
                prim["children"].append(self.prim())
                continue
            words = []
            while self.peek() not in ("=", "(") and self.tokens[self.at][0] == 4:
                words.append(self.take()[1])
                if len(words) >= 2 and words[-2] != "uniform":
                    break
            if words[0] == "uniform":
                words = words[1:]
            assert len(words) == 2, words
            value = None
            if self.peek() == "=":
                self.take("=")
                value = self.value()
            entry = prim["attributes"].setdefault(words[1], {"type": words[0]})
            assert entry["type"] == words[0]
            entry["value"] = value
            entry.update(self.metadata())
        self.take("}")
        return prim

    def layer(self):
        kind, _ = self.take()
        assert kind == 1
        layer = self.metadata()
        layer["prims"] = []
        while self.peek() is not None:
            layer["prims"].append(self.prim())
        return layer


def same(name, a, b):
    a, b = numpy.asarray(a, numpy.float32), numpy.asarray(b, numpy.float32)
    assert a.shape == b.shape, (name, a.shape, b.shape)
    assert numpy.array_equal(a, b), (name, numpy.abs(a - b).max())


def check_meaning(arrays):
    """M, alpha and the stretch are those of ds, dt and the frame."""
    t, b, n = (arrays[k].astype(float) for k in ("tangent", "bitangent", "N"))
    for i, u in enumerate((t, b, n)):
        for j, v in enumerate((t, b, n)):
            assert numpy.abs((u * v).sum(1) - (i == j)).max() < 3e-6
    assert numpy.abs(numpy.cross(n, t) - b).max() < 3e-6
    m = arrays["M"].astype(float)
    assert (m[:, 0] > 0).all() and (m[:, 2] > 0).all() and (m[:, 3:] == 0).all()
    block = numpy.zeros((len(m), 2, 2))
    block[:, 0, 0], block[:, 0, 1], block[:, 1, 1] = m[:, 0], m[:, 1], m[:, 2]
    singular = numpy.linalg.svd(block, compute_uv=False)
    assert numpy.abs(arrays["alpha_max"] * singular[:, 1] - 1).max() < 1e-5
    assert numpy.abs(arrays["alpha_min"] * singular[:, 0] - 1).max() < 1e-5
    phi = arrays["phi"].astype(float)
    axis = numpy.stack([numpy.cos(phi), numpy.sin(phi)], 1)
    sigma = numpy.linalg.inv(block @ block.transpose(0, 2, 1))
    along = numpy.einsum("ni,nij,nj->n", axis, sigma, axis)
    assert numpy.abs(along / arrays["alpha_max"] ** 2 - 1).max() < 1e-4
    world = axis[:, :1] * t + axis[:, 1:] * b
    assert numpy.abs(world - arrays["alpha_dir"]).max() < 1e-5
    ds, dt = arrays["ds"].astype(float), arrays["dt"].astype(float)
    gradient = numpy.stack([numpy.stack([(ds * t).sum(1), (dt * t).sum(1)], 1), numpy.stack([(ds * b).sum(1), (dt * b).sum(1)], 1)], 1)
    stretch = numpy.linalg.svd(gradient, compute_uv=False)
    assert numpy.abs(arrays["stretch_max"] / stretch[:, 0] - 1).max() < 1e-5
    assert numpy.abs(arrays["stretch_min"] / stretch[:, 1] - 1).max() < 1e-5
    determinant = numpy.linalg.det(gradient)
    assert numpy.abs(arrays["det"] / numpy.abs(determinant) - 1).max() < 1e-5
    assert (numpy.sign(determinant) == arrays["tangent_sign"]).all()
    pulled = numpy.linalg.norm(numpy.einsum("nij,ni->nj", gradient, numpy.stack([(arrays["stretch_dir"] * t).sum(1), (arrays["stretch_dir"] * b).sum(1)], 1)), axis=1)
    assert numpy.abs(pulled / stretch[:, 0] - 1).max() < 1e-4


def main():
    folder, frame = sys.argv[1], float(sys.argv[2])
    arrays = dict(numpy.load(folder + "/m.npz"))
    count = len(arrays["P"])
    for name, array in arrays.items():
        print(name, array.dtype, array.shape)
    check_meaning(arrays)

    columns = {"x": "P", "nx": "N", "s": "st"}
    vectors = {"y": ("P", 1), "z": ("P", 2), "ny": ("N", 1), "nz": ("N", 2), "t": ("st", 1), "M_p_x": ("M", 3), "M_q_x": ("M", 4)}

    def expected(column):
        name, component = vectors.get(column, (columns.get(column), 0))
        if name is None:
            name, component = column[:-2], "xyz".index(column[-1])
        return arrays[name] if arrays[name].ndim == 1 else arrays[name][:, component]

    for path in ("m.ply", "t.ply"):
        table, faces, materials = read_ply(folder + "/" + path)
        for column, values in table.items():
            same(path + " " + column, values, expected(column))
        same(path, faces, arrays["faces"])
        same(path, materials, arrays["face_material"])
        print(path, len(table), "properties")
    table = read_csv(folder + "/m.csv")
    for column, values in table.items():
        same("csv " + column, values, expected(column))
    print("m.csv", len(table), "columns")

    names = {"POSITION": "P", "NORMAL": "N", "_TAUT_DS": "ds", "_TAUT_DT": "dt", "_TAUT_PREF": "Pref",
             "_TAUT_STRETCH_DIR": "stretch_dir", "_TAUT_ALPHA_DIR": "alpha_dir"}
    primitives, gltf = read_glb(folder + "/m.glb")
    assert gltf["nodes"][0]["rotation"][0] < 0 and abs(gltf["nodes"][0]["rotation"][0] ** 2 - 0.5) < 1e-15
    for material, primitive in enumerate(primitives):
        for name, array in names.items():
            same(name, primitive[name], arrays[array])
        same("TANGENT", primitive["TANGENT"], numpy.concatenate([arrays["tangent"], arrays["tangent_sign"][:, None]], 1))
        same("M", numpy.concatenate([primitive["_TAUT_M"], primitive["_TAUT_LEAN"]], 1), arrays["M"])
        same("alpha", primitive["_TAUT_ALPHA"], numpy.stack([arrays[k] for k in ("alpha_max", "alpha_min", "phi")], 1))
        same("stretch", primitive["_TAUT_STRETCH"], numpy.stack([arrays[k] for k in ("stretch_max", "stretch_min", "det")], 1))
        assert numpy.abs(primitive["TEXCOORD_0"] * [1, -1] + [0, 1] - arrays["st"]).max() < 1e-6
        same("indices", primitive["indices"], arrays["faces"][arrays["face_material"] == material])
    assert sum(len(p["indices"]) for p in primitives) == len(arrays["faces"])
    print("m.glb", len(primitives), "primitives of", len(primitives[0]) - 1, "attributes")

    layer = Usda(open(folder + "/m.usda", encoding="utf-8").read()).layer()
    assert layer["upAxis"] == "Z" and layer["metersPerUnit"] == 1 and layer["defaultPrim"] == "taut"
    assert layer["startTimeCode"] <= frame <= layer["endTimeCode"]
    prim = layer["prims"][0]["children"][0]
    assert (layer["prims"][0]["type"], prim["type"]) == ("Xform", "Mesh")
    attributes = prim["attributes"]
    assert set(attributes["faceVertexCounts"]["value"]) == {3}
    same("faceVertexIndices", numpy.reshape(attributes["faceVertexIndices"]["value"], (-1, 3)), arrays["faces"])
    types = {1: "float[]", 2: "texCoord2f[]"}
    checked = 0
    for name, attribute in attributes.items():
        if not name.endswith(".timeSamples"):
            continue
        samples = attribute["value"]
        base = name[: -len(".timeSamples")]
        key = {"points": "P", "normals": "N"}.get(base, base.split(":")[-1])
        values = arrays["M"][:, :3] if key == "M" else arrays["M"][:, 3 + "pq".index(key[2])] if key in ("M_p", "M_q") else arrays[key]
        same(name, samples[frame], values)
        assert all(len(sample) == count for sample in samples.values())
        if base != "points":
            assert attributes[base]["interpolation"] == "vertex"
        checked += 1
    same("primvars:Pref", attributes["primvars:Pref"]["value"], arrays["Pref"])
    same("primvars:st", attributes["primvars:st"]["value"], arrays["st"])
    assert attributes["primvars:st"]["type"] == types[2]
    print("m.usda", checked, "attributes with", len(samples), "time samples")
    print("SAME", count, "vertices")


if __name__ == "__main__":
    main()
