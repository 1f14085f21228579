#!/usr/bin/env python3
"""Names that somebody chose to do harm, in every place of a model where a free name or text is allowed, through every command.

usage: hostile.py COMMAND [--rounds N] [--seed S] [--all] [--keep]

Each round writes a model with names put together from fragments that mean something to a shell, gnuplot, Graphviz, XML, JSON,
LaTeX, a spreadsheet or a terminal, and runs some of the commands on it, or with --all every one. Whatever the names: no file
PWNED appears, nothing is written but what was asked for, a terminal gets neither a control character nor a line that a name
forged, messages stay short, JSON parses, SVG and MathML are well-formed, names come back from data as they were, and the exit
code is one of 0 to 3. 500 rounds of all: hostile.py build/dev/bgsim --rounds 500 --all (some ten minutes)."""
import argparse
import csv
import html.parser
import io
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import unicodedata
import xml.etree.ElementTree

FRAGMENTS = [
    "'", '"', "`", "\\", "\n", "\r", "\r\n", "\t", "\0", "\x1b[31m", "\x1b]0;owned\x07", "\x9b31m", "\x85", "\x7f", "\x08", "\u202e", "\u2066",
    "\u2069", "\u200b", "\ufeff", "\u2028", "\ufffe", "\U000e0041", "</script>", "<script>alert(1)</script>", "<img src=x onerror=alert(1)>",
    "<!--", "-->", "]]>", "<![CDATA[", "&lt;", "&#10;", "&", "<", ">", "=cmd|' /C calc'!A0", "+1", "-1", "@SUM(1)", "$(touch PWNED)",
    "`touch PWNED`", "'; system('touch PWNED'); #", "\"; system(\"touch PWNED\"); #", "\nsystem('touch PWNED')\n", "\n!touch PWNED\n",
    "|touch PWNED", "; touch PWNED;", "${IFS}", "%n%s", "%", "%%", "\\input{/etc/passwd}", "^^5cinput", "$x$", "_", "~", "#", "{", "}", "@x", "\\N",
    "\\l", "../../PWNED", "/tmp/PWNED", "..", ".", "/", "-o", "--help", " ", "  ", ",", ";", ":", "|", "e\u0301", "\u0301" * 20, "\u6f22\u5b57", "\U0001f527",
    "Watt's governor", "EOD", "NaN", "t", "\nFORGED error", "\r\nFORGED", "*", "?", "!", "(", ")", "a" * 300, "null",
]
BIDI = set("\u061c\u180e\u200b\u200e\u200f\u2028\u2029\u202a\u202b\u202c\u202d\u202e\u2060\u2066\u2067\u2068\u2069\ufeff\u00ad")
LONGEST_MESSAGE = 60_000
csv.field_size_limit(10_000_000)


class Failed(Exception):
    pass


class Names:
    def __init__(self, chance):
        self.random = chance

    def hostile(self, harmless):
        """A name: mostly fragments, sometimes harmless, so that the rest of the model is reached; now and then a long one."""
        if self.random.random() < 0.25:
            return harmless
        text = "".join(self.random.choice(FRAGMENTS + [harmless]) for _ in range(self.random.randint(1, 4)))
        if self.random.random() < 0.004:
            text += self.random.choice(["a", "\u6f22", "\x1b", "\u0301", "\\", "'"]) * 1_000_000
        if self.random.random() < 0.002:
            text += "\ud800"
        return text or harmless

    def file(self, harmless):
        """A name that a file can have."""
        name = self.hostile(harmless).encode("utf-8", "surrogatepass").replace(b"/", b"_").replace(b"\0", b"_")[:200]
        if self.random.random() < 0.1:
            name += b"\xff\x9b"
        return name if name.strip(b".") else harmless.encode()


def model(names, table, column, reference, submodel):
    some = names.hostile
    quote = '"' if "'" in column + table else "'"
    curve = f"table({quote}{table}{quote}, {quote}{column}{quote}, min(abs(t), 1))"
    scenes = {}
    for harmless in ("first", "second"):
        scenes[some(harmless)] = {"stop": 1, "samples": 5, "about": some("a scene")}
    last = list(scenes)[-1]
    if names.random.random() < 0.7:
        scenes[last]["reference"] = {"file": reference, "relative": 1e9, "columns": {}}
    out = some("u")
    if out == "t":
        out = "u"
    scenes[last].get("reference", {}).get("columns", {})[out] = some("u")
    text = {
        "bgsim": 1, "name": some("rc"), "about": some("A circuit."), "source": some("a book"),
        "parameters": {"R": {"value": 2, "unit": some("ohm"), "about": some("resistance"), "source": some("a book")}},
        "signals": {"s": {"value": "1 + t", "unit": some("V"), "about": some("a signal")}},
        "elements": {"battery": {"kind": "Se", "effort": "s", "about": some("5 V")}, "loop": {"kind": "1"},
                     "resistor": {"kind": "R", "resistance": "R", "about": some("a resistor")},
                     "store": {"kind": "C", "capacitance": 1}},
        "bonds": [{"from": "battery", "to": "loop", "about": some("a bond")}, {"from": "loop", "to": "resistor"},
                  {"from": "loop", "to": "store"}],
        "outputs": {out: {"value": "store.e", "unit": some("V"), "about": some("voltage")}, "i": "loop.f"},
        "scenes": scenes,
    }
    if names.random.random() < 0.5:
        text["signals"]["s"]["value"] = curve
    if names.random.random() < 0.2:
        text["types"] = {"part": submodel}
        text["elements"]["more"] = {"kind": "part"}
        text["bonds"].append({"from": "loop", "to": "more.end"})
    if names.random.random() < 0.15:  # a fault whose message has the name in it
        fault = names.random.choice(["key", "kind", "name", "expression", "unit", "scene", "state", "port"])
        wild = some("x")
        if fault == "key":
            text[wild] = 1
        elif fault == "kind":
            text["elements"]["store"]["kind"] = wild
        elif fault == "name":
            text["elements"][wild] = {"kind": "1"}
        elif fault == "expression":
            text["parameters"]["R"]["value"] = wild
        elif fault == "unit":
            text["outputs"][out]["value"] = "store.e + R"
        elif fault == "scene":
            text["scenes"][last]["method"] = wild
        elif fault == "state":
            text["scenes"][last]["initial"] = {wild: 1}
        else:
            text["bonds"][0]["from"] = wild
    return text


SUBMODEL = {"bgsim": 1, "name": "part", "ports": {"end": "end"}, "elements": {"end": {"kind": "1"}, "r": {"kind": "R", "resistance": 1}},
            "bonds": [{"from": "end", "to": "r"}]}


class Tags(html.parser.HTMLParser):
    """Which elements and attributes a page has, and the text of its data."""
    def __init__(self):
        super().__init__()
        self.found, self.scripts, self.data = set(), 0, None
        self.inside = False

    def handle_starttag(self, tag, attributes):
        self.found.add(tag)
        self.found.update(name for name, _ in attributes if name.startswith("on"))
        if tag == "script":
            self.scripts += 1
            self.inside = ("id", "data") in attributes

    def handle_data(self, data):
        if self.inside:
            self.data = (self.data or "") + data

    def handle_endtag(self, tag):
        self.inside = False


def check_text(what, raw, lines=True):
    """What a terminal gets."""
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        raise Failed(f"{what} is not UTF-8: {error}")
    for c in text:
        if (unicodedata.category(c) in ("Cc", "Cs", "Cn") and c not in "\n\t") or c in BIDI:
            raise Failed(f"{what} has U+{ord(c):04X}")
    if lines and re.search(r"(?m)^\s*FORGED", text):
        raise Failed(f"{what} has a line that a name forged")


def check_xml(what, text):
    try:
        xml.etree.ElementTree.fromstring(text)
    except xml.etree.ElementTree.ParseError as error:
        raise Failed(f"{what} is not well-formed: {error}")


ENTITIES = re.compile(r"&nbsp;")


def check_page(what, raw):
    page = raw.decode("utf-8")
    tags = Tags()
    tags.feed(page)
    if "img" in tags.found or any(name.startswith("on") for name in tags.found):
        raise Failed(f"{what} has an element or handler that a name brought: {sorted(tags.found)}")
    for kind in ("svg", "math"):
        for part in re.findall(rf"<{kind}\b.*?</{kind}>", page, re.S):
            check_xml(f"{kind} in {what}", ENTITIES.sub(" ", part))
    if tags.data is not None:
        json.loads(tags.data)
        if tags.scripts != 4:
            raise Failed(f"{what} has {tags.scripts} scripts")
    elif tags.scripts:
        raise Failed(f"{what} has a script")


def check_latex(what, text):
    for line in text.split("\n"):
        if not line.startswith("%") and ("\\input" in line or "^^" in line):
            raise Failed(f"{what} has a command that a name brought")
        if not re.match(r"% |\\begin\{align\*\}$|\\end\{align\*\}$|  |$", line):
            raise Failed(f"{what} has the line {line[:80]!r}")


def check_file(path, name):
    text = os.fsdecode(name)
    raw = open(path, "rb").read()
    if text.endswith(".json"):
        json.loads(raw.decode("utf-8"))
    elif text.endswith(".svg"):
        check_xml(text, raw)
    elif text.endswith(".html"):
        check_page(text, raw)
    elif text.endswith(".csv"):
        list(csv.reader(io.StringIO(raw.decode("utf-8", "surrogateescape"), newline=""), strict=True))


class Round:
    def __init__(self, command, seed, keep):
        self.command, self.keep = command, keep
        self.random = random.Random(seed)
        self.names = Names(self.random)
        self.folder = tempfile.mkdtemp(prefix="bgsim hostile ")
        self.outer, self.work = self.folder, os.path.join(self.folder, "a", "b", "work")
        os.makedirs(self.work)
        self.log = []

    def write(self, name, data):
        with open(os.path.join(os.fsencode(self.work), name), "wb") as file:
            file.write(data)

    def listing(self):
        files = set()
        for folder, folders, names in os.walk(os.fsencode(self.outer)):
            files.update(os.path.join(folder, name) for name in names + folders)
        return files

    def run(self, *arguments, data=None, codes=(0, 1, 2, 3), limit=LONGEST_MESSAGE):
        arguments = [a if isinstance(a, bytes) else a.encode("utf-8", "surrogatepass") for a in arguments]
        if any(b"\0" in a or len(a) > 120_000 for a in arguments):
            return None  # no system hands this over
        self.log.append(arguments)
        before = self.listing()
        done = subprocess.run([os.fsencode(self.command), *arguments], cwd=self.work, stdin=subprocess.DEVNULL, capture_output=True,
                              timeout=120, env={**os.environ, "HOME": self.folder})
        if done.returncode not in codes:
            raise Failed(f"exit code {done.returncode}: {done.stderr[-600:]!r}")
        check_text("standard error", done.stderr)
        if len(done.stderr) > limit:
            raise Failed(f"standard error has {len(done.stderr)} bytes")
        if data is None:
            check_text("standard output", done.stdout)
            if len(done.stdout) > limit:
                raise Failed(f"standard output has {len(done.stdout)} bytes")
        elif done.stdout:
            data(done.stdout)
        for path in self.listing() - before:
            folder, name = os.path.split(path)
            if folder != os.fsencode(self.work):
                raise Failed(f"written outside: {path!r}")
            check_text("a file's name", name)
            if name.startswith((b"-", b".")) or b"\n" in name or b"\t" in name:
                raise Failed(f"a file is named {name!r}")
            check_file(path, name)
        return done

    def prepare(self):
        self.column = self.names.hostile("u")
        table, self.reference, submodel = self.names.file("data.csv"), self.names.file("reference.csv"), self.names.file("part.json")
        header = '"' + self.column.replace('"', '""') + '"'
        data = b"t," + header.encode("utf-8", "replace") + (b",\xff\xfe" if self.random.random() < 0.2 else b",v") + b"\n0,1,2\n0.5,1,2\n1,2,3\n"
        self.write(table, data)
        self.write(self.reference, data)
        self.write(submodel, json.dumps(SUBMODEL).encode())
        decoded = [os.fsdecode(name).encode("utf-8", "replace").decode() for name in (table, self.reference, submodel)]
        self.text = model(self.names, decoded[0], self.column, decoded[1], decoded[2])
        self.file = b"./" + self.names.file("m") + b".json"
        self.write(self.file, json.dumps(self.text, ensure_ascii=self.random.random() < 0.5).encode("utf-8", "surrogatepass"))
        self.plotted = b"./" + self.names.file("p") + b".csv"
        self.write(self.plotted, data)

    # The commands, each with what it takes and what must hold of its result.

    def c_run(self):
        done = self.run(self.file, "--units", "--report-json", "report.json")
        if done is None or done.returncode != 0:
            return
        report = json.load(open(os.path.join(self.work, "report.json")))
        if report["model"] != self.text["name"] or report["scene"] != list(self.text["scenes"])[0]:
            raise Failed("the report's JSON has another name than the model")

    def c_run_output(self):
        def header(raw):
            head = next(csv.reader(io.StringIO(raw.decode("utf-8"), newline="")))
            if head != ["t", *self.text["outputs"]]:
                raise Failed("the names of columns do not come back from CSV")
        self.run(self.file, "-o", "-", data=header)

    def c_all_scenes(self):
        self.run(self.file, "--all-scenes", "--quiet")

    def c_arguments(self):
        wild = self.names.hostile("x")
        self.run(*self.random.choice([[self.file, "--set", wild], [self.file, "--set", "R=" + wild], [self.file, "--scene", wild], [self.file, "--method", wild],
                                      ["--" + wild, self.file], [self.file, wild], ["check", wild], ["explain", wild], ["new", wild], ["show", self.file, "--stage", wild],
                                      ["verify", wild], ["plot", wild], ["plot", self.plotted, wild], ["reduce", self.file, "--keep", wild],
                                      ["completion", wild], ["completion", "scenes", wild], ["run", self.file, "--accuracy", wild], ["draw", self.file, "--zoom", wild]]))

    def c_check(self):
        self.run("check", self.file)

    def c_equations(self):
        self.run("equations", self.file)

    def c_latex(self):
        def latex(raw):
            check_text("LaTeX", raw)
            check_latex("LaTeX", raw.decode())
        self.run("equations", "--latex", self.file, data=latex)

    def c_show(self):
        for stage in ("model", "graph", "units", "causality", "equations", "order", "program"):
            self.run("show", "--stage", stage, self.file, limit=50_000_000)

    def c_draw(self):
        self.run("draw", self.file)
        self.run("draw", self.file, "--effort-flow", "-o", "-", data=lambda raw: check_xml("SVG", raw))

    def c_draw_png(self):
        self.run("draw", self.file, "-o", "x.png")

    def c_draw_dot(self):
        done = self.run("draw", self.file, "-o", "x.dot")
        if done.returncode == 0 and shutil.which("dot"):
            again = subprocess.run(["dot", "-Tsvg", "x.dot"], cwd=self.work, capture_output=True, timeout=60)
            if again.returncode != 0:
                raise Failed(f"dot refuses the drawing: {again.stderr[-300:]!r}")
            check_xml("dot's SVG", again.stdout)

    def c_plot(self):
        self.run("plot", self.plotted, "--title", self.names.hostile("a title"))

    def c_plot_against(self):
        self.run("plot", self.plotted, "--against", b"./" + self.reference, "-o", "-", data=lambda raw: check_xml("SVG", raw))

    def c_reduce(self):
        self.run("reduce", self.file, "--error", "0.5", "--json", "reduce.json", "--csv", "reduce.csv")

    def c_report(self):
        self.run("report", self.file, "--all")

    def c_trade(self):
        self.run("trade", self.file, "--budget", "0.02", "--no-picture")

    def c_trade_picture(self):
        self.run("trade", self.file, "--budget", "0.02", "--accuracy", "0.1")

    def c_verify(self):
        self.run("verify", self.file)

    def c_completion(self):
        """As bash does it at a Tab."""
        script = ('PATH="$1:$PATH"; source <(bgsim completion bash); COMP_WORDS=(bgsim "$2" --scene ""); COMP_CWORD=3; _bgsim; '
                  'COMP_WORDS=(bgsim plot ""); COMP_CWORD=2; _bgsim; printf "%s\\n" "${COMPREPLY[@]}" >/dev/null')
        self.log.append([b"completion", self.file])
        done = subprocess.run([b"bash", b"-c", script.encode(), b"bash", os.fsencode(self.bin()), self.file], cwd=self.work, capture_output=True, timeout=60)
        if done.returncode != 0 or done.stderr:
            raise Failed(f"bash's completion: {done.stderr[-300:]!r}")
        self.run("completion", "scenes", self.file, data=lambda raw: check_text("scenes", raw), limit=5_000_000)

    def bin(self):
        folder = os.path.join(self.folder, "bin")
        if not os.path.isdir(folder):
            os.mkdir(folder)
            os.symlink(self.command, os.path.join(folder, "bgsim"))
        return folder

    QUICK = ["run", "run_output", "all_scenes", "arguments", "arguments", "check", "equations", "latex", "show", "verify", "completion"]
    SLOW = ["draw", "draw_png", "draw_dot", "plot", "plot_against", "reduce", "report", "trade", "trade_picture"]

    def go(self, everything):
        self.prepare()
        if everything:
            chosen = self.QUICK + self.SLOW
        else:
            chosen = self.random.sample(self.QUICK, 2) + ([self.random.choice(self.SLOW)] if self.random.random() < 0.3 else [])
        for name in chosen:
            getattr(self, "c_" + name)()
            for path in self.listing():
                if b"PWNED" in os.path.basename(path) and os.path.getsize(path) == 0:
                    raise Failed(f"a command of a name was run: {path!r}")
        for place in (self.work, self.outer, "/tmp", os.getcwd()):
            if os.path.exists(os.path.join(place, "PWNED")):
                raise Failed(f"a command of a name was run, in {place}")

    def end(self, failed):
        if not (failed and self.keep):
            shutil.rmtree(self.folder, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--all", action="store_true", help="every command in every round")
    parser.add_argument("--keep", action="store_true", help="keep the folders of rounds that failed")
    given = parser.parse_args()
    failures = 0
    for seed in range(given.seed, given.seed + given.rounds):
        one = Round(os.path.abspath(given.command), seed, given.keep)
        fault = None
        try:
            one.go(given.all)
        except (Failed, ValueError, csv.Error, subprocess.TimeoutExpired) as error:
            fault = error
        if fault is not None:
            failures += 1
            last = " ".join(ascii(part)[:100] for part in one.log[-1]) if one.log else ""
            print(f"seed {seed}: {str(fault)[:500]}\n  at: {last}" + (f"\n  in: {one.folder}" if given.keep else ""))
        one.end(fault is not None)
    print(f"{given.rounds} rounds, {failures} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
