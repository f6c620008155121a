"""The site of the documents, made by scripts/build_docs: which page stands where. Sphinx with MyST; it works from files, without a network."""

import re
from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

ROOT = Path(__file__).resolve().parents[2]

project = "PorePack"
author = "the PorePack founders"
copyright = "the PorePack founders, GPL-3.0-or-later"
version = release = re.search(r"POREPACK_VERSION ([^)]+)", (ROOT / "CMakeLists.txt").read_text())[1]
html_title = f"PorePack {version}"

# Every page, in the order in which it is read; a test demands that none is missing.
PAGES = {
    "Start here": ["docs/start"],
    "Tutorials": [f"docs/tutorials/{name}" for name in ("own_grain", "own_stone", "own_mesh", "level_curve", "own_study", "cluster", "gpu", "python")],
    "How to": [
        f"docs/{name}"
        for name in (
            "install",
            "shapes",
            "packing",
            "images",
            "sections",
            "inertia",
            "pores",
            "design",
            "falling-head",
            "studies",
            "cluster",
            "gpu",
            "look",
        )
    ],
    "Explanation": [f"docs/{name}" for name in ("uncertainty", "lattice-boltzmann", "tortuosity", "causes", "theory")]
    + ["docs/decisions/README"]
    + sorted(str(page.relative_to(ROOT).with_suffix("")) for page in (ROOT / "docs/decisions").glob("[0-9]*.md")),
    "Reference": [f"docs/{name}" for name in ("commands", "case-keys", "files", "errors", "python", "python-reference", "library")]
    + ["CONTRIBUTING", "CHANGELOG"],
    "Evidence": ["evidence/README"]
    + sorted(str(page.relative_to(ROOT).with_suffix("")) for page in (ROOT / "evidence").glob("*/README.md"))
    + ["docs/verification", "docs/paper-study", "docs/compare"],
    "Cases": sorted(str(page.relative_to(ROOT).with_suffix("")) for page in (ROOT / "cases").glob("*/README.md")),
    "Measured": sorted(str(page.relative_to(ROOT).with_suffix("")) for page in (ROOT / "docs/notes").glob("*.md")),
}

root_doc = "docs/README"
extensions = ["myst_parser"]
include_patterns = [f"{page}.md" for pages in PAGES.values() for page in pages] + ["docs/README.md"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # pages may begin below the first level
highlight_language = "none"
html_theme = "furo"
html_math_renderer = "mathml"
html_css_files = ["equations.css"]
html_static_path = ["static"]
html_search_scorer = str(Path(__file__).with_name("scorer.js"))
html_show_sphinx = False
html_copy_source = False
html_last_updated_fmt = None


def link(match, folder):
    """A link to a folder leads to its page, and to a page that is not on the site nowhere; missing ones stay, for Sphinx to find."""
    text, target = match[1], match[2]
    if "://" in target or target.startswith("#"):
        return match[0]
    file = (folder / target.partition("#")[0]).resolve()
    if text == file.name and file.suffix == ".md" and file.is_file():  # where the repository names a file, the site names its title
        text = file.read_text().split("\n", 1)[0].lstrip("# ").partition(":")[0]
    if file.is_dir():
        page = f"{file.relative_to(ROOT)}/README.md"
        return f"[{text}]({target}/README.md)" if page in include_patterns else text
    return text if file.suffix == ".md" and file.exists() and str(file.relative_to(ROOT)) not in include_patterns else f"[{text}]({target})"


def equation(page, node):
    """MathML, which browsers show without a script, with the equation's number at the right."""
    tex, _, number = node.astext().partition(r"\tag{")
    number = number.rstrip("} \n")
    try:
        math = tex2mathml(tex, inline=False)
    except TypeError:  # docutils 0.21 and later
        math = tex2mathml(tex, as_block=True)
    math = math.replace("<math ", '<math display="block" ', 1)
    page.body.append(f'<div class="equation" id="{number}"><div>{math}</div><span>({number})</span></div>\n')
    raise nodes.SkipNode


def no_equation(page, node):
    raise ValueError(f"an equation within a line: {node.astext()}")


def change_source(_, name, source):
    """Links and equations of the repository become those of the site, and the first page gets the table of contents."""
    folder = (ROOT / name).parent
    source[0] = re.sub(r"^( *)```math$", r"\1```{math}", source[0], flags=re.M)
    source[0] = re.sub(r"(?<!!)\[([^\]]+)\]\(([^)\s]+)\)", lambda match: link(match, folder), source[0])
    if name == "docs/library":
        html = '<a href="../cpp/index.html">all headers, classes and functions</a>'
        source[0] = source[0].replace("all headers, classes and functions", html)
    if name != root_doc:
        return
    for caption, pages in PAGES.items():
        source[0] += f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n" + "".join(f"/{page}\n" for page in pages) + "```\n"


def setup(app):
    app.connect("source-read", change_source)
    app.add_html_math_renderer("mathml", (no_equation, None), (equation, None))
