"""Volumes behind a text header: NumPy, NRRD, MetaImage."""

import gzip
import io
import itertools
import struct

import numpy as np

from corpus import Case
from images import SIZE, convert, flipped, volume, write


# NumPy ----------------------------------------------------------------------------------------------------------------------------------
def npy_bytes(text, body, version=(1, 0)):
    head = text.encode("latin1") if isinstance(text, str) else text
    head += b" " * (63 - (10 + len(head)) % 64) + b"\n"
    length = struct.pack("<H", len(head)) if version[0] == 1 else struct.pack("<I", len(head))
    return b"\x93NUMPY" + bytes(version) + length + head + body


def read_npy(data):
    try:
        values = np.load(io.BytesIO(data), allow_pickle=False)
    except Exception:
        return None
    if values.ndim != 3 or values.dtype.kind not in "uifb" or not values.size:
        return None
    return values if values.flags.c_contiguous else values.T  # the fastest axis is x, whatever NumPy calls it


def npy(random):
    def one(name, data):
        values = read_npy(data)
        wanted = (
            values
            if values is not None and (values.dtype.kind == "b" or values.dtype.itemsize <= (8 if values.dtype.kind == "f" else 4))
            else None
        )
        # numpy.load passes over bytes behind the last value; ours may not.
        return Case(name, write("in.npy", data), convert("in.npy", *SIZE), wanted)

    values = volume(np.uint16, (3, 4, 5))
    body = values.tobytes()
    keys = {"descr": "'<u2'", "fortran_order": "False", "shape": "(3, 4, 5)"}
    for order in itertools.permutations(keys):
        for fortran in ("False", "True"):
            text = "{" + ", ".join(f"'{key}': {fortran if key == 'fortran_order' else keys[key]}" for key in order) + ", }"
            yield one(f"order_{'_'.join(k[0] for k in order)}_{fortran}", npy_bytes(text, body))
    for n, text in enumerate(
        (
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5)}",
            '{"descr": "<u2", "fortran_order": False, "shape": (3, 4, 5)}',
            "{'descr': '>u2', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '=u2', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '|u2', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': 'u2', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': True, 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5), 'shape': (5, 4, 3), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5, 1), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (12, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (60,), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (-3, -4, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 0), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 99999999999999999999), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3L, 4L, 5L), }",
            "{'descr': '<u2', 'fortran_order': 0, 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': Falsehood, 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': [3, 4, 5], }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5), 'x': 1, }",
            "{'descr': [('a', '<u2')], 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<c8', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<u8', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<f2', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<M8[s]', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '|O', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5), } 'fortran_order': True",
            "[]",
            "",
            "{",
            "{'descr'",
            "{'descr': ",
            "{'fortran_order': True, 'descr': '<u2', 'shape': (3, 4, 5), }",
            "{'a': \"'fortran_order': True\", 'descr': '<u2'}",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (0x3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3.0, 4, 5), }",
            "{'descr': '<u2',\t'fortran_order':\nFalse, 'shape':(3,4,5)}",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5)",
        )
    ):
        yield one(f"text_{n}", npy_bytes(text, body))
        yield one(f"text2_{n}", npy_bytes(text, body, (2, 0)))
    good = npy_bytes("{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5), }", body)
    for dtype in ("?", "u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8", "u8", "i8", "f2", "c8", "S3", ">u2", ">f4"):
        buffer = io.BytesIO()
        np.save(buffer, volume(np.uint8, (3, 4, 5)).astype(dtype))
        yield one(f"type_{dtype.replace('>', 'big')}", buffer.getvalue())
        buffer = io.BytesIO()
        np.save(buffer, np.asfortranarray(volume(np.uint8, (3, 4, 5)).astype(dtype)))
        yield one(f"fortran_{dtype.replace('>', 'big')}", buffer.getvalue())
    for n in range(60):
        yield one(f"flip_{n}", flipped(good, random, 128))
    for n in (0, 5, 8, 9, 10, 60, 127, 128, len(good) - 1, len(good) + 1):
        yield Case(f"length_{n}", write("in.npy", (good + b"xx")[:n]), convert("in.npy", *SIZE), None)


# NRRD and MetaImage ---------------------------------------------------------------------------------------------------------------------
def nrrd_bytes(fields, body, magic="NRRD0004"):
    return (magic + "\n" + "".join(f"{key}: {value}\n" for key, value in fields) + "\n").encode("latin1") + body


def nrrd(random):
    values = volume(np.uint16, (3, 4, 5))
    body = values.tobytes()
    base = [
        ("type", "uint16"),
        ("dimension", "3"),
        ("sizes", "5 4 3"),
        ("spacings", "0.1 0.1 0.1"),
        ("encoding", "raw"),
        ("endian", "little"),
    ]

    def one(name, changes, wanted=None, data=body, strict=False, size=SIZE):
        fields = [(key, changes.get(key, value)) for key, value in base if changes.get(key, value) is not None]
        fields += [(key, value) for key, value in changes.items() if key not in dict(base)]
        return Case(name, write("in.nrrd", nrrd_bytes(fields, data)), convert("in.nrrd", *size), wanted, may_refuse=not strict)

    yield one("plain", {}, values, strict=True)
    for kinds in ("domain domain domain", "space space space", "none none none", "??? ??? ???"):
        yield one(f"kinds_{kinds[:6].strip('?')}", {"kinds": kinds}, values, strict=True)
    for kind in (
        "RGB-color",
        "RGBA-color",
        "3-color",
        "vector",
        "3-vector",
        "time",
        "list",
        "scalar",
        "complex",
        "point",
        "normal",
        "2-vector",
        "covariant-vector",
        "3D-matrix",
        "quaternion",
        "stub",
        "HSV-color",
        "tensor",
        "4-color",
        "XYZ-color",
    ):
        for place in range(3):
            kinds = ["domain"] * 3
            kinds[place] = kind
            yield one(f"kind_{kind}_{place}", {"kinds": " ".join(kinds)})
    for skip, wanted, data in (
        ("0", values, body),
        ("7", values, b"1234567" + body),
        ("-1", values, b"123" + body),
        ("7", None, body),
        ("-2", None, body),
        ("x", None, body),
        ("1e3", None, body),
        ("1.5", None, body),
        ("-1", None, body[:-1]),
    ):
        yield one(f"byte_skip_{skip}_{len(data)}", {"byte skip": skip}, wanted, data)
        yield one(f"byteskip_{skip}_{len(data)}", {"byteskip": skip}, wanted, data)
    for skip, wanted in (("0", values), ("1", None), ("-1", None), ("x", None)):
        yield one(f"line_skip_{skip}", {"line skip": skip}, wanted)
    for key, value in base:
        for again in (value, "0.2 0.2 0.2", "4 5 3", "int16", "big"):
            fields = nrrd_bytes(base + [(key, again)], body)
            yield Case(f"twice_{key}_{again.split()[0]}", write("in.nrrd", fields), convert("in.nrrd", *SIZE), None)
    for number in ("1e305", "1e308", "1e-313", "1e-320", "nan", "inf", "-1", "0", "1e400", "x"):
        for unit in (True, False):
            changes = {"spacings": f"{number} {number} {number}"}
            if unit:
                changes["units"] = '"mm" "mm" "mm"'
            yield one(f"spacing_{number}_{unit}", changes, None, size=() if unit else ("--image-unit", "0.001"))
        yield one(
            f"direction_{number}",
            {
                "spacings": None,
                "space dimension": "3",
                "space directions": f"({number},0,0) (0,{number},0) (0,0,{number})",
                "space units": '"mm" "mm" "mm"',
            },
            values[::-1, ::-1, ::-1] if number == "-1" else None,
            size=(),
        )
        if number not in ("0", "-1"):
            yield one(
                f"origin_{number}",
                {
                    "spacings": None,
                    "space dimension": "3",
                    "space directions": "(0.1,0,0) (0,0.1,0) (0,0,0.1)",
                    "space units": '"mm" "mm" "mm"',
                    "space origin": f"({number},0,0)",
                },
                values if number in ("1e-313", "1e-320") else None,
                size=(),
            )
    for key, options in {
        "dimension": ("2", "4", "0", "-3", "x", "3 3"),
        "sizes": ("5 4", "5 4 3 1", "0 4 3", "-5 4 3", "5.5 4 3", "1e9 1e9 1e9", "5 4 4", "5 4 2"),
        "type": ("float", "uchar", "int64", "block", "half", "", "uint8"),
        "encoding": ("ascii", "hex", "bzip2", "text", "", "zrl"),
        "endian": ("middle", "", "x"),
        "data file": ("LIST", "x%03d.raw 1 3 1", "/etc/passwd", "../outside.txt", "missing.raw", "."),
        "units": ('"mm" "mm" "um"', '"mm"', '"mm" "mm" "'),
        "unknown": ("1",),
        "axis mins": ("0 0 0",),
        "old min": ("0",),
        "kinds": ("domain", "domain domain", "domain domain domain domain"),
    }.items():
        for value in options:
            yield one(f"{key}_{value[:12].replace('/', '_')}", {key: value})
    good = nrrd_bytes(base, body)
    yield Case(
        "big",
        write("in.nrrd", nrrd_bytes([(k, "big" if k == "endian" else v) for k, v in base], values.byteswap().tobytes())),
        convert("in.nrrd", *SIZE),
        values,
        may_refuse=False,
    )
    yield Case(
        "gzip",
        write("in.nrrd", nrrd_bytes([(k, "gzip" if k == "encoding" else v) for k, v in base], gzip.compress(body))),
        convert("in.nrrd", *SIZE),
        values,
        may_refuse=False,
    )
    for n in range(40):
        data = flipped(good, random, 120)
        yield Case(f"flip_{n}", write("in.nrrd", data), convert("in.nrrd", *SIZE), "any")
    for n in range(10):
        yield Case(f"cut_{n}", write("in.nrrd", good[: random.randrange(len(good))]), convert("in.nrrd", *SIZE), None)


def meta(random):
    values = volume(np.uint16, (3, 4, 5))
    body = values.tobytes()
    base = [
        ("ObjectType", "Image"),
        ("NDims", "3"),
        ("BinaryData", "True"),
        ("ElementSpacing", "0.1 0.1 0.1"),
        ("DimSize", "5 4 3"),
        ("ElementType", "MET_USHORT"),
    ]

    def data_of(changes, data, name="LOCAL"):
        fields = [(key, changes.get(key, value)) for key, value in base if changes.get(key, value) is not None]
        fields += [(key, value) for key, value in changes.items() if key not in dict(base) and key != "ElementDataFile"]
        return ("".join(f"{k} = {v}\n" for k, v in fields) + f"ElementDataFile = {changes.get('ElementDataFile', name)}\n").encode() + data

    def one(name, changes, wanted=None, data=body, strict=False, size=SIZE):
        return Case(name, write("in.mha", data_of(changes, data)), convert("in.mha", *size), wanted, may_refuse=not strict)

    yield one("plain", {}, values, strict=True)
    yield one("big", {"ElementByteOrderMSB": "True"}, values.byteswap())
    yield one("orders", {"ElementByteOrderMSB": "True", "BinaryDataByteOrderMSB": "False"})
    for key, options in {
        "NDims": ("2", "4", "x", ""),
        "DimSize": ("5 4", "5 4 3 1", "0 4 3", "-5 4 3", "5.5 4 3", "1e9 1e9 1e9", "5 4 4", "5 4 2"),
        "ElementType": ("MET_FLOAT", "MET_UCHAR", "MET_LONG", "MET_USHORT_ARRAY", ""),
        "ElementNumberOfChannels": ("3", "0"),
        "BinaryData": ("False", "0", "x"),
        "CompressedData": ("True", "x"),
        "ObjectType": ("Mesh", "Scene"),
        "HeaderSize": ("4", "-1", "x"),
        "ElementToIntensityFunctionSlope": ("2", "0", "nan"),
        "ElementToIntensityFunctionOffset": ("1",),
        "DistanceUnits": ("inch", "km"),
        "ElementSpacing": ("1e305 1e305 1e305", "1e-320 1e-320 1e-320", "0 0 0", "-1 -1 -1", "nan nan nan", "0.1", "0.1 0.1 0.2"),
        "TransformMatrix": (
            "1 0 0 0 1 0",
            "0 0 0 0 0 0 0 0 0",
            "0.8 0.6 0 -0.6 0.8 0 0 0 1",
            "nan 0 0 0 1 0 0 0 1",
            "1e300 0 0 0 1 0 0 0 0",
        ),
        "Offset": ("0 0", "nan 0 0", "1e300 0 0"),
        "ElementDataFile": ("LIST", "x%03d.raw 1 3 1", "../outside.txt", "/etc/passwd", "missing.raw", "", "."),
    }.items():
        for value in options:
            for size in (SIZE, ("--image-unit", "0.001")):
                right = value == "0.1 0.1 0.2" and size != SIZE
                yield one(f"{key}_{value[:10].replace('/', '_')}_{len(size[0])}", {key: value}, values if right else None, size=size)
    for key, value in base:
        for again in (value, "0.2 0.2 0.2", "4 5 3"):
            yield Case(
                f"twice_{key}_{again.split()[0]}",
                write("in.mha", f"{key} = {again}\n".encode() + data_of({}, body)),
                convert("in.mha", *SIZE),
                None,
            )
    for one_key, other in (
        ("Offset", "Position"),
        ("Offset", "Origin"),
        ("TransformMatrix", "Rotation"),
        ("TransformMatrix", "Orientation"),
    ):
        numbers = "1 2 3" if one_key == "Offset" else "1 0 0 0 1 0 0 0 1"
        yield one(f"same_{one_key}_{other}", {one_key: numbers, other: numbers.replace("3", "4")})
    good = data_of({}, body)
    for n in range(60):
        yield Case(f"flip_{n}", write("in.mha", flipped(good, random, 150)), convert("in.mha", *SIZE), "any")
    for n in range(10):
        yield Case(f"cut_{n}", write("in.mha", good[: random.randrange(len(good))]), convert("in.mha", *SIZE), None)


def kinds(_program):
    return {"npy": npy, "nrrd": nrrd, "meta": meta}
