"""Closed surfaces and level curves."""

import json
import struct
import subprocess
import tempfile
from pathlib import Path

from corpus import Case
from images import flipped, write

# STL ------------------------------------------------------------------------------------------------------------------------------------
FACES = ((0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7))


def block(low=(2, 2, 2), high=(6, 5, 7)):
    (a, b, c), (d, e, f) = low, high
    corners = ((a, b, c), (d, b, c), (d, e, c), (a, e, c), (a, b, f), (d, b, f), (d, e, f), (a, e, f))
    return [[corners[i] for i in face] for face in FACES]


def ascii_stl(triangles, name="part", number=repr, end="endsolid", loop="endloop", facet="endfacet", line="\n", normal="0 0 0"):
    text = f"solid {name}\n"
    for triangle in triangles:
        text += f"  facet normal {normal}\n    outer loop\n"
        text += "".join("      vertex " + " ".join(number(float(x)) for x in corner) + "\n" for corner in triangle)
        text += f"    {loop}\n  {facet}\n"
    text += f"{end} {name}\n" if end else ""
    return text.replace("\n", line).encode()


def binary_stl(triangles, header=b"made by a test", count=None):
    data = header.ljust(80, b"\0")[:80] + struct.pack("<I", len(triangles) if count is None else count)
    for triangle in triangles:
        data += struct.pack("<12fH", 0, 0, 0, *[x for corner in triangle for x in corner], 0)
    return data


VOLUME = 60e-9
STL = ["stl", "in.stl", "--container", "box:0.01,0.01,0.01", "--unit", "0.001", "--output", "o"]


def volume_is(wanted):
    def fault(folder, _output):
        found = json.loads((folder / "o" / "stl.result.json").read_text())["volume_m3"]
        return "" if abs(found / wanted - 1) < 1e-5 else f"volume {found}, not {wanted}"

    return fault


def stl(random):
    def one(name, data, wanted=VOLUME, strict=False):
        return Case(name, write("in.stl", data), STL, volume_is(wanted) if wanted else None, writes=("o",), may_refuse=not strict)

    good = block()
    for name in (
        "part",
        "solid",
        "a solid b",
        "vertex 1 2 3",
        "facet normal",
        "endsolid",
        "endloop",
        "outer loop",
        "",
        "é ü",
        "x" * 300,
        "facet",
        "end solid",
    ):
        yield one(f"name_{name[:10]}", ascii_stl(good, name), strict=True)
    for n, options in enumerate(
        (
            {"end": "end solid"},
            {"loop": "end loop"},
            {"facet": "end facet"},
            {"line": "\r\n"},
            {"normal": "nan nan nan"},
            {"normal": "0 0 1e-400"},
            {"number": lambda x: f"{x:e}"},
            {"number": lambda x: f"{x:+.3f}"},
            {"number": lambda x: f"{x:E}"},
            {"line": " \n"},
            {"line": "\n\n"},
            {"normal": "- - -"},
            {"number": lambda x: f"{x:.0f}."},
        )
    ):
        yield one(f"style_{n}", ascii_stl(good, **options), strict=n != 11)
    yield one("upper", ascii_stl(good).upper(), strict=True)
    yield one("one_line", ascii_stl(good).replace(b"\n    outer", b" outer").replace(b"\n      vertex", b" vertex"), strict=True)
    for tiny in ("1e-46", "3e-46", "-1e-46", "1e-170", "4.9e-324", "1e-400", "-0.0", "0e5", "1e-38", "-3.2e-200"):
        low = ascii_stl(block((0, 0, 0), (4, 3, 5)), number=lambda x: tiny if x == 0 else repr(x))
        yield one(f"tiny_{tiny}", low, strict=True)
    for bad in ("0,5", "1.0D+00", "nan", "inf", "1e39", "1e400", "x", "0x10", "1_0", "--1", "1e", "1.2.3", "½", "#"):
        for at in (0, 3, 30):
            words = ascii_stl(good).split(b" ")
            places = [i for i, word in enumerate(words) if word == b"vertex"]
            words[places[at] + 1] = bad.encode()
            yield one(f"number_{bad}_{at}", b" ".join(words), None)
    for n, cut in enumerate(
        (b"endsolid part\n", b"endfacet", b"endloop", b"outer loop", b"facet normal 0 0 0", b"      vertex 2.0 2.0 2.0\n")
    ):
        text = ascii_stl(good)
        at = text.rindex(cut)
        yield one(f"without_{n}", text[:at] + text[at + len(cut) :], None)
        yield one(f"twice_{n}", text[:at] + cut + b" " + text[at:], None)
    for n in range(20):
        text = ascii_stl(good)
        yield one(f"cut_{n}", text[: random.randrange(30, len(text) - 15)], None)
    one_binary = binary_stl(good)
    yield one("binary", one_binary, strict=True)
    for header in (b"solid", b"solid facet", b"solid x\nfacet normal", b"\xef\xbb\xbfsolid", b"\0" * 80):
        yield one(f"binary_{header[:12]}", binary_stl(good, header), strict=True)
    for count in (0, 1, 11, 13, 2**31, 2**32 - 1):
        yield one(f"count_{count}", binary_stl(good, count=count), None)
    for n in range(12):
        yield one(f"binary_cut_{n}", one_binary[: random.randrange(len(one_binary))], None)
    flat = [
        [(2, 2, 2)] * 3,
        [(2, 2, 2), (6, 2, 2), (2, 2, 2)],
        [(0, 0, 0)] * 3,
        [(9, 9, 9), (9, 9, 9), (1, 1, 1)],
        [(4, 4, 4), (4, 4, 4), (4, 4, 4)],
    ]
    for n, extra in enumerate(flat):
        yield one(f"null_{n}", binary_stl(good + [extra]), strict=True)
        yield one(f"null_ascii_{n}", ascii_stl([extra] + good), strict=True)
        yield one(f"only_null_{n}", binary_stl([extra]), None)
    for n in range(12):
        yield one(f"gone_{n}", binary_stl(good[:n] + good[n + 1 :]), None)
        yield one(f"doubled_{n}", binary_stl(good + [good[n]]), None)
        yield one(f"turned_{n}", binary_stl(good[:n] + [good[n][::-1]] + good[n + 1 :]), None)
        yield one(f"moved_{n}", binary_stl(good[:n] + [[good[n][0], good[n][1], (5, 5, 5)]] + good[n + 1 :]), None)
    yield one("inside_out", binary_stl([t[::-1] for t in good]), None)
    for name, other in (
        ("shell_twice", good),
        ("overlap", block((4, 4, 4), (8, 8, 8))),
        ("inside", block((3, 3, 3), (4, 4, 4))),
        ("corner", block((6, 5, 7), (8, 8, 8))),
        ("edge", block((6, 5, 2), (8, 8, 7))),
        ("face", block((6, 2, 2), (8, 5, 7))),
        ("part_of_face", block((6, 3, 3), (8, 4, 4))),
    ):
        yield one(name, binary_stl(good + other), None)
    yield one("hole", binary_stl(good + [t[::-1] for t in block((3, 3, 3), (4, 4, 4))]), VOLUME - 1e-9, strict=True)
    yield one("two", binary_stl(good + block((7, 7, 7), (9, 9, 9))), VOLUME + 8e-9, strict=True)
    for n in range(40):
        data = flipped(one_binary, random, 200)
        yield Case(f"flip_{n}", write("in.stl", data), STL, "any", writes=("o",))


# Level curves ---------------------------------------------------------------------------------------------------------------------------
def curve(program):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [
                program,
                "falling-head",
                "simulate",
                "--permeability",
                "6.3e-7",
                "--inertial-permeability",
                "4.4e-3",
                "--frames-per-s",
                "30",
                "--output",
                folder,
            ],
            check=True,
            capture_output=True,
        )
        rows = [line.split(",")[:2] for line in (Path(folder) / "falling_head.csv").read_text().splitlines() if line[0].isdigit()]
    return [(float(t), float(h)) for t, h in rows]


def csv(program):
    rows = curve(program)

    def cases(random):
        def one(name, text, readable=False, strict=False):
            def near(folder, _output):
                found = json.loads((folder / "o" / "falling-head-analysis.result.json").read_text())
                k = found["curves"][0]["least_squares"]["permeability_m2"]
                return "" if k and abs(k / 6.3e-7 - 1) < 0.02 else f"k is {k}"

            data = text if isinstance(text, bytes) else text.encode()
            return Case(
                name,
                write("in.csv", data),
                ["falling-head", "analyse", "in.csv", "--output", "o"],
                near if readable else None,
                writes=("o",),
                may_refuse=not strict,
            )

        def text(header="time_s,level_m", time=lambda t: f"{t:.5f}", level=lambda h: f"{h:.7f}", separator=",", line="\n", rows=rows):
            return header.replace(",", separator) + line + "".join(time(t) + separator + level(h) + line for t, h in rows)

        plain = text()
        for name, data in {
            "plain": plain,
            "crlf": text(line="\r\n"),
            "cr": text(line="\r"),
            "mm": text("time_s,level_mm", level=lambda h: f"{1000 * h:.4f}"),
            "cm_ms": text("time_ms,level_cm", time=lambda t: f"{1000 * t:.3f}", level=lambda h: f"{100 * h:.5f}"),
            "semicolon": text(separator=";"),
            "tab": text(separator="\t"),
            "bom": "\ufeff" + plain,
            "comma": text(separator=";", time=lambda t: f"{t:.5f}".replace(".", ","), level=lambda h: f"{h:.7f}".replace(".", ",")),
            "quoted": text('"time_s","level_m"', time=lambda t: f'"{t:.5f}"'),
            "plus": text(time=lambda t: f"+{t:.5f}"),
            "exponent": text(level=lambda h: f"{h:.9e}"),
            "blank": text(separator=" , "),
            "remark": "# a remark\n" + plain,
            "upper": text("TIME_S,LEVEL_M"),
            "more": text("time_s,level_m,note", level=lambda h: f"{h:.7f},x"),
        }.items():
            yield one(name, data, True, strict=True)
        for word in (
            "0x10",
            "0X1p3",
            "nan",
            "inf",
            "-inf",
            "1_000",
            "1e999",
            "1,5",
            "1.2.3",
            "abc",
            "1 2",
            "--3",
            "1e",
            "١",
            "½",
            "12m",
            "=1+1",
            "'1",
            "1;2",
            "NULL",
        ):
            for column in (0, 1):
                for at in (1, len(rows) // 2):
                    lines = plain.splitlines()
                    cells = lines[at].split(",")
                    cells[column] = f'"{word}"' if "," in word else word
                    lines[at] = ",".join(cells)
                    yield one(f"cell_{word}_{column}_{at}", "\n".join(lines))
        for header in (
            "time_s,time_s,level_m",
            "time_s,level_m,level_m",
            "time_s,level_m,level_mm",
            "time_s,time_ms,level_m",
            "time_s,level_cm,level_mm",
            "time_min,level_m,time_s",
            "time_s,level_m,TIME_S",
            "level_m,level_m,time_s",
            "time_s,Level_MM,level_m",
        ):
            yield one(f"header_{header}", text(header, level=lambda h: f"{h:.7f},{h:.7f}"))
        for header in ("time,level", "t,h", "time_h,level_m", "time_s,level_in", "time_s", "level_m", "", "0,1.6", "time_s level_m"):
            yield one(f"unknown_{header}", text(header))
        yield one("unnamed_column", text("time_s,level_m,,x"), True)
        yield one("one_row", text(rows=rows[:1]))
        yield one("no_row", text(rows=[]))
        yield one("empty", "")
        yield one("zeros", b"\0" * 1000)
        yield one("utf16", plain.encode("utf-16"))
        yield one("backwards", text(rows=rows[::-1]))
        yield one("same_time", text(time=lambda t: "1"))
        yield one("rising", text(rows=[(t, 1.6 - h + 0.05) for t, h in rows]))
        yield one("packings", "# packing: a\n# packing: b\n" + plain)
        for n in range(30):
            yield Case(
                f"flip_{n}",
                write("in.csv", flipped(plain.encode(), random, 100)),
                ["falling-head", "analyse", "in.csv", "--output", "o"],
                "any",
                writes=("o",),
            )

    return cases


def kinds(program):
    return {"stl": stl, "csv": csv(program)}
