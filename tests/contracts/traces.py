"""scripts/swings counts the periods of a known oscillation, and scripts/sampling finds a scene whose records alias one.

    traces.py PROJECT BGSIM
"""
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

project, bgsim = (os.path.abspath(path) for path in sys.argv[1:3])
faults = []


def script(name, *arguments):
    done = subprocess.run([sys.executable, os.path.join(project, "scripts", name), *arguments], text=True, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=dict(os.environ, BGSIM=bgsim), timeout=100)
    return done.returncode, done.stdout


def expect(what, answer, right):
    if not right:
        faults.append(f"{what}:\n{answer}")


def oscillator(folder, samples):
    """A mass on a spring, 10 periods of 0.1 s."""
    path = os.path.join(folder, "ring.json")
    model = {"bgsim": 1, "name": "ring", "parameters": {"w": "20*pi"},
             "elements": {"mass": {"kind": "I", "inertance": 1, "initial": {"p": 1}}, "both": {"kind": "1"},
                          "spring": {"kind": "C", "capacitance": "1/w^2"}},
             "bonds": [{"from": "both", "to": "mass"}, {"from": "both", "to": "spring"}],
             "outputs": {"v": "mass.f", "none": "0*mass.f"}, "scenes": {"free": {"stop": 1, "samples": samples}}}
    with open(path, "w", encoding="utf-8") as file:
        json.dump(model, file)
    return path


with tempfile.TemporaryDirectory() as folder:
    # Ten periods of a cosine that grows: twenty changes of sign, and nineteen turning points between its ends.
    trace = os.path.join(folder, "trace.csv")
    with open(trace, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["t", "y"])
        rows.writerows([i / 1000, (1 + i / 1e4) * math.cos(20 * math.pi * i / 1000)] for i in range(1001))
    code, answer = script("swings", trace, "y")
    expect("swings of ten periods", answer, code == 0 and answer.splitlines()[-1].split()[5] == "20" and
           answer.splitlines()[-1].split()[7] == "9.5")
    code, answer = script("swings", trace, "z")
    expect("swings of a column that is not there", answer, code != 0 and "has no column z; it has y" in answer)

    code, answer = script("sampling", oscillator(folder, 501))
    expect("sampling of a resolved oscillation", answer, code == 0 and "1 scenes, 0 columns missed" in answer)
    # Ten periods, recorded every 1/11 s, look like one.
    code, answer = script("sampling", oscillator(folder, 12))
    expect("sampling of an aliased oscillation", answer, code == 1 and "MISSED" in answer)

print("\n".join(faults) if faults else "measured as they are")
sys.exit(bool(faults))
