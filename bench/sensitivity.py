"""Sensitivities of many parameters: by a run for each, and by the adjoint equations.

    scripts/bench sensitivity [SECTIONS]...

A ladder of RC sections with 2 n + 2 parameters; the derivatives of the mean of one voltage by all of them. One thread, with
estimates of errors: each method makes its runs twice.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import time

LIMIT = 300  # seconds


def ladder(sections):
    parameters, elements, bonds = {"U": 1}, {"source": {"kind": "Se", "effort": "U"}}, []
    before = "source"
    for i in range(1, sections + 1):
        parameters |= {f"R{i}": 1 + 0.01 * i, f"C{i}": 0.5 + 0.003 * i}
        elements |= {f"one{i}": {"kind": "1"}, f"r{i}": {"kind": "R", "resistance": f"R{i}"},
                     f"zero{i}": {"kind": "0"}, f"c{i}": {"kind": "C", "capacitance": f"C{i}"}}
        pairs = [(before, f"one{i}"), (f"one{i}", f"r{i}"), (f"one{i}", f"zero{i}"), (f"zero{i}", f"c{i}")]
        bonds += [{"from": a, "to": b} for a, b in pairs]
        before = f"zero{i}"
    parameters["RL"] = 5
    elements["load"] = {"kind": "R", "resistance": "RL"}
    bonds.append({"from": before, "to": "load"})
    return {"bgsim": 1, "name": "ladder", "parameters": parameters, "elements": elements, "bonds": bonds,
            "outputs": {"u": f"c{max(1, sections // 4)}.e"}, "scenes": {"s": {"stop": 100, "samples": 2}}}


def measured(command, model, method):
    """(seconds, derivatives by parameter); none of these after the limit."""
    begin = time.perf_counter()
    try:
        done = subprocess.run([command, "sensitivity", model, "--norm", "mean", "--method", method, "-j1"],
                              capture_output=True, text=True, check=True, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return LIMIT, None
    seconds = time.perf_counter() - begin
    rows = [line.split() for line in done.stdout.splitlines()[4:]]
    return seconds, {row[0]: float(row[2]) for row in rows if len(row) > 2}


command, sections = sys.argv[1], [int(n) for n in sys.argv[2:]] or [5, 20, 50, 100]
print("parameters  states  forward / s  adjoint / s  largest difference, of the largest per cent by per cent")
with tempfile.TemporaryDirectory() as folder:
    for n in sections:
        model = pathlib.Path(folder) / "ladder.json"
        content = ladder(n)
        model.write_text(json.dumps(content))
        (adjoint_seconds, adjoint), (forward_seconds, forward) = (measured(command, str(model), m) for m in ("adjoint", "forward"))
        apart = ""
        if forward and adjoint:
            scaled = {p: (forward[p] * v, (forward[p] - adjoint[p]) * v) for p, v in content["parameters"].items()}
            apart = f"{max(abs(d) for _, d in scaled.values()) / max(abs(s) for s, _ in scaled.values()):.1e}"
        words = f"{forward_seconds:11.2f}" if forward else f"over {LIMIT:6d}"
        print(f"{2 * n + 2:10d}  {n:6d}  {words}  {adjoint_seconds:11.2f}  {apart}", flush=True)
