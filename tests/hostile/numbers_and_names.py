"""Numbers that mean nothing in every numeric flag, lists that smuggle in other keys, and texts that are commands elsewhere."""

import json
import re
import subprocess

from corpus import Case
from files import CASE, PACKING, write

NUMBERS = ("nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "1e-320", "-1", "0", "1e30", "", "x", "0x10", "1,2", "1 2", "1;2")

# A small command for each subcommand whose flags are tried; files: in.json is a box with one sphere, in.csv a curve, in.npy an image.
COMMANDS = {
    "voxelise": "voxelise in.json --voxel-size 1.5e-3 --output o",
    "lbm": "lbm in.json --voxel-size 1.5e-3 --grids 1 --output o",
    "stl": "stl in.json --output o",
    "slices": "slices in.json --slice-spacing 2e-3 --slice-pixel 2e-3 --output o",
    "tortuosity shortest_path": "tortuosity shortest_path in.json --voxel-size 1.5e-3 --output o",
    "shape": "shape tetrapod --sphericity 0.6 --volume 1e-6 --output o",
    "falling-head simulate": "falling-head simulate --permeability 6e-7 --output o",
    "falling-head analyse": "falling-head analyse in.csv --output o",
    "falling-head plan": "falling-head plan --permeability 6.3e-7 --inertial-permeability 4.4e-3 --noise 1e-3 --runs 1 "
    "--glycerol-fractions 0 --output o",
    "image info": "image info in.npy --image-voxel-size 1e-4",
    "image simulate": "image simulate walls.json out.npy --voxel-size 1e-3 --views 20",
    "image plan": "image plan walls.json --dry-run",
    "forchheimer": "forchheimer in.json --dry-run",
    "foam": "foam in.json --dry-run",
    "pores": "pores in.json --output o",
    "pack": "pack c --dry-run",
    "run": "run c --dry-run",
    "design": "design --permeability 2e-7 --volume 7.33e-7 --container cylinder:0.1,0.4 --shape tetrapod --dry-run",
}


def flags_of(program, command):
    """Names and types of the numeric flags, from --help."""
    words = command.split()
    text = subprocess.run([program, *words, "--help"], capture_output=True, text=True).stdout
    found = []
    for match in re.finditer(
        r"^  (--[a-z-]+) ((?:whole )?number|\d+(?: to \d+)? numbers|range|number or range|number or free)", text, re.M
    ):
        if match.group(1) != "--threads":
            found.append(match.group(1))
    return found


def inputs(folder):
    write("in.json", json.dumps(PACKING).encode())(folder)
    walls = json.loads(json.dumps(PACKING))
    del walls["container"]["periodic"]
    write("walls.json", json.dumps(walls).encode())(folder)
    write("c/case.toml", CASE.encode())(folder)
    rows = "".join(f"{0.1 * i},{1.6 - 0.02 * i - 0.0005 * i * i}\n" for i in range(45))
    write("in.csv", ("time_s,level_m\n" + rows).encode())(folder)
    import numpy as np

    np.save(folder / "in.npy", (np.indices((6, 7, 8)).sum(0) % 3 == 0).astype(np.uint8))


def finite(folder, output):
    """No result has a number that is none, apart from null."""
    for path in folder.rglob("*.json"):
        if re.search(r"(?<![\"\w])-?(nan|NaN|inf|Infinity)\b", path.read_text()):
            return f"{path.name} has a number that is not finite"
    return "the output has a number that is not finite" if re.search(r": -?(nan|inf)\b", output) else ""


def numbers(program):
    def cases(random):
        for command, line in COMMANDS.items():
            words = line.split()
            for flag in flags_of(program, command):
                for value in NUMBERS:
                    new = list(words)
                    if flag in new:
                        new[new.index(flag) + 1] = value
                    else:
                        new.append(f"{flag}={value}")
                    if flag in words:
                        new = [
                            f"{flag}={value}" if i == words.index(flag) else w for i, w in enumerate(words) if i != words.index(flag) + 1
                        ]
                    nothing = value in ("nan", "inf", "-inf", "x", "")
                    yield Case(
                        f"{command} {flag}={value}", inputs, new, None if nothing else finite, writes=("o", "out.npy", "walls"), seconds=30
                    )

    return cases


def lists(_program):
    def cases(random):
        for bad in (
            "0.001,0.002] fill=[1",
            "[0.001,0.002]]",
            "0.001\n,0.002",
            "0.001,0.002 # x",
            "0.001,0.002]\n[packing]\ngrains = 3 #",
            "0.001;0.002",
            "0.001,,0.002",
            "0.001,0.002,",
            "'0.001',0.002",
            "{a=1},2",
            "0.001,$(touch pwned)",
            "`touch pwned`",
            "0.001,0.002]; [1",
            "1979-05-27,1",
            "0.001,true",
            '"0.001,0.002"',
            "0.001\t0.002",
            "0.001,0.002\0",
            "0.001, 0.002]\r\nx = [1",
            "[[0.001],[0.002]]",
        ):
            for command in (
                "voxelise in.json --voxel-size 1.5e-3 --output o --section={}",
                "lbm in.json --voxel-size 1.5e-3 --grids 1 --output o --section={}",
                "image info in.npy --image-voxel-size={}",
                "falling-head simulate --permeability 6e-7 --levels={} --output o",
                "run c --dry-run --output o --set geometry.section_m={}",
                "run c --dry-run --output o --set packing.grains={}",
            ):
                head, _, tail = command.partition("{}")
                words = head.split()
                words[-1] = words[-1] + bad
                yield Case(f"{command[:20]} {bad[:14]!r}", inputs, words + tail.split(), "any", writes=("o",), seconds=30)

    return cases


TEXTS = (
    '"; system("touch pwned"); "',
    "`touch pwned`",
    "$(touch pwned)",
    "'; touch pwned; '",
    'a\nsystem("touch pwned")\n#',
    "< touch pwned",
    "| touch pwned",
    "../../pwned",
    "/tmp/../tmp/pwned_by_corpus",
    "..",
    ".",
    "",
    "a/b",
    "<script>pwned</script>",
    '" onerror="pwned',
    "\u202etxt.exe",
    "\x1b[31mred",
    "a\rb",
    "%s%n%n",
    "{0}{}",
    '\\"; !touch pwned',
    "''",
    '""',
    "a'b",
    "${HOME}",
    "~",
    "-rf",
    "--output",
    "con\tx",
    "x" * 3000,
)


def names(program):
    study = """base = "."
up_to = "lbm"
[[axis]]
key = "packing.seed"
values = [1, 2]
[[figure]]
name = {name}
x = {x}
y = {y}
title = {title}
"""

    def quoted(text):
        return json.dumps(text, ensure_ascii=True)

    def looked_at(folder, output):
        for path in folder.rglob("*"):
            if path.is_file() and path.suffix in (".svg", ".html", ".md"):
                text = path.read_text(errors="replace")
                if "<script>pwned" in text or re.search(r'<[^>"]*("[^"]*"[^>"]*)*onerror="pwned', text):
                    return f"{path.name} has markup of the input"
        return "the terminal was given an escape sequence" if "\x1b[31m" in output else ""

    def cases(random):
        header = "point,current,packing.seed,porosity,permeability_m2"
        for n, text in enumerate(TEXTS):
            for field in ("name", "x", "y", "title"):
                values = {"name": quoted("f"), "x": quoted("porosity"), "y": quoted("permeability_m2"), "title": quoted("t")}
                values[field] = quoted(text)

                def make(folder, values=values):
                    write("s/case.toml", CASE.encode())(folder)
                    write("s/study.toml", study.format(**values).encode())(folder)
                    write("s/study.csv", f"{header}\n1,yes,1,0.46,8.1e-08\n2,yes,2,0.45,8.6e-08\n".encode())(folder)

                yield Case(f"figure_{field}_{n}", make, ["study", "plot", "s"], looked_at, writes=("s",), seconds=60)
            if "\0" not in text:
                for command in (
                    ["run", "c", "--dry-run", "--output", text],
                    ["voxelise", text, "--voxel-size", "1e-3"],
                    ["image", "info", text],
                    ["study", "plot", text],
                    ["run", "c", "--dry-run", "--output", "o", "--set", f"shape.kind={text}"],
                    ["stl", "in.json", "--output", text],
                    [text],
                    ["shape", text],
                    ["compare", text, "c"],
                    ["falling-head", "analyse", text],
                ):
                    if command[0] == "stl" and (text.startswith(("..", "/")) or text in ("", ".")):
                        continue  # where the user says
                    yield Case(
                        f"{command[0][:10]}_{command[1][:8] if len(command) > 1 else ''}_{n}".replace("/", "_"),
                        inputs,
                        command,
                        looked_at,
                        writes=(
                            "o",
                            text.strip("/") or "x",
                            "solid.stl",
                            "..",
                            "a",
                            "a/b",
                            "stl.result.json",
                            "stl.manifest.json",
                            "~",
                            "-rf",
                            "--output",
                        ),
                        seconds=60,
                    )

            def quantities(folder, text=text):
                one = {"quantities": [{"name": text, "unit": text, "value": 1.0, "uncertainty": {"interval": [0.9, 1.1]}}]}
                write("r/result.json", json.dumps(one).encode())(folder)
                write("q/result.json", json.dumps(one).encode())(folder)

            yield Case(f"compare_{n}", quantities, ["compare", "r", "q", "--output", "o"], looked_at, writes=("o",), seconds=60)

            def shape(folder, text=text):
                packing = json.loads(json.dumps(PACKING))
                packing["shapes"][0]["id"] = packing["bodies"][0]["shape"] = text
                write("in.json", json.dumps(packing).encode())(folder)

            yield Case(
                f"shape_{n}", shape, ["voxelise", "in.json", "--voxel-size", "2e-3", "--output", "o"], looked_at, writes=("o",), seconds=60
            )

    return cases


def kinds(program):
    return {"numbers": numbers(program), "lists": lists(program), "names": names(program)}
