"""Series of DICOM files."""

import io
import logging
import warnings

import numpy as np
import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRBigEndian, ExplicitVRLittleEndian, ImplicitVRLittleEndian, generate_uid

from corpus import Case
from images import convert, flipped, same_or_refused, volume

warnings.simplefilter("ignore")
logging.disable(logging.CRITICAL)


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
            changed[n % 4] = changed[n % 4][: random.randrange(200, len(changed[n % 4]))]
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


def kinds(_program):
    return {"dicom": dicom}
