"""What the scripts `compute` of the subjects share: runs of porepack, and rows of ours.csv and control.csv."""

import argparse
import csv
import datetime
import json
import math
import os
import pathlib
import re
import subprocess
import tempfile

POREPACK = os.environ.get("POREPACK", "porepack")


def porepack(*arguments):
    """The JSON that a command prints."""
    done = subprocess.run([POREPACK, *map(str, arguments), "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit("porepack " + " ".join(map(str, arguments)) + "\n" + done.stderr)
    return json.loads(done.stdout)


def case_of(folder, source, **settings):
    """A copy of the case `source` with other keys: packing__seed=2 sets seed in [packing]."""
    text = (pathlib.Path(source) / "case.toml").read_text()
    for name, value in settings.items():
        table, key = name.split("__")
        begin = text.index(f"[{table}]\n") + len(table) + 3
        end = text.find("\n[", begin)
        body = text[begin:] if end < 0 else text[begin:end]
        line = f"{key} = {value}"
        changed = re.sub(rf"(?m)^{key} = .*$", line, body) if re.search(rf"(?m)^{key} = ", body) else line + "\n" + body
        text = text[:begin] + changed + ("" if end < 0 else text[end:])
    folder.mkdir(parents=True)
    (folder / "case.toml").write_text(text)
    return folder


def result(case, stage):
    return json.loads((case / "results" / stage / "result.json").read_text())


def write_packing(path, container, shapes, bodies, overlap_allowed=False):
    """bodies: (id of the shape, position in metres)."""
    text = {
        "format": "porepack-packing",
        "version": 1,
        "overlap_allowed": overlap_allowed,
        "container": container,
        "shapes": shapes,
        "bodies": [{"shape": shape, "position_m": list(at), "orientation": [1, 0, 0, 0]} for shape, at in bodies],
    }
    pathlib.Path(path).write_text(json.dumps(text))


def periodic_box(edge):
    return {"kind": "box", "size_m": [edge] * 3, "periodic": [True] * 3}


def sphere(diameter):
    return {"id": "sphere", "capsules": [{"a_m": [0, 0, 0], "b_m": [0, 0, 0], "radius_m": diameter / 2}]}


# Factor on the standard error for 95 of 100, by the number of values less one (Student).
T95 = {1: 12.71, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 6: 2.447, 7: 2.365, 8: 2.306, 9: 2.262}


def mean_of(values):
    """Mean and half width of what holds the mean of all such beds in 95 of 100."""
    mean = sum(values) / len(values)
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1))
    return mean, T95[len(values) - 1] * deviation / math.sqrt(len(values))


class Rows:
    """A table of rows, written after each one. With `only`, other rows stay as they are in the stored table."""

    def __init__(self, path, stored, only=None, control=False):
        self.path, self.only, self.control, self.rows = pathlib.Path(path), only, control, []
        if only and stored.exists():
            with open(stored, newline="") as file:
                self.rows = list(csv.reader(file))[1:]
            self.write()
        self.added = 0

    def wanted(self, item):
        """Ask before a long computation; add() does not store what is not wanted."""
        return not self.only or self.only in item

    def add(self, item, value, half_width, command, change=None, version=None, date=None):
        """`version` and `date` of rows that are not computed now, but stored."""
        if not self.wanted(item):
            return
        self.added += 1
        row = [change] * self.control + [item, f"{value:.6g}", f"{value - half_width:.6g}", f"{value + half_width:.6g}", command]
        row += [date or datetime.date.today().isoformat(), version or VERSION]
        same = [k for k, stored in enumerate(self.rows) if stored[: 1 + self.control] == row[: 1 + self.control]]
        if same:
            self.rows[same[0]] = row
        else:
            self.rows.append(row)
        self.write()
        print(row, flush=True)

    def write(self):
        columns = ["change"] * self.control + ["item", "value", "low", "high", "command", "date", "version"]
        whole = self.path.with_suffix(".part")
        with open(whole, "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([columns, *self.rows])
        whole.replace(self.path)


VERSION = subprocess.run([POREPACK, "--version"], capture_output=True, text=True).stdout.split("\n")[0].removeprefix("porepack ")


def subject(folder, compute):
    """Calls compute(ours, control, scratch folder)."""
    folder = pathlib.Path(folder)
    parser = argparse.ArgumentParser(description=f"Computes ours.csv and control.csv of {folder.name}.")
    parser.add_argument("--output", default=folder, help="folder for both tables; default: that of the subject")
    parser.add_argument("--only", metavar="TEXT", help="only the quantities whose names contain it; the others keep their stored rows")
    arguments = parser.parse_args()
    output = pathlib.Path(arguments.output)
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        ours = Rows(output / "ours.csv", folder / "ours.csv", arguments.only)
        control = Rows(output / "control.csv", folder / "control.csv", arguments.only, control=True)
        compute(ours, control, pathlib.Path(scratch))
    if ours.added + control.added == 0:
        raise SystemExit(f"no quantity of {folder.name} contains `{arguments.only}`; its names: published.csv")
