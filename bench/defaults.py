"""Error of each output at a scene's own settings (or at those given) over all scenes of the bench, against references.

usage: defaults.py BGSIM [--relative X] [FILE[:SCENE]]...     default: models/ and tests/data/models/

The reference is what two methods of different kinds make of the scene at a tolerance of 1e-11; where they differ, an
error below ten times their difference is not judged. Errors are relative to the output's range, or to its magnitude
where it is constant but for rounding. Prints Markdown: the worst output of each scene, what the run estimated that
error at, and whether it noted it.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile

PROJECT = pathlib.Path(__file__).resolve().parent.parent
TIGHT = "1e-11"
PAIRS = [("bdf", "dirk5"), ("bdf", "erk8"), ("dirk5", "erk8"), ("bdf", "adams")]
SECONDS = 120
# Notes that say how accurate a run is.
ACCURACY = ("energy balance", "estimated to be wrong", "could not be estimated", "varies within steps")
CONSTANT = 1e-9  # of the magnitude: a smaller range is what rounding and the tolerance leave


def run(bgsim, model, scene, options, folder):
    """Columns by output and notes of a run; None if it does not complete."""
    trace, report = folder / "trace.csv", folder / "report.json"
    for file in (trace, report):
        file.unlink(missing_ok=True)
    command = [bgsim, str(model), "--scene", scene, "-o", str(trace), "--report-json", str(report), "--quiet"]
    try:
        done = subprocess.run(command + options, capture_output=True, text=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return None
    if done.returncode != 0:
        return None
    with open(trace, newline="") as file:
        rows = list(csv.reader(file))
    names = [name.split(" ")[0] for name in rows[0][1:]]
    columns = {name: [float(row[i + 1]) for row in rows[1:]] for i, name in enumerate(names)}
    return columns, json.loads(report.read_text())


def distance(column, reference):
    """Largest distance relative to the reference's range."""
    magnitude = max(abs(value) for value in reference)
    extent = max(reference) - min(reference)
    if extent <= CONSTANT * magnitude:
        extent = magnitude
    largest = max(abs(a - b) for a, b in zip(column, reference))
    return largest / extent if extent > 0.0 else (0.0 if largest == 0.0 else float("inf"))


def reference_of(bgsim, model, scene, folder):
    """The columns of the first pair of methods that both complete, their distance by output, and their names."""
    tried = {}
    for pair in PAIRS:
        for method in pair:
            if method not in tried:
                options = ["--method", method, "--relative", TIGHT, "--no-audit"]
                tried[method] = run(bgsim, model, scene, options, folder)
        first, second = (tried[method] for method in pair)
        if first and second:
            own = {name: distance(second[0][name], column) for name, column in first[0].items()}
            return second[0], own, "/".join(pair)
    return None


def main(arguments):
    bgsim, options, files = arguments[0], [], []
    rest = iter(arguments[1:])
    for argument in rest:
        if argument.startswith("--"):
            options += [argument, next(rest)]
        else:
            files.append(argument)
    if not files:
        folders = (PROJECT / "models", PROJECT / "tests" / "data" / "models")
        files = [str(file) for folder in folders for file in sorted(folder.glob("*.json"))]
    counts = Counts()
    print("| scene | relative | worst output | error / range | estimate | reference's own | noted |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for file in files:
            path, _, chosen = file.partition(":")
            scenes = json.loads(pathlib.Path(path).read_text()).get("scenes", {})
            for scene in [chosen] if chosen else scenes:
                print(row(bgsim, pathlib.Path(path), scene, options, folder, counts), flush=True)
    print("\n" + counts.text())


class Counts:
    """Of scenes with a reference: how many were wrong by how much, and how many of these had a note on accuracy."""

    LIMITS = (1e-2, 1e-3, 1e-4)

    def __init__(self):
        self.rows = []

    def text(self):
        lines = [f"{len(self.rows)} scenes were judged."]
        for limit in self.LIMITS:
            wrong = [noted for error, noted in self.rows if error > limit]
            lines.append(f"Wrong by more than {limit:g} of a range: {len(wrong)}, of these noted: {sum(wrong)}.")
        right = [noted for error, noted in self.rows if error <= self.LIMITS[-1] / 10]
        lines.append(f"Right to {self.LIMITS[-1] / 10:g}: {len(right)}, of these noted: {sum(right)}.")
        return "\n".join(lines)


def row(bgsim, model, scene, options, folder, counts):
    begin = f"| {model.stem} {scene} |"
    own_run = run(bgsim, model, scene, options, folder)
    if own_run is None:
        return f"{begin} | did not complete | | | | |"
    columns, report = own_run
    relative = report["tolerances"]["relative"] if report.get("tolerances") else ""
    reference = reference_of(bgsim, model, scene, folder)
    if reference is None:
        return f"{begin} {relative:g} | no reference | | | | |"
    values, own, _ = reference
    judged = {name: distance(column, values[name]) for name, column in columns.items()}
    sure = {name: error for name, error in judged.items() if error > 10.0 * own[name] or own[name] < 1e-5}
    if not sure:
        return f"{begin} {relative:g} | below the reference's error | | | {max(own.values()):.1e} | |"
    worst = max(sure, key=sure.get)
    noted = any(word in note for note in report.get("notes", []) for word in ACCURACY)
    counts.rows.append((sure[worst], noted))
    known = report.get("errors", {}).get(worst)
    estimate = f"{known['estimate'] / known['range']:.1e}" if known and known["range"] else ""
    return (f"{begin} {relative:g} | {worst} | {sure[worst]:.1e} | {estimate} | {own[worst]:.1e} | "
            f"{'yes' if noted else ''} |")


if __name__ == "__main__":
    main(sys.argv[1:])
