"""Images: PNG, DICOM, TIFF, NumPy, NRRD, MetaImage, VTK, raw, folders of layers."""
import gzip
import io
import logging
import struct
import subprocess
import sys
import warnings
import zlib

import numpy as np
import pydicom
import tifffile
from PIL import Image
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRBigEndian, ExplicitVRLittleEndian, ImplicitVRLittleEndian, generate_uid

from corpus import Case

warnings.simplefilter("ignore")
logging.disable(logging.CRITICAL)
CONVERT = ["image", "convert"]


def volume(dtype=np.uint8, shape=(4, 6, 7), seed=3):
    random = np.random.default_rng(seed)
    if np.issubdtype(dtype, np.floating):
        return random.normal(100, 30, shape).astype(dtype)
    return random.integers(0, 120, shape).astype(dtype)


def flipped(data, random, header=700):
    data = bytearray(data)
    for _ in range(random.choice([1, 1, 3, 8])):
        at = random.randrange(min(header, len(data))) if random.random() < 0.5 else random.randrange(len(data))
        data[at] = random.randrange(256)
    if random.random() < 0.2:
        data = data[:random.randrange(len(data))]
    return bytes(data)


def write(name, data):
    def make(folder):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return make


def convert(name, *flags):
    return CONVERT + [name, "out.npy", *flags]


SIZE = ("--image-voxel-size", "1e-4")


def same_or_refused(values):
    """For files that the independent reader refuses: what is damaged may mean nothing, but then the values are the old ones."""
    def fault(folder, _output):
        out = np.load(folder / "out.npy")
        changed = np.count_nonzero(out != values) if out.shape == values.shape else 1000
        return "" if changed <= 8 else "accepted, with other values"  # as many bytes are flipped at most
    return fault


# PNG ------------------------------------------------------------------------------------------------------------------------------------
def png_bytes(image):
    buffer = io.BytesIO()
    image.save(buffer, "png")
    return buffer.getvalue()


def stack(layers):
    def make(folder):
        (folder / "in").mkdir()
        for i, data in enumerate(layers):
            (folder / "in" / f"s{i:03}.png").write_bytes(data)
    return make


def png_chunks(data):
    at = 8
    while at < len(data):
        length, = struct.unpack(">I", data[at:at + 4])
        yield at, data[at + 4:at + 8], length
        at += 12 + length


def read_png(layers):
    """None if Pillow refuses or the values are no gray values."""
    values = []
    for data in layers:
        try:
            image = Image.open(io.BytesIO(data))
            image.load()
        except Exception:
            return None
        if image.mode not in ("L", "I;16", "I") or image.info.get("transparency") is not None:
            return None
        values.append(np.array(image))
    return np.stack(values) if len({v.shape for v in values}) == 1 else None


def png(random):
    deep = volume(np.uint16)
    plain = [png_bytes(Image.fromarray(layer)) for layer in volume()]
    good = {"8": plain, "16": [png_bytes(Image.fromarray(layer)) for layer in deep]}
    for bits, layers in good.items():
        yield Case(f"plain{bits}", stack(layers), convert("in", *SIZE), read_png(layers), may_refuse=False)
        for n in range(40):
            changed = list(layers)
            i = random.randrange(len(layers))
            changed[i] = flipped(changed[i], random)
            wanted = read_png(changed)
            # libpng stops at a wrong checksum that Pillow passes over: refused is right too.
            yield Case(f"flip{bits}_{n}", stack(changed), convert("in", *SIZE), wanted)
        for n in range(13):
            changed = list(layers)
            changed[n % 4] = changed[n % 4][:random.randrange(len(changed[n % 4]))]
            yield Case(f"cut{bits}_{n}", stack(changed), convert("in", *SIZE), read_png(changed))
        for n, (at, name, length) in enumerate(list(png_chunks(layers[1]))):
            for what in ("without", "twice", "empty"):
                chunk = layers[1][at:at + 12 + length]
                empty = struct.pack(">I", 0) + name + struct.pack(">I", zlib.crc32(name))
                new = {"without": b"", "twice": chunk + chunk, "empty": empty}[what]
                changed = list(layers)
                changed[1] = layers[1][:at] + new + layers[1][at + 12 + length:]
                yield Case(f"{what}{bits}_{name.decode()}_{n}", stack(changed), convert("in", *SIZE), read_png(changed))
    for mode in ("P", "RGB", "RGBA", "LA"):
        for which in range(4):
            changed = list(plain)
            changed[which] = png_bytes(Image.fromarray(volume()[which]).convert(mode))
            yield Case(f"{mode}_{which}", stack(changed), convert("in", *SIZE), None)
        every = [png_bytes(Image.fromarray(layer).convert(mode)) for layer in volume()]
        yield Case(f"{mode}_all", stack(every), convert("in", *SIZE), None)
    for which in range(4):
        for size in ((6, 5), (7, 7), (1, 1)):
            changed = list(plain)
            changed[which] = png_bytes(Image.new("L", size, 7))
            yield Case(f"size_{which}_{size[0]}", stack(changed), convert("in", *SIZE), None)
        changed = list(plain)
        changed[which] = good["16"][which]
        yield Case(f"depth_{which}", stack(changed), convert("in", *SIZE), None)
        image = Image.fromarray(volume()[which])
        buffer = io.BytesIO()
        image.save(buffer, "png", transparency=3)
        changed[which] = buffer.getvalue()
        yield Case(f"transparent_{which}", stack(changed), convert("in", *SIZE), None)


# DICOM ----------------------------------------------------------------------------------------------------------------------------------
def dicom_layer(values, z, series, **changes):
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
    meta.MediaStorageSOPInstanceUID = generate_uid(entropy_srcs=[series, str(z)])
    meta.TransferSyntaxUID = changes.pop("syntax", ExplicitVRLittleEndian)
    data = Dataset()
    data.file_meta = meta
    data.SOPClassUID, data.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
    data.StudyInstanceUID, data.SeriesInstanceUID = "1.2.3", series
    data.Modality, data.PatientName = "CT", "a"
    data.Rows, data.Columns = values.shape
    data.PixelSpacing, data.SliceThickness = [0.1, 0.1], 0.1
    data.ImagePositionPatient, data.ImageOrientationPatient = [0, 0, 0.1 * z], [1, 0, 0, 0, 1, 0]
    data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
    data.BitsAllocated = 8 * values.dtype.itemsize
    data.BitsStored, data.HighBit = data.BitsAllocated, data.BitsAllocated - 1
    data.PixelRepresentation = 1 if values.dtype.kind == "i" else 0
    data.InstanceNumber = z + 1
    big = meta.TransferSyntaxUID == ExplicitVRBigEndian
    data.PixelData = values.astype(values.dtype.newbyteorder(">" if big else "<")).tobytes()
    for key, value in changes.items():
        if value is None:
            delattr(data, key)
        else:
            setattr(data, key, value)
    if len(data.PixelData) % 2:
        data.PixelData += b"\0"
    data.is_little_endian = not big
    data.is_implicit_VR = meta.TransferSyntaxUID == ImplicitVRLittleEndian
    buffer = io.BytesIO()
    pydicom.dcmwrite(buffer, data, write_like_original=False)
    return buffer.getvalue()


def series(files):
    def make(folder):
        (folder / "in").mkdir()
        for i, data in enumerate(files):
            (folder / "in" / f"i{i}.dcm").write_bytes(data)
    return make


def read_dicom(files):
    """Layers by their positions; None if pydicom refuses, or their positions or sizes are uneven."""
    try:
        layers = []
        for data in files:
            one = pydicom.dcmread(io.BytesIO(data), force=True)
            if one.get("NumberOfFrames", 1) not in (1, None) or one.PhotometricInterpretation != "MONOCHROME2":
                return None
            x, y, z = [float(v) for v in one.ImagePositionPatient]
            values = one.pixel_array.astype(float) * float(one.get("RescaleSlope", 1)) + float(one.get("RescaleIntercept", 0))
            layers.append((z, x, y, values, one.SeriesInstanceUID, [float(v) for v in one.PixelSpacing]))
        layers.sort(key=lambda layer: layer[0])
        steps = np.diff([layer[0] for layer in layers])
        same = all(layer[1:3] == layers[0][1:3] and layer[3].shape == layers[0][3].shape and layer[4:] == layers[0][4:] for layer in layers)
        if not same or steps.min() <= 0 or np.ptp(steps) > 0.02 * steps.mean():
            return None
        return np.stack([layer[3] for layer in layers])
    except Exception:
        return None


def dicom(random):
    for dtype in (np.uint16, np.int16, np.uint8):
        values = volume(dtype)
        files = [dicom_layer(layer, z, "1.2.3.4") for z, layer in enumerate(values)]
        yield Case(f"plain_{np.dtype(dtype)}", series(files), convert("in"), read_dicom(files), may_refuse=False)
        for n in range(45):
            changed = list(files)
            i = random.randrange(len(files))
            changed[i] = flipped(changed[i], random)
            # The middle of a flipped file may be a value of another attribute: both readers must agree, or ours refuse.
            wanted = read_dicom(changed)
            yield Case(f"flip_{np.dtype(dtype)}_{n}", series(changed), convert("in"), same_or_refused(values) if wanted is None else wanted)
        for n in range(12):
            changed = list(files)
            changed[n % 4] = changed[n % 4][:random.randrange(200, len(changed[n % 4]))]
            yield Case(f"cut_{np.dtype(dtype)}_{n}", series(changed), convert("in"), None)
    values = volume(np.uint16)

    def changed(name, every=True, readable=True, **changes):
        files = [dicom_layer(layer, z, "1.2.3.4", **(dict(changes) if every or z == 2 else {})) for z, layer in enumerate(values)]
        return Case(name, series(files), convert("in"), read_dicom(files) if readable else None)
    for meaning in ("MONOCHROME1", "PALETTE COLOR", "RGB", "YBR_FULL", "MONOCHROME3", ""):
        yield changed(f"meaning_{meaning or 'empty'}", PhotometricInterpretation=meaning)
        yield changed(f"meaning_one_{meaning or 'empty'}", every=False, PhotometricInterpretation=meaning)
    for frames in (2, 10, 0, 4):
        yield changed(f"frames_{frames}", NumberOfFrames=frames)
        yield changed(f"frames_one_{frames}", every=False, NumberOfFrames=frames)
    for rows, columns in ((3, 7), (12, 7), (6, 14), (7, 6), (6, 3), (0, 7), (6, 65535), (1, 42), (42, 1), (5, 7), (6, 8)):
        yield changed(f"rows_{rows}_{columns}", readable=(rows, columns) in ((7, 6), (1, 42), (42, 1)), Rows=rows, Columns=columns)
        yield changed(f"rows_one_{rows}_{columns}", every=False, readable=False, Rows=rows, Columns=columns)
    for slope, intercept in ((2, 0), (0.5, 0), (1, -1000), (1e-3, 0), (-1, 0), (0, 5), (3, 7)):
        yield changed(f"slope_{slope}_{intercept}", RescaleSlope=slope, RescaleIntercept=intercept)
        yield changed(f"slope_one_{slope}_{intercept}", every=False, RescaleSlope=slope, RescaleIntercept=intercept)
    for spacing in (None, [0.1, 0.2], [0.1], [-0.1, -0.1], [0, 0], [1e30, 1e30]):
        yield changed(f"spacing_{spacing}", readable=spacing == [0.1, 0.2], PixelSpacing=spacing)
    for place in (None, [0, 0, 0], [0, 0, 0.25], [0, 0, 7], [1, 0, 0.2], [0, 0, -1]):
        yield changed(f"place_one_{place}", every=False, readable=False, ImagePositionPatient=place)
    for axes in ([1, 0, 0, 0, -1, 0], [0, 1, 0, 1, 0, 0], [0.8, 0.6, 0, -0.6, 0.8, 0], [0, 0, 0, 0, 0, 0], [1, 0, 0, 1, 0, 0]):
        case = changed(f"axes_{axes}", ImageOrientationPatient=axes)
        case.wanted = "any" if axes in ([1, 0, 0, 0, -1, 0], [0, 1, 0, 1, 0, 0]) else None
        yield case
    for stored, high in ((12, 11), (8, 7), (16, 11), (12, 15), (17, 16), (0, 0)):
        case = changed(f"bits_{stored}_{high}", BitsStored=stored, HighBit=high)
        case.wanted = case.wanted if (stored, high) in ((12, 11), (8, 7)) else "any"
        yield case
    for syntax in (ImplicitVRLittleEndian, ExplicitVRBigEndian):
        yield changed(f"syntax_{syntax.name[:8]}", syntax=syntax)
    for samples in (3, 0, 2):
        yield changed(f"samples_{samples}", readable=False, SamplesPerPixel=samples)
    for n, data in enumerate((b"", b"\0\0", b"\1" * 82, b"\1" * 90, b"\1" * 168)):
        yield changed(f"data_{n}", readable=False, PixelData=data)
        yield changed(f"data_one_{n}", every=False, readable=False, PixelData=data)
    files = [dicom_layer(layer, z, "1.2.3.4") for z, layer in enumerate(values)]
    yield Case("missing", series(files[:2] + files[3:]), convert("in"), None)
    yield Case("twice", series(files + files[1:2]), convert("in"), None)
    yield Case("two_series", series(files + [dicom_layer(values[0], 9, "1.2.3.5")]), convert("in"), None)


# TIFF -----------------------------------------------------------------------------------------------------------------------------------
def tiff_bytes(values, **options):
    buffer = io.BytesIO()
    tifffile.imwrite(buffer, values, **options)
    return buffer.getvalue()


def read_tiff(data):
    try:
        with tifffile.TiffFile(io.BytesIO(data)) as file:
            pages = file.pages
            if any(page.photometric != 1 or page.samplesperpixel != 1 or page.shape != pages[0].shape or page.dtype != pages[0].dtype
                   or page.tags.valueof("Orientation", default=1) != 1 for page in pages):
                return None
            values = np.stack([page.asarray() for page in pages])
            return values if values.ndim == 3 else None
    except Exception:
        return None


def patch_tag(data, page, tag, value):
    """The value of a tag that fits into its entry, in a little-endian classic TIFF."""
    with tifffile.TiffFile(io.BytesIO(data)) as file:
        found = file.pages[page].tags.get(tag)
        if found is None:
            return None
        at = found.offset + 8
    return data[:at] + struct.pack("<I", value) + data[at + 4:]


def next_page_fields(data):
    at, = struct.unpack("<I", data[4:8])
    fields = []
    while at:
        count, = struct.unpack("<H", data[at:at + 2])
        fields.append((at, at + 2 + 12 * count))
        at, = struct.unpack("<I", data[fields[-1][1]:fields[-1][1] + 4])
    return fields


def tiff(random):
    def one(name, data, wanted="read", strict=False):
        return Case(name, write("in.tif", data), convert("in.tif", *SIZE), read_tiff(data) if isinstance(wanted, str) else wanted,
                    may_refuse=not strict)
    plain = {"photometric": "minisblack", "metadata": None}
    for dtype in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        values = volume(np.dtype(dtype).type)
        for name, options in {"plain": {}, "big": {"bigtiff": True}, "deflate": {"compression": "zlib"}, **({"predictor": {"compression": "zlib", "predictor": True}} if dtype[0] != "f" else {}),
                              "swapped": {"byteorder": ">"}, "tile": {"tile": (16, 16)}, "strip": {"rowsperstrip": 2}}.items():
            yield one(f"{name}_{dtype}", tiff_bytes(values, **plain, **options), strict=True)
    base = tiff_bytes(volume(), **plain)
    for n in range(60):
        data = flipped(base, random, 400)
        wanted = read_tiff(data)
        yield one(f"flip_{n}", data, same_or_refused(volume()) if wanted is None else wanted)
    for n in range(25):
        yield one(f"cut_{n}", base[:random.randrange(len(base))])
    for page in range(4):
        for tag, values in {"PhotometricInterpretation": (0, 2, 3, 4, 5, 6, 8, 99), "SamplesPerPixel": (0, 2, 3, 4), "ImageWidth": (0, 3, 70, 2**31),
                            "ImageLength": (0, 3, 60, 2**31), "BitsPerSample": (1, 4, 12, 16, 64), "Compression": (2, 5, 7, 99),
                            "StripByteCounts": (0, 10, 10**6), "StripOffsets": (0, 8, 10**6), "RowsPerStrip": (0, 1, 3)}.items():
            for value in values:
                data = patch_tag(base, page, tag, value)
                if data:  # libtiff takes a lookup table that is not there as gray values
                    yield one(f"{tag}_{value}_{page}", data, same_or_refused(volume()) if (tag[0], value) == ("P", 3) else "read")
    fields = next_page_fields(base)
    for i in range(4):
        for j in range(4):
            if j != i + 1:
                data = bytearray(base)
                data[fields[i][1]:fields[i][1] + 4] = struct.pack("<I", fields[j][0])
                # A loop, a page twice, or pages that are left out: 0 to 3 may be a shorter list, which no reader can tell.
                wanted = read_tiff(bytes(data)) if j > i else None
                yield one(f"loop_{i}_{j}", bytes(data), wanted)
    for orientation in range(2, 9):
        data = tiff_bytes(volume(), **plain, extratags=[(274, "H", 1, orientation, False)])
        yield one(f"orientation_{orientation}", data, None)
    for axes, shape in (("TZYX", (2, 3, 5, 6)), ("CZYX", (2, 3, 5, 6)), ("ZCYX", (3, 2, 5, 6)), ("TCYX", (2, 2, 5, 6)), ("CYX", (3, 5, 6)),
                        ("TYX", (3, 5, 6)), ("TZCYX", (2, 2, 2, 5, 6))):
        yield one(f"ome_{axes}", tiff_bytes(volume(np.uint8, shape), ome=True, metadata={"axes": axes}, photometric="minisblack"), None)
        yield one(f"shaped_{axes}", tiff_bytes(volume(np.uint8, shape), metadata={"axes": axes}, photometric="minisblack"), None)
        if axes != "CYX":
            order = "TZCYX"
            full = [dict(zip(axes, shape)).get(a, 1) for a in order]
            yield one(f"imagej_{axes}", tiff_bytes(volume(np.uint8, shape).reshape(full), imagej=True), None)
    for shape in ((3, 5, 6), (7, 5, 6)):
        for options in ({"ome": True, "metadata": {"axes": "ZYX"}}, {"metadata": {"axes": "ZYX"}}, {"imagej": True, "metadata": {"axes": "ZYX"}}):
            values = volume(np.uint8, shape)
            yield one(f"axes_{shape[0]}_{'ome' if 'ome' in options else 'imagej' if 'imagej' in options else 'shaped'}",
                      tiff_bytes(values, photometric="minisblack", **options), values, strict=True)
    yield one("white", tiff_bytes(volume(), photometric="miniswhite", metadata=None), None)
    yield one("palette", tiff_bytes(volume(), photometric="palette", colormap=np.zeros((3, 256), np.uint16), metadata=None), None)
    yield one("rgb", tiff_bytes(volume(np.uint8, (4, 5, 6, 3)), photometric="rgb", metadata=None), None)
    for n, shapes in enumerate((((6, 7), (6, 8)), ((6, 7), (5, 7)), ((6, 7), (3, 3), (6, 7)))):
        buffer = io.BytesIO()
        with tifffile.TiffWriter(buffer) as writer:
            for shape in shapes:
                writer.write(volume(np.uint8, shape), photometric="minisblack", metadata=None)
        yield one(f"mixed_{n}", buffer.getvalue(), None)
    for n, types in enumerate((("u1", "u2"), ("u2", "i2"), ("u2", "f4"))):
        buffer = io.BytesIO()
        with tifffile.TiffWriter(buffer) as writer:
            for dtype in types:
                writer.write(volume(np.dtype(dtype).type, (6, 7)), photometric="minisblack", metadata=None)
        yield one(f"types_{n}", buffer.getvalue(), None)


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
        wanted = values if values is not None and (values.dtype.kind == "b" or values.dtype.itemsize <= (8 if values.dtype.kind == "f" else 4)) else None
        # numpy.load passes over bytes behind the last value; ours may not.
        return Case(name, write("in.npy", data), convert("in.npy", *SIZE), wanted)
    values = volume(np.uint16, (3, 4, 5))
    body = values.tobytes()
    keys = {"descr": "'<u2'", "fortran_order": "False", "shape": "(3, 4, 5)"}
    import itertools
    for order in itertools.permutations(keys):
        for fortran in ("False", "True"):
            text = "{" + ", ".join(f"'{key}': {fortran if key == 'fortran_order' else keys[key]}" for key in order) + ", }"
            yield one(f"order_{'_'.join(k[0] for k in order)}_{fortran}", npy_bytes(text, body))
    for n, text in enumerate((
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5)}", '{"descr": "<u2", "fortran_order": False, "shape": (3, 4, 5)}',
            "{'descr': '>u2', 'fortran_order': False, 'shape': (3, 4, 5), }", "{'descr': '=u2', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '|u2', 'fortran_order': False, 'shape': (3, 4, 5), }", "{'descr': 'u2', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': True, 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5), 'shape': (5, 4, 3), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5, 1), }", "{'descr': '<u2', 'fortran_order': False, 'shape': (12, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (60,), }", "{'descr': '<u2', 'fortran_order': False, 'shape': (), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (-3, -4, 5), }", "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 0), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 99999999999999999999), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3L, 4L, 5L), }", "{'descr': '<u2', 'fortran_order': 0, 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': Falsehood, 'shape': (3, 4, 5), }", "{'descr': '<u2', 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': [3, 4, 5], }", "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5), 'x': 1, }",
            "{'descr': [('a', '<u2')], 'fortran_order': False, 'shape': (3, 4, 5), }", "{'descr': '<c8', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<u8', 'fortran_order': False, 'shape': (3, 4, 5), }", "{'descr': '<f2', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<M8[s]', 'fortran_order': False, 'shape': (3, 4, 5), }", "{'descr': '|O', 'fortran_order': False, 'shape': (3, 4, 5), }",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5), } 'fortran_order': True", "[]", "", "{", "{'descr'", "{'descr': ",
            "{'fortran_order': True, 'descr': '<u2', 'shape': (3, 4, 5), }", "{'a': \"'fortran_order': True\", 'descr': '<u2'}",
            "{'descr': '<u2', 'fortran_order': False, 'shape': (0x3, 4, 5), }", "{'descr': '<u2', 'fortran_order': False, 'shape': (3.0, 4, 5), }",
            "{'descr': '<u2',\t'fortran_order':\nFalse, 'shape':(3,4,5)}", "{'descr': '<u2', 'fortran_order': False, 'shape': (3, 4, 5)")):
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
    base = [("type", "uint16"), ("dimension", "3"), ("sizes", "5 4 3"), ("spacings", "0.1 0.1 0.1"), ("encoding", "raw"), ("endian", "little")]

    def one(name, changes, wanted=None, data=body, strict=False, size=SIZE):
        fields = [(key, changes.get(key, value)) for key, value in base if changes.get(key, value) is not None]
        fields += [(key, value) for key, value in changes.items() if key not in dict(base)]
        return Case(name, write("in.nrrd", nrrd_bytes(fields, data)), convert("in.nrrd", *size), wanted, may_refuse=not strict)
    yield one("plain", {}, values, strict=True)
    for kinds in ("domain domain domain", "space space space", "none none none", "??? ??? ???"):
        yield one(f"kinds_{kinds[:6].strip('?')}", {"kinds": kinds}, values, strict=True)
    for kind in ("RGB-color", "RGBA-color", "3-color", "vector", "3-vector", "time", "list", "scalar", "complex", "point", "normal", "2-vector",
                 "covariant-vector", "3D-matrix", "quaternion", "stub", "HSV-color", "tensor", "4-color", "XYZ-color"):
        for place in range(3):
            kinds = ["domain"] * 3
            kinds[place] = kind
            yield one(f"kind_{kind}_{place}", {"kinds": " ".join(kinds)})
    for skip, wanted, data in (("0", values, body), ("7", values, b"1234567" + body), ("-1", values, b"123" + body), ("7", None, body), ("-2", None, body),
                               ("x", None, body), ("1e3", None, body), ("1.5", None, body), ("-1", None, body[:-1])):
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
        yield one(f"direction_{number}", {"spacings": None, "space dimension": "3", "space directions": f"({number},0,0) (0,{number},0) (0,0,{number})",
                                          "space units": '"mm" "mm" "mm"'}, values[::-1, ::-1, ::-1] if number == "-1" else None, size=())
        if number not in ("0", "-1"):
            yield one(f"origin_{number}", {"spacings": None, "space dimension": "3", "space directions": "(0.1,0,0) (0,0.1,0) (0,0,0.1)",
                                           "space units": '"mm" "mm" "mm"', "space origin": f"({number},0,0)"},
                      values if number in ("1e-313", "1e-320") else None, size=())
    for key, options in {"dimension": ("2", "4", "0", "-3", "x", "3 3"), "sizes": ("5 4", "5 4 3 1", "0 4 3", "-5 4 3", "5.5 4 3", "1e9 1e9 1e9", "5 4 4", "5 4 2"),
                         "type": ("float", "uchar", "int64", "block", "half", "", "uint8"), "encoding": ("ascii", "hex", "bzip2", "text", "", "zrl"),
                         "endian": ("middle", "", "x"), "data file": ("LIST", "x%03d.raw 1 3 1", "/etc/passwd", "../outside.txt", "missing.raw", "."),
                         "units": ('"mm" "mm" "um"', '"mm"', '"mm" "mm" "'), "unknown": ("1",), "axis mins": ("0 0 0",), "old min": ("0",),
                         "kinds": ("domain", "domain domain", "domain domain domain domain")}.items():
        for value in options:
            yield one(f"{key}_{value[:12].replace('/', '_')}", {key: value})
    good = nrrd_bytes(base, body)
    yield Case("big", write("in.nrrd", nrrd_bytes([(k, "big" if k == "endian" else v) for k, v in base], values.byteswap().tobytes())),
               convert("in.nrrd", *SIZE), values, may_refuse=False)
    yield Case("gzip", write("in.nrrd", nrrd_bytes([(k, "gzip" if k == "encoding" else v) for k, v in base], gzip.compress(body))),
               convert("in.nrrd", *SIZE), values, may_refuse=False)
    for n in range(40):
        data = flipped(good, random, 120)
        yield Case(f"flip_{n}", write("in.nrrd", data), convert("in.nrrd", *SIZE), "any")
    for n in range(10):
        yield Case(f"cut_{n}", write("in.nrrd", good[:random.randrange(len(good))]), convert("in.nrrd", *SIZE), None)


def meta(random):
    values = volume(np.uint16, (3, 4, 5))
    body = values.tobytes()
    base = [("ObjectType", "Image"), ("NDims", "3"), ("BinaryData", "True"), ("ElementSpacing", "0.1 0.1 0.1"), ("DimSize", "5 4 3"),
            ("ElementType", "MET_USHORT")]

    def data_of(changes, data, name="LOCAL"):
        fields = [(key, changes.get(key, value)) for key, value in base if changes.get(key, value) is not None]
        fields += [(key, value) for key, value in changes.items() if key not in dict(base) and key != "ElementDataFile"]
        return ("".join(f"{k} = {v}\n" for k, v in fields) + f"ElementDataFile = {changes.get('ElementDataFile', name)}\n").encode() + data

    def one(name, changes, wanted=None, data=body, strict=False, size=SIZE):
        return Case(name, write("in.mha", data_of(changes, data)), convert("in.mha", *size), wanted, may_refuse=not strict)
    yield one("plain", {}, values, strict=True)
    yield one("big", {"ElementByteOrderMSB": "True"}, values.byteswap())
    yield one("orders", {"ElementByteOrderMSB": "True", "BinaryDataByteOrderMSB": "False"})
    for key, options in {"NDims": ("2", "4", "x", ""), "DimSize": ("5 4", "5 4 3 1", "0 4 3", "-5 4 3", "5.5 4 3", "1e9 1e9 1e9", "5 4 4", "5 4 2"),
                         "ElementType": ("MET_FLOAT", "MET_UCHAR", "MET_LONG", "MET_USHORT_ARRAY", ""), "ElementNumberOfChannels": ("3", "0"),
                         "BinaryData": ("False", "0", "x"), "CompressedData": ("True", "x"), "ObjectType": ("Mesh", "Scene"), "HeaderSize": ("4", "-1", "x"),
                         "ElementToIntensityFunctionSlope": ("2", "0", "nan"), "ElementToIntensityFunctionOffset": ("1",), "DistanceUnits": ("inch", "km"),
                         "ElementSpacing": ("1e305 1e305 1e305", "1e-320 1e-320 1e-320", "0 0 0", "-1 -1 -1", "nan nan nan", "0.1", "0.1 0.1 0.2"),
                         "TransformMatrix": ("1 0 0 0 1 0", "0 0 0 0 0 0 0 0 0", "0.8 0.6 0 -0.6 0.8 0 0 0 1", "nan 0 0 0 1 0 0 0 1", "1e300 0 0 0 1 0 0 0 0"),
                         "Offset": ("0 0", "nan 0 0", "1e300 0 0"),
                         "ElementDataFile": ("LIST", "x%03d.raw 1 3 1", "../outside.txt", "/etc/passwd", "missing.raw", "", ".")}.items():
        for value in options:
            for size in (SIZE, ("--image-unit", "0.001")):
                right = value == "0.1 0.1 0.2" and size != SIZE
                yield one(f"{key}_{value[:10].replace('/', '_')}_{len(size[0])}", {key: value}, values if right else None, size=size)
    for key, value in base:
        for again in (value, "0.2 0.2 0.2", "4 5 3"):
            yield Case(f"twice_{key}_{again.split()[0]}", write("in.mha", f"{key} = {again}\n".encode() + data_of({}, body)), convert("in.mha", *SIZE), None)
    for one_key, other in (("Offset", "Position"), ("Offset", "Origin"), ("TransformMatrix", "Rotation"), ("TransformMatrix", "Orientation")):
        numbers = "1 2 3" if one_key == "Offset" else "1 0 0 0 1 0 0 0 1"
        yield one(f"same_{one_key}_{other}", {one_key: numbers, other: numbers.replace("3", "4")})
    good = data_of({}, body)
    for n in range(60):
        yield Case(f"flip_{n}", write("in.mha", flipped(good, random, 150)), convert("in.mha", *SIZE), "any")
    for n in range(10):
        yield Case(f"cut_{n}", write("in.mha", good[:random.randrange(len(good))]), convert("in.mha", *SIZE), None)


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
    import tempfile
    with tempfile.TemporaryDirectory() as folder:
        open(f"{folder}/a.vti", "wb").write(data)
        done = subprocess.run([sys.executable, "-c", READER, f"{folder}/a.vti", f"{folder}/a.npy"], capture_output=True)
        return np.load(f"{folder}/a.npy") if done.returncode == 0 else None


def vti_text(values, form="ascii", header="UInt32", order="LittleEndian", apart=False, kind=None, body=None, extra=""):
    import base64
    names = {"u1": "UInt8", "i1": "Int8", "u2": "UInt16", "i2": "Int16", "u4": "UInt32", "i4": "Int32", "f4": "Float32", "f8": "Float64"}
    n = values.shape
    extent = f"0 {n[2]} 0 {n[1]} 0 {n[0]}"
    end = "<" if order == "LittleEndian" else ">"
    raw = values.astype(values.dtype.newbyteorder(end)).tobytes()
    length = struct.pack(end + ("I" if header == "UInt32" else "Q"), len(raw))
    text = body
    if text is None:
        text = " ".join(str(v) for v in values.ravel()) if form == "ascii" else (
            base64.b64encode(length).decode() + base64.b64encode(raw).decode() if apart else base64.b64encode(length + raw).decode())
    inline = "" if form == "appended" else text
    offset = ' offset="0"' if form == "appended" else ""
    appended = f'<AppendedData encoding="base64">_{text}</AppendedData>' if form == "appended" else ""
    return (f'<?xml version="1.0"?><VTKFile type="ImageData" version="1.0" byte_order="{order}" header_type="{header}">{extra}'
            f'<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="1e-4 1e-4 1e-4"><Piece Extent="{extent}"><CellData>'
            f'<DataArray type="{kind or names[values.dtype.str[1:]]}" Name="v" format="{form}"{offset}>{inline}</DataArray></CellData></Piece></ImageData>'
            f'{appended}</VTKFile>').encode()


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
                        yield one(f"{form}_{dtype}_{header}_{order}_{apart}", vti_text(values, form, header, order, apart), values, strict=True)
    for kind, value in (("UInt8", "300"), ("UInt8", "-1"), ("UInt8", "256"), ("UInt8", "1.5"), ("UInt8", "1e3"), ("Int8", "128"), ("Int8", "-129"),
                        ("Int8", "200"), ("UInt16", "65536"), ("UInt16", "-1"), ("UInt16", "70000"), ("Int16", "32768"), ("Int16", "-32769"),
                        ("Int32", "2147483648"), ("Int32", "1e10"), ("UInt32", "4294967296"), ("UInt32", "-1"), ("Float32", "nan"), ("Float32", "inf"),
                        ("Float32", "1e39"), ("Float64", "nan"), ("Float64", "1e400"), ("UInt8", "x"), ("UInt8", "0x10"), ("UInt8", "1,2"), ("UInt8", "")):
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
    for old, new in ((b'WholeExtent="0 5 0 4 0 3"', b'WholeExtent="0 5 0 4 0 4"'), (b'WholeExtent="0 5 0 4 0 3"', b'WholeExtent="0 4 0 5 0 3"'),
                     (b'Piece Extent="0 5 0 4 0 3"', b'Piece Extent="0 4 0 5 0 3"'), (b'Extent="0 5 0 4 0 3"', b'Extent="0 5 0 4"'),
                     (b'Extent="0 5 0 4 0 3"', b'Extent="5 0 4 0 3 0"'), (b"UInt16", b"UInt8"), (b"UInt16", b"UInt32"), (b"UInt16", b"String"),
                     (b"UInt16", b"Int64"), (b'format="binary"', b'format="ascii"'), (b'format="binary"', b'format="appended"'),
                     (b'header_type="UInt32"', b'header_type="UInt64"'), (b'Name="v"', b'Name="v" NumberOfComponents="3"'),
                     (b'Name="v"', b'Name="v" NumberOfComponents="2"'), (b"ImageData", b"PolyData"), (b'Spacing="1e-4 1e-4 1e-4"', b'Spacing="0 0 0"'),
                     (b'Spacing="1e-4 1e-4 1e-4"', b'Spacing="1e308 1e308 1e308"'), (b'Spacing="1e-4 1e-4 1e-4"', b'Spacing="1e-320 1e-320 1e-320"'),
                     (b'Origin="0 0 0"', b'Origin="nan 0 0"'), (b'Origin="0 0 0"', b'Origin="1e300 0 0"'), (b'Origin="0 0 0"', b'Origin="0 0"'),
                     (b"</VTKFile>", b""), (b"CellData", b"PointData")):
        yield one(f"header_{old[:12].decode()}_{new[-14:].decode(errors='replace')}".replace('"', "").replace("/", "_"), good.replace(old, new), None)
    for name, options in (("a", {}), ("b", {"apart": True})):
        base = vti_text(values, "binary", **options)
        at = base.index(b'format="binary">') + 16
        for n in (1, 2, 5, 10, 40, 75, 76, 100):
            yield one(f"line_{name}_{n}", base[:at + n] + b"\n" + base[at + n:], values)
            yield one(f"blank_{name}_{n}", base[:at + n] + b" " + base[at + n:], values)
            yield one(f"sign_{name}_{n}", base[:at + n] + b"=" + base[at + n + 1:], None)
            yield one(f"less_{name}_{n}", base[:at + n] + base[at + n + 4:], None)
    for n in range(40):
        data = flipped(good, random, 400)
        yield one(f"flip_{n}", data, "any")
    for n in range(15):
        yield one(f"cut_{n}", good[:random.randrange(len(good))], None)


# raw ------------------------------------------------------------------------------------------------------------------------------------
def raw(random):
    values = volume(np.uint16, (3, 4, 5))
    body = values.tobytes()
    flags = ("--image-type", "uint16", *SIZE)
    for name in ("in.raw", "in.RAW", "in.bin", "in.dat", "in.img", "in.vol", "in.data", "in"):
        yield Case(f"name_{name}", write(name, body), convert(name, "--image-dims", "5,4,3", *flags), values, may_refuse=False)
        yield Case(f"name_without_{name}", write(name, body), convert(name, *flags), None)
    yield Case("gz", write("in.raw.gz", gzip.compress(body)), convert("in.raw.gz", "--image-dims", "5,4,3", *flags), values, may_refuse=False)
    for dims in ("5,4", "5,4,3,1", "0,4,3", "-5,4,3", "5.5,4,3", "1e9,1e9,1e9", "5,4,4", "5,4,2", "nan,4,3", "inf,4,3", "1e308,1,1", "24,24,40] foo=[1",
                 "5,4,3]\nx=[1", "5,4,3 # a", "[5,4,3]", "5;4;3", "", "5,4,3,", "5 4 3", "0x5,4,3", "5,4,'3'", "5,4,3\"", "$(touch pwned)", "5,4,3];[1",
                 "5,,3", ",,", "1_0,4,3", "+5,4,3", "5,4,3}"):
        wanted = values if dims in ("5,4,3", "+5,4,3", "5,4,3,", "5 4 3", "[5,4,3]", "0x5,4,3") else None
        yield Case(f"dims_{dims[:14]}", write("in.raw", body), convert("in.raw", "--image-dims", dims, *flags), wanted)
    for skip in ("1", "7", "-1", "1e9", "nan", "1.5", "x", "120"):
        yield Case(f"skip_{skip}", write("in.raw", body), convert("in.raw", "--image-dims", "5,4,3", "--image-header-bytes", skip, *flags), None)
    yield Case("skip_right", write("in.raw", b"1234567" + body), convert("in.raw", "--image-dims", "5,4,3", "--image-header-bytes", "7", *flags), values)
    for kind in ("uint8", "uint32", "float32", "float64", "int64", "", "uint16,uint16"):
        yield Case(f"type_{kind}", write("in.raw", body), convert("in.raw", "--image-dims", "5,4,3", "--image-type", kind, *SIZE), None)
    for axes in ("xyz", "zyx", "x-yz", "xxz", "xy", "xyzz", "XYZ", "x-y-z-", "--xyz", "", "abc", "xy z"):
        yield Case(f"axes_{axes}", write("in.raw", body), convert("in.raw", "--image-dims", "5,4,3", f"--image-axes={axes}", *flags),
                   "any" if axes in ("xyz", "zyx", "x-yz") else None)
    for n in range(20):
        yield Case(f"gz_{n}", write("in.raw.gz", flipped(gzip.compress(body), random, 20)), convert("in.raw.gz", "--image-dims", "5,4,3", *flags),
                   None if n < 0 else "any")


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
        right = values[:len(names)] if isinstance(wanted, str) else wanted
        return Case(name, make, convert("in", *SIZE), right, may_refuse=not strict)
    patterns = {"padded": "s{:04}.tif", "unpadded": "s{}.tif", "bracket": "slice ({}).tif", "tail": "rec_{:04}_8bit.tif", "bin": "a_{:04}_bin2.tif",
                "date": "s{:04}_2024-01-05.tif", "size": "s{:04}_2.5um.tif", "upper": "S{:03}.TIF", "mixed": "2024_{:02}_3.tiff", "front": "{:03}_a.tif",
                "umlaut": "\u00e4{:03}.tif", "blank": "a b {}.tif", "quote": "a'b{}.tif", "long": "x" * 100 + "{:05}.tif", "hash": "a#{}.tif",
                "dollar": "$(touch pwned){}.tif", "semi": "a;touch pwned;{}.tif", "dots": "a..{}.tif", "zeros": "{:015}.tif"}
    for name, pattern in patterns.items():
        for start, step in ((0, 1), (1, 1), (95, 1), (0, 2), (7, 5)):
            yield one(f"{name}_{start}_{step}", [pattern.format(start + i * step) for i in range(11)], "read", strict=True)
        for gone in (3, 7):
            numbers = [i for i in range(12) if i != gone]
            yield one(f"{name}_without_{gone}", [pattern.format(i) for i in numbers], None)
    good = ["s{:04}.tif".format(i) for i in range(10)]
    for other in ("a_preview.tif", "overview.tif", "s_mip.tif", "s0003 (copy).tif", "s0003_copy.tif", "rec_spr.tif", "0.tif", "s0003.TIFF", "S0003.tif",
                  "s-0001.tif", "s0010_b.tif", "t0010.tif", "s0011.tif", "s0009 .tif", "s1e3.tif", "s00.10.tif", "s.tif", "zz.tif", "s0003.5.tif"):
        yield one(f"with_{other}", good + [other], None)
    for other in ("log.txt", "scan.log", ".hidden.tif", "a.xml", "thumbs.db"):
        yield one(f"beside_{other}", good, "read", others=[other], strict=True)
    yield one("position", [f"z{0.5 + 0.1 * i:.1f}mm.tif" for i in range(11)], "read", strict=True)
    yield one("position_gap", [f"z{0.5 + 0.1 * i:.1f}mm.tif" for i in range(12) if i != 6], None)
    yield one("no_numbers", ["a.tif", "b.tif", "c.tif"], None)
    yield one("png_too", good + ["a.png"], None)
    yield one("empty_file", good, None, others=["s0010.tif"])


def kinds(_program):
    return {"png": png, "dicom": dicom, "tiff": tiff, "npy": npy, "nrrd": nrrd, "meta": meta, "vti": vti, "raw": raw, "folders": folders}
