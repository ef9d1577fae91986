#!/usr/bin/python3
"""Copies the tracked pages, and the files that they link to, into a folder laid out as the repository, so that every
link that works there works on the site; writes the site's configuration beside it.

Example: docs/site/stage.py build/docs
"""
import pathlib
import re
import shutil
import subprocess
import sys

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
KATEX = pathlib.Path("/usr/share/javascript/katex")
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)]*)?\)")


def tracked_pages():
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, text=True, capture_output=True, check=True).stdout
    return [pathlib.Path(name) for name in listed.splitlines()]


def linked_files(page):
    """Files of the repository that a page links to, and that are no pages themselves."""
    for target in LINK.findall((ROOT / page).read_text()):
        path = (ROOT / page.parent / target).resolve()
        if ":" not in target and path.is_file() and path.suffix != ".md" and path.is_relative_to(ROOT):
            yield path.relative_to(ROOT)


def copy(name, pages):
    (pages / name).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(ROOT / name, pages / name)


def fill(entries, lists):
    """Puts lists of pages where the navigation leaves room for them."""
    for entry in entries:
        if isinstance(entry, dict):
            for title, below in entry.items():
                if title in lists:
                    entry[title] = [str(page) for page in lists[title]]
                elif isinstance(below, list):
                    fill(below, lists)


def main(base):
    pages = base / "pages"
    shutil.rmtree(pages, ignore_errors=True)
    names = tracked_pages()
    for name in names:
        copy(name, pages)
        for other in linked_files(name):
            copy(other, pages)
    for name in ("math.js", "site.css"):
        shutil.copy(ROOT / "docs/site" / name, pages / name)
    (pages / "katex").mkdir()
    for name in ("katex.min.js", "katex.min.css"):
        shutil.copy(KATEX / name, pages / "katex" / name)
    shutil.copytree(KATEX / "fonts", pages / "katex/fonts")
    config = yaml.safe_load((ROOT / "docs/site/mkdocs.yml").read_text())
    config.update(docs_dir=str(pages), site_dir=str(base / "site"))
    fill(config["nav"], {
        "Packages": [n for n in names if n.parts[0] == "src"],
        "Results": sorted((n for n in names if n.parent == pathlib.Path("docs/results")), key=lambda n: n.name == "README.md",
                          reverse=True),
        "Decisions": sorted((n for n in names if n.parent == pathlib.Path("docs/adr")), key=lambda n: (n.name != "README.md", n)),
    })
    (base / "mkdocs.yml").write_text(yaml.safe_dump(config, sort_keys=False))


if len(sys.argv) != 2:
    sys.exit(__doc__)
main(pathlib.Path(sys.argv[1]).resolve())
