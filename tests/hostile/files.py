"""Packings, cases; files of the user in the way; machines without room."""

import json
import resource

import numpy as np

from corpus import Case
from images import flipped, write

# Packings -------------------------------------------------------------------------------------------------------------------------------
PACKING = {
    "format": "porepack-packing",
    "version": 1,
    "container": {"kind": "box", "size_m": [0.012, 0.012, 0.012], "periodic": [True, True, True]},
    "shapes": [{"id": "s", "capsules": [{"a_m": [0, 0, 0], "b_m": [0, 0, 0], "radius_m": 0.004}]}],
    "bodies": [{"shape": "s", "position_m": [0.006, 0.006, 0.006], "orientation": [1, 0, 0, 0]}],
}
VOXELS = ["voxelise", "in.json", "--voxel-size", "1e-3", "--output", "o"]


def packing_json(random):
    text = json.dumps(PACKING)

    def porosity(folder, _output):
        found = json.loads((folder / "o" / "voxelise.result.json").read_text())["porosity"]
        wanted = 1 - 4 / 3 * np.pi * 0.004**3 / 0.012**3
        return "" if abs(found - wanted) < 2e-3 else f"porosity {found}, not {wanted}"

    def one(name, data, wanted=None, strict=False):
        return Case(
            name, write("in.json", data if isinstance(data, bytes) else data.encode()), VOXELS, wanted, writes=("o",), may_refuse=not strict
        )

    yield one("plain", text, porosity, strict=True)
    yield one("spaces", json.dumps(PACKING, indent=3), porosity, strict=True)

    def leaves(value, path=()):
        if isinstance(value, dict):
            for key in value:
                yield from leaves(value[key], path + (key,))
        elif isinstance(value, list):
            for i, one in enumerate(value):
                yield from leaves(one, path + (i,))
        else:
            yield path

    def changed(path, value):
        copy = json.loads(text)
        place = copy
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value
        return json.dumps(copy)

    wrong = ("x", None, [], {}, True, 1e308, -1e308, float("nan"), float("inf"), -1, 10**400, "$(touch pwned)")
    for path in leaves(PACKING):
        for value in wrong:
            # Numbers may be large where they only move a body in a periodic box: then the porosity stays.
            may = (
                path[-1:] != ()
                and "position_m" in path
                and value == -1
                or "periodic" in path
                or "a_m" in path
                or "b_m" in path
                or "orientation" in path
            )
            try:
                data = changed(path, value)
            except (OverflowError, ValueError):
                continue
            yield one(
                f"{'.'.join(map(str, path))}={str(value)[:12]}".replace("/", "_"),
                data,
                "any" if may or value == "s" else (None if not ("id" in path or "version" in path and value is True) else "any"),
            )
    for key in PACKING:
        copy = dict(PACKING)
        del copy[key]
        yield one(f"without_{key}", json.dumps(copy), None)
        yield one(f"twice_{key}", text[:-1] + f', "{key}": {json.dumps(PACKING[key])}}}', None)
    for n, bad in enumerate(
        (
            "",
            "[]",
            "{}",
            "null",
            "1",
            text[:-1],
            text + text,
            text + "x",
            "{" * 100000,
            "[" * 1000000,
            text.replace('"radius_m"', '"radius_m": 1, "radius_m"'),
            text.replace("0.004", "0x4"),
            text.replace("0.004", "4e-3,"),
            text.replace("0.004", ".004"),
            "\ufeff" + text,
            text.replace(",", ",,"),
        )
    ):
        yield one(f"text_{n}", bad, "any" if n == 14 else None)
    for n in range(40):
        yield one(f"flip_{n}", flipped(text.encode(), random, 200), "any")


# Cases ----------------------------------------------------------------------------------------------------------------------------------
CASE = """[shape]
kind = "sphere"
diameter_m = 0.01
[container]
kind = "cylinder"
diameter_m = 0.03
height_m = 0.1
[packing]
grains = 18
[geometry]
trim_m = 0.008
voxel_size_m = 1.2e-3
[openfoam]
enabled = false
"""


def case_toml(random):
    def one(name, data, wanted=None, strict=False):
        return Case(
            name,
            write("c/case.toml", data if isinstance(data, bytes) else data.encode()),
            ["run", "c", "--dry-run"],
            wanted,
            writes=(),
            may_refuse=not strict,
            seconds=30,
        )

    yield one("plain", CASE, "any", strict=True)
    lines = CASE.splitlines()
    for n, line in enumerate(lines):
        if "=" not in line:
            yield one(f"table_{line}", CASE.replace(line, line[:-1] + "x]"), None)
            yield one(f"table_twice_{line}", CASE + line + "\n", None)
            continue
        key, value = line.split(" = ")
        for bad in (
            "nan",
            "inf",
            "-inf",
            "1e308",
            "-1",
            "[]",
            "{}",
            '"x"',
            "true",
            "1979-05-27",
            "1e-320",
            "[1, 2]",
            '"$(touch pwned)"',
            "99999999999999999999",
        ):
            if bad == value or (key == "kind" and bad == '"x"' and False):
                continue
            new = lines[:n] + [f"{key} = {bad}"] + lines[n + 1 :]
            yield one(f"{key}={bad}", "\n".join(new), "any" if key == "enabled" and bad == "true" else None)
        yield one(f"{key}_twice", "\n".join(lines[: n + 1] + lines[n:]), None)
        yield one(f"{key}_unknown", "\n".join(lines[:n] + [f"{key}_x = {value}"] + lines[n:]), None)
    for n, bad in enumerate(
        (
            "",
            "[",
            "[shape",
            "=",
            "a = ",
            "\0",
            "[shape]\n" * 2,
            "[[shape]]",
            "x = 1\n",
            "[shape]\nkind='''",
            "\ufeff[shape]",
            "a.b.c = 1",
            "a = " + "[" * 100000,
        )
    ):
        yield one(f"text_{n}", bad, None)
        yield one(f"text_behind_{n}", CASE + bad, "any" if n in (0,) else None)
    for n in range(40):
        yield one(f"flip_{n}", flipped(CASE.encode(), random, 300), "any")


# What is the user's -----------------------------------------------------------------------------------------------------------------------
def lost(_random):
    """Each name that a command writes is taken by a file or a folder of the user. `run_case` sees every change."""
    packing = json.dumps(PACKING)
    commands = {
        "voxelise": VOXELS,
        "lbm": ["lbm", "in.json", "--voxel-size", "1.5e-3", "--grids", "1", "--output", "o"],
        "stl": ["stl", "in.json", "--output", "o"],
        "slices": ["slices", "in.json", "--slice-spacing", "1e-3", "--slice-pixel", "1e-3", "--output", "o"],
    }
    names = (
        "precious.txt",
        "pore.vti",
        "flow.vti",
        "solid.stl",
        "voxelise.result.json",
        "lbm.result.json",
        "slices",
        "slices/s.png",
        "history.csv",
        "result.json",
        "manifest.json",
        "voxelise_1",
        "porosity.csv",
        "slices/slices.json",
        "voxelise.manifest.json",
        "stl.result.json",
    )

    def mine(folder, name, kind):
        path = folder / "o" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if kind == "file":
            path.write_text("mine")
        elif kind == "folder":
            path.mkdir(exist_ok=True)
            (path / "precious.txt").write_text("mine")
        else:
            (folder / "elsewhere.txt").write_text("mine")
            path.symlink_to(folder / "elsewhere.txt")

    for command, words in commands.items():
        for name in names:
            for kind in ("file", "folder", "link"):

                def make(folder, name=name, kind=kind):
                    write("in.json", packing.encode())(folder)
                    mine(folder, name, kind)

                def kept(folder, _output, name=name, kind=kind):
                    path = folder / "o" / name
                    if kind == "file":
                        return "" if path.is_file() and path.read_text() == "mine" else f"o/{name} was replaced"
                    if kind == "folder":
                        return "" if (path / "precious.txt").exists() else f"o/{name}/precious.txt is gone"
                    return (
                        ""
                        if (folder / "elsewhere.txt").read_text() == "mine" and path.is_symlink()
                        else f"o/{name}: the link was followed or replaced"
                    )

                # After a refusal the tree is compared as a whole, for "o" is no name that may change then.
                case = Case(f"{command}_{name.replace('/', '_')}_{kind}", make, words, kept, writes=("o",))
                case.user_file = ("o/" + name, kind)
                yield case
    for target, command in {"in.json": VOXELS[:-1] + ["in.json"], "in.json/x": VOXELS[:-1] + ["in.json/x"]}.items():
        yield Case(f"output_is_{target.replace('/', '_')}", write("in.json", packing.encode()), command, None, writes=())


# Machines ---------------------------------------------------------------------------------------------------------------------------------
def limits(_random):
    commands = {
        "voxelise": ["voxelise", "in.json", "--voxel-size", "2e-4", "--output", "o"],
        "lbm": ["lbm", "in.json", "--voxel-size", "1e-3", "--grids", "1", "--output", "o"],
        "stl": ["stl", "in.json", "--output", "o"],
        "convert": ["image", "convert", "in.npy", "out.npy", "--image-voxel-size", "1e-4"],
        "slices": ["slices", "in.json", "--slice-spacing", "1e-3", "--slice-pixel", "1e-4", "--output", "o"],
    }

    def make(folder):
        write("in.json", json.dumps(PACKING).encode())(folder)
        np.save(folder / "in.npy", np.zeros((40, 50, 60), np.uint8))

    def whole(folder, output):
        for path in folder.rglob("*"):
            if path.is_file() and path.suffix == ".vti" and not path.read_bytes().endswith(b"</VTKFile>\n"):
                return f"{path.name} ends early"
            if path.suffix == ".json":
                json.loads(path.read_text())
            if path.suffix == ".png" and b"IEND" not in path.read_bytes()[-12:]:
                return f"{path.name} ends early"
            if path.name == "out.npy" and np.load(path).shape != (40, 50, 60):
                return "out.npy has another shape"
        return ""

    for name, words in commands.items():
        for size in (0, 1, 100, 1000, 4096, 20000, 65536):
            yield Case(f"file_{name}_{size}", make, words, whole, writes=("o", "out.npy"), limits={resource.RLIMIT_FSIZE: size})
        for stack in (64 << 10, 256 << 10, 1 << 20):
            yield Case(f"stack_{name}_{stack}", make, words, whole, writes=("o", "out.npy"), limits={resource.RLIMIT_STACK: stack})
        for memory in (300 << 20, 400 << 20, 600 << 20):
            yield Case(f"memory_{name}_{memory >> 20}", make, words, "any", writes=("o", "out.npy"), limits={resource.RLIMIT_AS: memory})
        for files in (8, 12, 16):
            yield Case(f"files_{name}_{files}", make, words, whole, writes=("o", "out.npy"), limits={resource.RLIMIT_NOFILE: files})


def kinds(_program):
    return {"json": packing_json, "toml": case_toml, "lost": lost, "limits": limits}
