"""States that must keep their sign: by bgsim's own tolerances, and by one plain absolute tolerance for all states.

usage: signs.py BGSIM

Populations, concentrations and tanks, some from 1e-12. For each, over five methods: how far a state went below zero, as
a part of its largest value, and the error of the last row's worst state against a run of dirk5 at 1e-11, as a part of its
largest value. Prints Markdown.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile

METHODS = ("bdf", "adams", "ida", "erk4", "dirk4")
SECONDS = 30

# name: rates of the states ([x] is a state), initial values, end of the scene
CASES = {
    "logistic growth from 1e-12": ({"y": "[y]*(1-[y])"}, {"y": 1e-12}, 60),
    "predator and prey, from 5": ({"x": "[x]*(1-[y])", "y": "[y]*([x]-1)"}, {"x": 5, "y": 5}, 60),
    "predator and prey, of 1e-15": ({"x": "[x]*(1-1e15*[y])", "y": "[y]*(1e15*[x]-1)"}, {"x": 3e-15, "y": 3e-15}, 30),
    "epidemic from one in 1e9": (
        {"s": "-3*[s]*[i]", "i": "3*[s]*[i]-[i]", "r": "[i]"}, {"s": 1, "i": 1e-9}, 60),
    "chain of decays": ({"a": "-[a]", "b": "[a]-100*[b]", "c": "100*[b]"}, {"a": 1}, 50),
    "enzyme that uses its substrate up": (
        {"s": "-[s]/([s]+0.01)", "p": "[s]/([s]+0.01)"}, {"s": 1}, 5),
    "Robertson's reaction": (
        {"a": "-0.04*[a]+1e4*[b]*[c]", "b": "0.04*[a]-1e4*[b]*[c]-3e7*[b]^2", "c": "3e7*[b]^2"}, {"a": 1}, 1e6),
    "Lotka's reaction, autocatalytic": (
        {"a": "0.01-[a]*[b]", "b": "[a]*[b]-[b]*0.3"}, {"a": 1, "b": 1e-12}, 200),
    "tank through a hole": ({"h": "-if([h] > 0, sqrt([h]), 0)"}, {"h": 1}, 4),
    "two tanks, the second empties": (
        {"u": "-[u]", "v": "[u]-50*[v]"}, {"u": 1e-3}, 40),
}


def model(rates, initial, stop):
    """Stores of capacitance 1, each fed by its rate."""
    elements, bonds = {}, []
    for name, rate in rates.items():
        elements["in_" + name] = {"kind": "MSf", "flow": rate.replace("[", "").replace("]", ".q")}
        elements["n_" + name] = {"kind": "0"}
        elements[name] = {"kind": "C", "capacitance": 1, "initial": {"q": initial.get(name, 0)}}
        bonds += [{"from": "in_" + name, "to": "n_" + name}, {"from": "n_" + name, "to": name}]
    return {"bgsim": 1, "name": "signs", "elements": elements, "bonds": bonds,
            "outputs": {name: name + ".q" for name in rates}, "scenes": {"main": {"stop": stop, "samples": 401}}}


def run(bgsim, file, options, folder):
    trace = folder / "trace.csv"
    trace.unlink(missing_ok=True)
    command = [bgsim, str(file), "-o", str(trace), "--quiet", "--no-audit"] + options
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return None
    if done.returncode != 0:
        return None
    with open(trace, newline="") as rows:
        table = list(csv.reader(rows))[1:]
    return [[float(row[i]) for row in table] for i in range(1, len(table[0]))]


def judge(columns, reference):
    """Depth below zero and error, both as parts of the largest value, of the worst state."""
    below = error = 0.0
    for column, right in zip(columns, reference):
        largest = max(abs(value) for value in right)
        below = max(below, -min(column) / largest)
        error = max(error, max(abs(a - b) for a, b in zip(column, right)) / largest)
    return below, error


def cell(results):
    """The worst over the methods that completed, and which did not."""
    missing = [method for method, result in results if result is None]
    done = [result for _, result in results if result is not None]
    if not done:
        return "none completes"
    below, error = max(r[0] for r in done), max(r[1] for r in done)
    text = f"{below:.0e}, {error:.0e}" if below > 0 else f"0, {error:.0e}"
    return text + (f" ({', '.join(missing)}: no result)" if missing else "")


def main(bgsim):
    print("| states | own, 1e-6 | plain, 1e-6 | own, 1e-3 | plain, 1e-3 |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        file = folder / "model.json"
        for name, (rates, initial, stop) in CASES.items():
            file.write_text(json.dumps(model(rates, initial, stop)))
            reference = run(bgsim, file, ["--method", "dirk5", "--relative", "1e-11"], folder)
            cells = []
            for relative in ("1e-6", "1e-3"):
                for absolute in ([], ["--absolute", f"{1e-3 * float(relative):g}"]):
                    results = []
                    for method in METHODS:
                        columns = run(bgsim, file, ["--method", method, "--relative", relative] + absolute, folder)
                        results.append((method, columns and reference and judge(columns, reference)))
                    cells.append(cell(results))
            print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
