#!/usr/bin/env python3
"""The page of `report` is well-formed, shows every value, and keeps names with characters that HTML or terminals would
take for something else.

usage: report_page.py PROGRAM
exit:  0 all right, 1 something is wrong
"""

import json
import os
import subprocess
import sys
import tempfile
import xml.etree.ElementTree
from html.parser import HTMLParser

NAME = "a<b&\"c\"'d'>\u00e4 {x}\n\x1b[m"  # of the folder of the meshes
TITLE = "<script>alert(1)</script> & \"more\""
VOID = {"meta", "img"}  # elements of HTML that have no end

failures = 0


def check(what, good, told=""):
    global failures
    print("%-70s %s" % (what, "right" if good else "WRONG"))
    if not good:
        failures += 1
        print(told)


class Balance(HTMLParser):
    """Reads a page as HTML. Keeps its text, the targets of links, and elements that end in the wrong order."""

    def __init__(self):
        super().__init__()
        self.open, self.wrong, self.text, self.ids, self.links = [], [], [], set(), set()

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.ids |= {attributes["id"]} if "id" in attributes else set()
        self.links |= {attributes["href"]} if "href" in attributes else set()
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data):
        self.text.append(data)


def printable(text):
    return text.replace("\n", "\\n").replace("\x1b", "\\x1b")


def main():
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        def run(*words):
            done = subprocess.run([program, *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True)
            if done.returncode != 0:
                sys.exit(done.stdout)

        meshes = NAME + "/m.####.ply"
        run("sample", "dambreak", "in/a.####.ply", "--particles", "500", "--frames", "1-3", "-q")
        run("mesh", "in/a.####.ply", meshes, "--preset", "splash", "--radius", "0.2", "--spacing", "0.1")
        run("render", meshes, NAME + "/look.####.png", "--width", "64", "--height", "48")
        run("report", meshes + ".json", "-o", "page.html", "--title", TITLE, "--previews", NAME + "/look.####.png")
        with open(os.path.join(folder, "page.html"), encoding="utf-8") as file:
            page = file.read()
        manifests = []
        for frame in (1, 2, 3):
            with open(os.path.join(folder, NAME, "m.%04d.ply.json" % frame), encoding="utf-8") as file:
                manifests.append(json.load(file))

    root = xml.etree.ElementTree.fromstring(page)  # throws if it is not well-formed
    balance = Balance()
    balance.feed(page)
    check("every element of the page ends where it should", not balance.open and not balance.wrong, balance.wrong)
    title = root.findtext("body/h1")
    check("the title is text", title == TITLE and root.find(".//script") is None, title)
    check("names are text", printable(meshes) in "".join(balance.text), balance.text[:60])
    check("there is no control character", not any(ord(c) < 32 and c != "\n" for c in page))
    check("every link has a target", {"#" + name for name in balance.ids} >= balance.links and len(balance.links) == 4,
          balance.links)
    check("every frame has a picture", len(root.findall(".//img")) == 3)

    terms = dict(zip((dt.text for dt in root.iter("dt")), (dd.text for dd in root.iter("dd"))))
    expected = {"Input": "in/a.####.ply", "Output": printable(meshes), "Frames": "1-3", "Preset": "splash",
                "Radius": "0.2 world units (2 spacings)", "Spacing": "0.1 world units",
                "Skin": "%.6g world units (%.3g spacings)" % (manifests[0]["skin"], manifests[0]["skin"] / 0.1),
                "Dimension": "3", "Program": "betamesh " + manifests[0]["origin"]["version"]}
    check("the head lists the settings", terms == expected, terms)

    head = [th.text for th in root.iter("th")]
    for row, manifest in zip(root.findall(".//tbody/tr"), manifests):
        cells = dict(zip(head, (td.text or "" for td in row)))
        named = {name: manifest[name] for name in ("frame", "status", "particles", "vertices", "triangles",
                                                   "components", "volume", "area")}
        named.update(seconds=manifest["seconds"]["total"], MiB=manifest["peak_bytes"] >> 20,
                     retries=manifest["perturbation_retries"], notes="; ".join(manifest["warnings"]))
        texts = {name: "%.6g" % value if isinstance(value, float) else str(value) for name, value in named.items()}
        check("the row of frame %d has its values" % manifest["frame"], cells == texts, (cells, texts))
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
