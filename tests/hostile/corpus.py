"""Hostile inputs by the hundred: what porepack makes of files, numbers and names that it should not trust.

Usage: /usr/bin/python3 tests/hostile/corpus.py build/porepack [--kind NAME ...] [--share 0.1] [--keep FOLDER]

Each case runs porepack in a folder of its own and is judged by an independent reader (tifffile, pydicom, Pillow, NumPy, VTK), or by how the
input was made. The counts by kind come at the end; exit code 1 if anything crashed, hung, was silently wrong, ran or wrote what it should
not, or destroyed a file. Needs the packages of packages-test.apt.
"""

import argparse
import hashlib
import importlib
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

try:
    import numpy as np

    for module in ("PIL", "pydicom", "tifffile"):  # used by images.py and dicom.py
        importlib.import_module(module)
except ImportError as missing:
    required = os.environ.get("POREPACK_PACKAGES") == "required"
    print(f"{'failed' if required else 'skipped'}: {missing}; install the packages of packages-test.apt, and use Debian's /usr/bin/python3", file=sys.stderr)
    sys.exit(1 if required else 77)

SANITIZED = "--sanitized" in sys.argv
BAD = ("crash", "hang", "silent", "injected", "lost", "half-written", "unclear")


@dataclass
class Case:
    """One input. `make(folder)` writes files; `command` runs there; `wanted`: None = must be refused, an array = the values that
    out.npy must have, a function of (folder, output) = a text that says what is wrong, or "any" = refused or not, but no accident."""

    name: str
    make: object
    command: list
    wanted: object = "any"
    writes: tuple = ("out.npy",)  # names that may appear or change
    may_refuse: bool = True  # False: a refusal is counted as "strict"
    limits: dict = field(default_factory=dict)
    seconds: float = 60.0


def tree(folder):
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_symlink():
            found[name] = "link " + os.readlink(path)
        elif path.is_file():
            found[name] = hashlib.sha1(path.read_bytes()).hexdigest()
    return found


def run_case(case, program, keep):
    box = Path(tempfile.mkdtemp(prefix="hostile_"))
    work = box / "work"
    work.mkdir()
    (box / "outside.txt").write_text("mine")
    try:
        case.make(work)
        before = tree(box)

        def limit():
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if not SANITIZED:  # sanitizers reserve terabytes
                resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
            for which, value in case.limits.items():
                resource.setrlimit(which, (value, value))

        environment = dict(os.environ, OMP_NUM_THREADS="1", OMP_WAIT_POLICY="passive", HOME=str(box))
        try:
            done = subprocess.run(
                [program] + [str(word) for word in case.command],
                cwd=work,
                capture_output=True,
                timeout=case.seconds,
                env=environment,
                preexec_fn=limit,
            )
        except subprocess.TimeoutExpired:
            return "hang", ""
        except (ValueError, OSError):  # NUL in an argument: no program can be given it
            return "refused", ""
        error = done.stderr.decode(errors="replace")
        text = error + done.stdout.decode(errors="replace")
        after = tree(box)
        made = [n for n in after if n not in before]
        if any(Path(n).name in ("pwned", "pwned_by_corpus") for n in made):
            return "injected", str(made)
        allowed = [f"work/{n}" for n in case.writes]
        for name, digest in before.items():
            if after.get(name) != digest and not any(name == a or name.startswith(a + "/") for a in allowed):
                return "lost", name
        odd = [n for n in made if not any(n == a or n.startswith(a + "/") for a in allowed)]
        if odd:
            return "injected", "wrote " + str(odd[:3])
        if done.returncode not in (0, 2, 3, 4, 5):
            return "crash", f"exit {done.returncode} {error[-200:]}"
        if "runtime error: " in text or "AddressSanitizer" in text:
            return "crash", text[text.find("rror") - 8 :][:300]
        if "internal error" in text or "terminate called" in text or "Traceback" in text:
            return "crash", error[-300:]
        if done.returncode != 0:
            beside = {n.split("_1/")[0] for n in made if "_1/" in n and n.endswith("manifest.json")}  # whole, beside what is in the way
            if [n for n in made if n.endswith((".npy", "result.json", ".partial")) and n.split("_1/")[0] not in beside]:
                return "half-written", str(made)
            if "error:" not in error:
                return "unclear", error[-200:]
            return ("refused" if case.may_refuse else "strict"), error.strip().splitlines()[0]
        if case.wanted is None:
            return "silent", "accepted"
        if isinstance(case.wanted, str):
            return "accepted", ""
        if callable(case.wanted):
            fault = case.wanted(work, text)
            return ("silent", fault) if fault else ("right", "")
        values = np.load(work / "out.npy")
        wanted = np.asarray(case.wanted)
        if values.shape != wanted.shape:
            return "silent", f"shape {values.shape}, not {wanted.shape}"
        if not np.allclose(values.astype(float), wanted.astype(float), rtol=1e-6, atol=0):
            return "silent", "other values"
        return "right", ""
    finally:
        if keep:
            shutil.copytree(box, Path(keep) / case.name.replace("/", "_"), dirs_exist_ok=True)
        shutil.rmtree(box, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--kind", action="append", help="only kinds whose name contains this")
    parser.add_argument("--share", type=float, default=1.0, help="part of the cases of each kind, chosen at random")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", help="folder for the cases that fail")
    parser.add_argument("--verbose", action="store_true", help="one line for each case")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--sanitized", action="store_true", help="the program is built with sanitizers: no limit of the address space")
    options = parser.parse_args()
    program = str(Path(options.program).resolve())
    os.environ.setdefault("POREPACK_HOME", str(Path(__file__).resolve().parents[2]))

    import dicom
    import files
    import headers
    import images
    import numbers_and_names
    import surfaces_and_curves
    import volumes

    counts, bad, started, total = {}, [], time.time(), 0
    for module in (images, dicom, headers, volumes, surfaces_and_curves, files, numbers_and_names):
        for kind, make in module.kinds(program).items():
            if options.kind and not any(part in kind for part in options.kind):
                continue
            chance = random.Random(options.seed)
            cases = [case for case in make(random.Random(options.seed)) if chance.random() < options.share]
            with ThreadPoolExecutor(options.jobs) as pool:
                results = list(pool.map(lambda case: (case, *run_case(case, program, None)), cases))
            for case, verdict, detail in results:
                counts.setdefault(kind, Counter())[verdict] += 1
                total += 1
                if options.verbose or verdict in BAD:
                    print(f"  {kind}/{case.name}: {verdict} {detail}", flush=True)
                if verdict in BAD:
                    bad.append(case)
                    if options.keep:
                        run_case(case, program, options.keep)
            print(
                f"{kind:<12} {sum(counts.get(kind, Counter()).values()):>5}   "
                + ", ".join(f"{n} {v}" for v, n in sorted(counts.get(kind, Counter()).items())),
                flush=True,
            )
    print(f"{total} inputs in {time.time() - started:.0f} s, {len(bad)} bad")
    return 1 if bad or total == 0 else 0


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    sys.modules["corpus"] = sys.modules["__main__"]
    sys.dont_write_bytecode = True
    sys.exit(main())
