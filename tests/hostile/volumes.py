"""Volumes: VTK images, raw files, folders of layers."""

import base64
import gzip
import struct
import subprocess
import sys
import tempfile

import numpy as np

from corpus import Case
from images import SIZE, convert, flipped, tiff_bytes, volume, write

# VTK ------------------------------------------------------------------------------------------------------------------------------------
READER = """
import sys, numpy, vtk
from vtk.util.numpy_support import vtk_to_numpy
vtk.vtkObject.GlobalWarningDisplayOff()
r = vtk.vtkXMLImageDataReader(); r.SetFileName(sys.argv[1]); r.Update()
image = r.GetOutput(); data = image.GetCellData()
assert data.GetNumberOfArrays() == 1 and r.GetErrorCode() == 0
n = [m - 1 for m in image.GetDimensions()]
numpy.save(sys.argv[2], vtk_to_numpy(data.GetArray(0)).reshape(n[2], n[1], n[0]))
"""


def read_vti(data):
    with tempfile.TemporaryDirectory() as folder:
        open(f"{folder}/a.vti", "wb").write(data)
        done = subprocess.run([sys.executable, "-c", READER, f"{folder}/a.vti", f"{folder}/a.npy"], capture_output=True)
        return np.load(f"{folder}/a.npy") if done.returncode == 0 else None


def as_vtk_reads_it(data, values):
    """A damaged file that is accepted has the values that VTK reads, or, where VTK refuses, those before the damage."""

    def fault(folder, _output):
        out, wanted = np.load(folder / "out.npy"), read_vti(data)
        wanted = values if wanted is None else wanted
        return "" if out.shape == wanted.shape and np.array_equal(out, wanted) else "other values than VTK's"

    return fault


def vti_text(values, form="ascii", header="UInt32", order="LittleEndian", apart=False, kind=None, body=None, extra=""):
    names = {"u1": "UInt8", "i1": "Int8", "u2": "UInt16", "i2": "Int16", "u4": "UInt32", "i4": "Int32", "f4": "Float32", "f8": "Float64"}
    n = values.shape
    extent = f"0 {n[2]} 0 {n[1]} 0 {n[0]}"
    end = "<" if order == "LittleEndian" else ">"
    raw = values.astype(values.dtype.newbyteorder(end)).tobytes()
    length = struct.pack(end + ("I" if header == "UInt32" else "Q"), len(raw))
    text = body
    if text is None:
        text = (
            " ".join(str(v) for v in values.ravel())
            if form == "ascii"
            else (base64.b64encode(length).decode() + base64.b64encode(raw).decode() if apart else base64.b64encode(length + raw).decode())
        )
    inline = "" if form == "appended" else text
    offset = ' offset="0"' if form == "appended" else ""
    appended = f'<AppendedData encoding="base64">_{text}</AppendedData>' if form == "appended" else ""
    return (
        f'<?xml version="1.0"?><VTKFile type="ImageData" version="1.0" byte_order="{order}" header_type="{header}">{extra}'
        f'<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="1e-4 1e-4 1e-4"><Piece Extent="{extent}"><CellData>'
        f'<DataArray type="{kind or names[values.dtype.str[1:]]}" Name="v" format="{form}"{offset}>{inline}</DataArray>'
        f"</CellData></Piece></ImageData>"
        f"{appended}</VTKFile>"
    ).encode()


def vti(random):
    flags = ("--image-unit", "1")

    def one(name, data, wanted, strict=False):
        return Case(name, write("in.vti", data), convert("in.vti", *flags), wanted, may_refuse=not strict)

    for dtype in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        values = volume(np.dtype(dtype).type, (3, 4, 5))
        yield one(f"ascii_{dtype}", vti_text(values), values, strict=True)
        for header in ("UInt32", "UInt64"):
            for order in ("LittleEndian", "BigEndian"):
                for form in ("binary", "appended"):
                    for apart in (False, True):
                        yield one(
                            f"{form}_{dtype}_{header}_{order}_{apart}", vti_text(values, form, header, order, apart), values, strict=True
                        )
    for kind, value in (
        ("UInt8", "300"),
        ("UInt8", "-1"),
        ("UInt8", "256"),
        ("UInt8", "1.5"),
        ("UInt8", "1e3"),
        ("Int8", "128"),
        ("Int8", "-129"),
        ("Int8", "200"),
        ("UInt16", "65536"),
        ("UInt16", "-1"),
        ("UInt16", "70000"),
        ("Int16", "32768"),
        ("Int16", "-32769"),
        ("Int32", "2147483648"),
        ("Int32", "1e10"),
        ("UInt32", "4294967296"),
        ("UInt32", "-1"),
        ("Float32", "nan"),
        ("Float32", "inf"),
        ("Float32", "1e39"),
        ("Float64", "nan"),
        ("Float64", "1e400"),
        ("UInt8", "x"),
        ("UInt8", "0x10"),
        ("UInt8", "1,2"),
        ("UInt8", ""),
    ):
        values = volume(np.uint8, (3, 4, 5))
        for place in (0, 30, 59):
            words = [str(v) for v in values.ravel()]
            words[place] = value
            yield one(f"value_{kind}_{value}_{place}", vti_text(values, kind=kind, body=" ".join(words)), None)
    for depth in (30, 1000, 100000, 1000000):
        yield one(f"deep_{depth}", vti_text(volume(np.uint8, (3, 4, 5)), extra="<a>" * depth + "</a>" * depth), None)
        yield one(f"open_{depth}", vti_text(volume(np.uint8, (3, 4, 5)), extra="<a>" * depth), None)
    values = volume(np.uint16, (3, 4, 5))
    good = vti_text(values, "binary")
    for old, new in (
        (b'WholeExtent="0 5 0 4 0 3"', b'WholeExtent="0 5 0 4 0 4"'),
        (b'WholeExtent="0 5 0 4 0 3"', b'WholeExtent="0 4 0 5 0 3"'),
        (b'Piece Extent="0 5 0 4 0 3"', b'Piece Extent="0 4 0 5 0 3"'),
        (b'Extent="0 5 0 4 0 3"', b'Extent="0 5 0 4"'),
        (b'Extent="0 5 0 4 0 3"', b'Extent="5 0 4 0 3 0"'),
        (b"UInt16", b"UInt8"),
        (b"UInt16", b"UInt32"),
        (b"UInt16", b"String"),
        (b"UInt16", b"Int64"),
        (b'format="binary"', b'format="ascii"'),
        (b'format="binary"', b'format="appended"'),
        (b'header_type="UInt32"', b'header_type="UInt64"'),
        (b'Name="v"', b'Name="v" NumberOfComponents="3"'),
        (b'Name="v"', b'Name="v" NumberOfComponents="2"'),
        (b"ImageData", b"PolyData"),
        (b'Spacing="1e-4 1e-4 1e-4"', b'Spacing="0 0 0"'),
        (b'Spacing="1e-4 1e-4 1e-4"', b'Spacing="1e308 1e308 1e308"'),
        (b'Spacing="1e-4 1e-4 1e-4"', b'Spacing="1e-320 1e-320 1e-320"'),
        (b'Origin="0 0 0"', b'Origin="nan 0 0"'),
        (b'Origin="0 0 0"', b'Origin="1e300 0 0"'),
        (b'Origin="0 0 0"', b'Origin="0 0"'),
        (b"</VTKFile>", b""),
        (b"CellData", b"PointData"),
    ):
        yield one(
            f"header_{old[:12].decode()}_{new[-14:].decode(errors='replace')}".replace('"', "").replace("/", "_"),
            good.replace(old, new),
            None,
        )
    for name, options in (("a", {}), ("b", {"apart": True})):
        base = vti_text(values, "binary", **options)
        at = base.index(b'format="binary">') + 16
        for n in (1, 2, 5, 10, 40, 75, 76, 100):
            yield one(f"line_{name}_{n}", base[: at + n] + b"\n" + base[at + n :], values)
            yield one(f"blank_{name}_{n}", base[: at + n] + b" " + base[at + n :], values)
            yield one(f"sign_{name}_{n}", base[: at + n] + b"=" + base[at + n + 1 :], None)
            yield one(f"less_{name}_{n}", base[: at + n] + base[at + n + 4 :], None)
    for n in range(40):
        data = flipped(good, random, 400)
        yield one(f"flip_{n}", data, as_vtk_reads_it(data, values))
    for n in range(15):
        yield one(f"cut_{n}", good[: random.randrange(len(good))], None)


# raw ------------------------------------------------------------------------------------------------------------------------------------
def raw(random):
    values = volume(np.uint16, (3, 4, 5))
    body = values.tobytes()
    flags = ("--image-type", "uint16", *SIZE)
    for name in ("in.raw", "in.RAW", "in.bin", "in.dat", "in.img", "in.vol", "in.data", "in"):
        yield Case(f"name_{name}", write(name, body), convert(name, "--image-dims", "5,4,3", *flags), values, may_refuse=False)
        yield Case(f"name_without_{name}", write(name, body), convert(name, *flags), None)
    yield Case(
        "gz", write("in.raw.gz", gzip.compress(body)), convert("in.raw.gz", "--image-dims", "5,4,3", *flags), values, may_refuse=False
    )
    for dims in (
        "5,4",
        "5,4,3,1",
        "0,4,3",
        "-5,4,3",
        "5.5,4,3",
        "1e9,1e9,1e9",
        "5,4,4",
        "5,4,2",
        "nan,4,3",
        "inf,4,3",
        "1e308,1,1",
        "24,24,40] foo=[1",
        "5,4,3]\nx=[1",
        "5,4,3 # a",
        "[5,4,3]",
        "5;4;3",
        "",
        "5,4,3,",
        "5 4 3",
        "0x5,4,3",
        "5,4,'3'",
        '5,4,3"',
        "$(touch pwned)",
        "5,4,3];[1",
        "5,,3",
        ",,",
        "1_0,4,3",
        "+5,4,3",
        "5,4,3}",
    ):
        wanted = values if dims in ("5,4,3", "+5,4,3", "5,4,3,", "5 4 3", "[5,4,3]", "0x5,4,3") else None
        yield Case(f"dims_{dims[:14]}", write("in.raw", body), convert("in.raw", "--image-dims", dims, *flags), wanted)
    for skip in ("1", "7", "-1", "1e9", "nan", "1.5", "x", "120"):
        yield Case(
            f"skip_{skip}", write("in.raw", body), convert("in.raw", "--image-dims", "5,4,3", "--image-header-bytes", skip, *flags), None
        )
    yield Case(
        "skip_right",
        write("in.raw", b"1234567" + body),
        convert("in.raw", "--image-dims", "5,4,3", "--image-header-bytes", "7", *flags),
        values,
    )
    for kind in ("uint8", "uint32", "float32", "float64", "int64", "", "uint16,uint16"):
        yield Case(f"type_{kind}", write("in.raw", body), convert("in.raw", "--image-dims", "5,4,3", "--image-type", kind, *SIZE), None)
    for axes in ("xyz", "zyx", "x-yz", "xxz", "xy", "xyzz", "XYZ", "x-y-z-", "--xyz", "", "abc", "xy z"):
        yield Case(
            f"axes_{axes}",
            write("in.raw", body),
            convert("in.raw", "--image-dims", "5,4,3", f"--image-axes={axes}", *flags),
            "any" if axes in ("xyz", "zyx", "x-yz") else None,
        )
    for n in range(20):
        yield Case(
            f"gz_{n}",
            write("in.raw.gz", flipped(gzip.compress(body), random, 20)),
            convert("in.raw.gz", "--image-dims", "5,4,3", *flags),
            None if n < 0 else "any",
        )


# Folders of layers ----------------------------------------------------------------------------------------------------------------------
def folders(random):
    values = volume(np.uint8, (11, 6, 7))

    def one(name, names, wanted, strict=False, others=()):
        def make(folder):
            (folder / "in").mkdir()
            for layer, file in zip(values, names):
                (folder / "in" / file).write_bytes(tiff_bytes(layer, photometric="minisblack", metadata=None))
            for file in others:
                (folder / "in" / file).write_bytes(b"hello")

        right = values[: len(names)] if isinstance(wanted, str) else wanted
        return Case(name, make, convert("in", *SIZE), right, may_refuse=not strict)

    patterns = {
        "padded": "s{:04}.tif",
        "unpadded": "s{}.tif",
        "bracket": "slice ({}).tif",
        "tail": "rec_{:04}_8bit.tif",
        "bin": "a_{:04}_bin2.tif",
        "date": "s{:04}_2024-01-05.tif",
        "size": "s{:04}_2.5um.tif",
        "upper": "S{:03}.TIF",
        "mixed": "2024_{:02}_3.tiff",
        "front": "{:03}_a.tif",
        "umlaut": "\u00e4{:03}.tif",
        "blank": "a b {}.tif",
        "quote": "a'b{}.tif",
        "long": "x" * 100 + "{:05}.tif",
        "hash": "a#{}.tif",
        "dollar": "$(touch pwned){}.tif",
        "semi": "a;touch pwned;{}.tif",
        "dots": "a..{}.tif",
        "zeros": "{:015}.tif",
    }
    for name, pattern in patterns.items():
        for start, step in ((0, 1), (1, 1), (95, 1), (0, 2), (7, 5)):
            yield one(f"{name}_{start}_{step}", [pattern.format(start + i * step) for i in range(11)], "read", strict=True)
        for gone in (3, 7):
            numbers = [i for i in range(12) if i != gone]
            yield one(f"{name}_without_{gone}", [pattern.format(i) for i in numbers], None)
    good = ["s{:04}.tif".format(i) for i in range(10)]
    for other in (
        "a_preview.tif",
        "overview.tif",
        "s_mip.tif",
        "s0003 (copy).tif",
        "s0003_copy.tif",
        "rec_spr.tif",
        "0.tif",
        "s0003.TIFF",
        "S0003.tif",
        "s-0001.tif",
        "s0010_b.tif",
        "t0010.tif",
        "s0011.tif",
        "s0009 .tif",
        "s1e3.tif",
        "s00.10.tif",
        "s.tif",
        "zz.tif",
        "s0003.5.tif",
    ):
        yield one(f"with_{other}", good + [other], None)
    for other in ("log.txt", "scan.log", ".hidden.tif", "a.xml", "thumbs.db"):
        yield one(f"beside_{other}", good, "read", others=[other], strict=True)
    yield one("position", [f"z{0.5 + 0.1 * i:.1f}mm.tif" for i in range(11)], "read", strict=True)
    yield one("position_gap", [f"z{0.5 + 0.1 * i:.1f}mm.tif" for i in range(12) if i != 6], None)
    yield one("no_numbers", ["a.tif", "b.tif", "c.tif"], None)
    yield one("png_too", good + ["a.png"], None)
    yield one("empty_file", good, None, others=["s0010.tif"])


def kinds(_program):
    return {"vti": vti, "raw": raw, "folders": folders}
