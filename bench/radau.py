"""Steps, evaluations of the rates and errors by Radau IIA of orders 5, 9 and 13, on scenes with references.

usage: radau.py BGSIM [--relative X,Y,...] [MODEL.SCENE]...     default: 1e-6,1e-9,1e-12 and the scenes of docs/performance.md

An error is the largest distance of an output from models/reference at the times of both, relative to the output's range
over the scene. Prints Markdown.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile

PROJECT = pathlib.Path(__file__).resolve().parent.parent
METHODS = ["radau", "radau9", "radau13"]
SCENES = ["rlc.under", "quarter_car.step", "euler_top.tumble", "van_der_pol.relaxation", "water_hammer.closure",
          "amplifier.tone", "bellow.literal", "bouncing_ball.bounces"]
SECONDS = 300
SAME_TIME = 1e-9  # of the scene


def table(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    return rows[0], [[float(cell) for cell in row] for row in rows[1:]]


def error(names, rows, reference_names, reference):
    span = reference[-1][0] - reference[0][0]
    at = {round(row[0] / span / SAME_TIME): row for row in rows}
    pairs = [(row, at[key]) for row in reference if (key := round(row[0] / span / SAME_TIME)) in at]
    if not pairs:
        raise SystemExit("no time of the reference is one of the scene")
    worst = 0.0
    for j, name in enumerate(reference_names[1:], 1):
        if name not in names:
            continue
        i = names.index(name)
        values = [row[j] for row in reference]
        size = max(values) - min(values)
        if size > 0.0:
            worst = max([worst] + [abs(ours[i] - right[j]) / size for right, ours in pairs])
    return worst


def measured(bgsim, model, scene, method, relative, folder):
    trace, report = folder / "trace.csv", folder / "report.json"
    done = subprocess.run([bgsim, "run", str(PROJECT / "models" / f"{model}.json"), "--scene", scene, "--method", method, "--relative",
                           relative, "-o", str(trace), "--report-json", str(report), "--quiet", "--no-audit"],
                          capture_output=True, text=True, timeout=SECONDS)
    if done.returncode != 0:
        return "failed | |"
    counts = json.loads(report.read_text())["counts"]
    wrong = error(*table(trace), *table(PROJECT / "models" / "reference" / f"{model}.{scene}.csv"))
    return f"{counts['steps']} | {counts['rate_evaluations']} | {wrong:.1e}"


def main(bgsim, words):
    tolerances = ["1e-6", "1e-9", "1e-12"]
    if words[:1] == ["--relative"]:
        tolerances, words = words[1].split(","), words[2:]
    print("| scene | tolerance |" + "".join(f" `{method}`: steps | rates | error |" for method in METHODS))
    print("|---" * (2 + 3 * len(METHODS)) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for word in words or SCENES:
            model, scene = word.split(".")
            for relative in tolerances:
                cells = [measured(bgsim, model, scene, method, relative, pathlib.Path(folder)) for method in METHODS]
                print(f"| {model} {scene} | {relative} | " + " | ".join(cells) + " |", flush=True)


main(sys.argv[1], sys.argv[2:])
