"""Images of PNG and TIFF."""

import io
import struct
import warnings
import zlib

import numpy as np
import tifffile
from PIL import Image

from corpus import Case

warnings.simplefilter("ignore")
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
        data = data[: random.randrange(len(data))]
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
        (length,) = struct.unpack(">I", data[at : at + 4])
        yield at, data[at + 4 : at + 8], length
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
            changed[n % 4] = changed[n % 4][: random.randrange(len(changed[n % 4]))]
            yield Case(f"cut{bits}_{n}", stack(changed), convert("in", *SIZE), read_png(changed))
        for n, (at, name, length) in enumerate(list(png_chunks(layers[1]))):
            for what in ("without", "twice", "empty"):
                chunk = layers[1][at : at + 12 + length]
                empty = struct.pack(">I", 0) + name + struct.pack(">I", zlib.crc32(name))
                new = {"without": b"", "twice": chunk + chunk, "empty": empty}[what]
                changed = list(layers)
                changed[1] = layers[1][:at] + new + layers[1][at + 12 + length :]
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


# TIFF -----------------------------------------------------------------------------------------------------------------------------------
def tiff_bytes(values, **options):
    buffer = io.BytesIO()
    tifffile.imwrite(buffer, values, **options)
    return buffer.getvalue()


def read_tiff(data):
    try:
        with tifffile.TiffFile(io.BytesIO(data)) as file:
            pages = file.pages
            if any(
                page.photometric != 1
                or page.samplesperpixel != 1
                or page.shape != pages[0].shape
                or page.dtype != pages[0].dtype
                or page.tags.valueof("Orientation", default=1) != 1
                for page in pages
            ):
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
    return data[:at] + struct.pack("<I", value) + data[at + 4 :]


def next_page_fields(data):
    (at,) = struct.unpack("<I", data[4:8])
    fields = []
    while at:
        (count,) = struct.unpack("<H", data[at : at + 2])
        fields.append((at, at + 2 + 12 * count))
        (at,) = struct.unpack("<I", data[fields[-1][1] : fields[-1][1] + 4])
    return fields


def tiff(random):
    def one(name, data, wanted="read", strict=False):
        return Case(
            name,
            write("in.tif", data),
            convert("in.tif", *SIZE),
            read_tiff(data) if isinstance(wanted, str) else wanted,
            may_refuse=not strict,
        )

    plain = {"photometric": "minisblack", "metadata": None}
    for dtype in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        values = volume(np.dtype(dtype).type)
        for name, options in {
            "plain": {},
            "big": {"bigtiff": True},
            "deflate": {"compression": "zlib"},
            **({"predictor": {"compression": "zlib", "predictor": True}} if dtype[0] != "f" else {}),
            "swapped": {"byteorder": ">"},
            "tile": {"tile": (16, 16)},
            "strip": {"rowsperstrip": 2},
        }.items():
            yield one(f"{name}_{dtype}", tiff_bytes(values, **plain, **options), strict=True)
    base = tiff_bytes(volume(), **plain)
    for n in range(60):
        data = flipped(base, random, 400)
        wanted = read_tiff(data)
        yield one(f"flip_{n}", data, same_or_refused(volume()) if wanted is None else wanted)
    for n in range(25):
        yield one(f"cut_{n}", base[: random.randrange(len(base))])
    for page in range(4):
        for tag, values in {
            "PhotometricInterpretation": (0, 2, 3, 4, 5, 6, 8, 99),
            "SamplesPerPixel": (0, 2, 3, 4),
            "ImageWidth": (0, 3, 70, 2**31),
            "ImageLength": (0, 3, 60, 2**31),
            "BitsPerSample": (1, 4, 12, 16, 64),
            "Compression": (2, 5, 7, 99),
            "StripByteCounts": (0, 10, 10**6),
            "StripOffsets": (0, 8, 10**6),
            "RowsPerStrip": (0, 1, 3),
        }.items():
            for value in values:
                data = patch_tag(base, page, tag, value)
                if data:  # libtiff takes a lookup table that is not there as gray values
                    yield one(f"{tag}_{value}_{page}", data, same_or_refused(volume()) if (tag[0], value) == ("P", 3) else "read")
    fields = next_page_fields(base)
    for i in range(4):
        for j in range(4):
            if j != i + 1:
                data = bytearray(base)
                data[fields[i][1] : fields[i][1] + 4] = struct.pack("<I", fields[j][0])
                # A loop, a page twice, or pages that are left out: 0 to 3 may be a shorter list, which no reader can tell.
                wanted = read_tiff(bytes(data)) if j > i else None
                yield one(f"loop_{i}_{j}", bytes(data), wanted)
    for orientation in range(2, 9):
        data = tiff_bytes(volume(), **plain, extratags=[(274, "H", 1, orientation, False)])
        yield one(f"orientation_{orientation}", data, None)
    for axes, shape in (
        ("TZYX", (2, 3, 5, 6)),
        ("CZYX", (2, 3, 5, 6)),
        ("ZCYX", (3, 2, 5, 6)),
        ("TCYX", (2, 2, 5, 6)),
        ("CYX", (3, 5, 6)),
        ("TYX", (3, 5, 6)),
        ("TZCYX", (2, 2, 2, 5, 6)),
    ):
        yield one(f"ome_{axes}", tiff_bytes(volume(np.uint8, shape), ome=True, metadata={"axes": axes}, photometric="minisblack"), None)
        yield one(f"shaped_{axes}", tiff_bytes(volume(np.uint8, shape), metadata={"axes": axes}, photometric="minisblack"), None)
        if axes != "CYX":
            order = "TZCYX"
            full = [dict(zip(axes, shape)).get(a, 1) for a in order]
            yield one(f"imagej_{axes}", tiff_bytes(volume(np.uint8, shape).reshape(full), imagej=True), None)
    for shape in ((3, 5, 6), (7, 5, 6)):
        for options in (
            {"ome": True, "metadata": {"axes": "ZYX"}},
            {"metadata": {"axes": "ZYX"}},
            {"imagej": True, "metadata": {"axes": "ZYX"}},
        ):
            values = volume(np.uint8, shape)
            yield one(
                f"axes_{shape[0]}_{'ome' if 'ome' in options else 'imagej' if 'imagej' in options else 'shaped'}",
                tiff_bytes(values, photometric="minisblack", **options),
                values,
                strict=True,
            )
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


def kinds(_program):
    return {"png": png, "tiff": tiff}
