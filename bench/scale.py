"""How processor time and memory of a run grow with a model, shape by shape.

scale.py BGSIM [SHAPE]...    each shape at growing sizes; the exponent is that of the last two

Sizes are compared within one run, so that the machine's speed cancels. A scene makes some twenty steps whatever the size, unless
the shape says otherwise, so that what is measured is the model.
"""

import json
import math
import os
import subprocess
import sys
import tempfile

STOP = 0.01


def model(elements=None, bonds=None, **more):
    parts = {
        "s": {"kind": "Se", "effort": 1},
        "z": {"kind": "1"},
        "r": {"kind": "R", "resistance": 1},
        "m": {"kind": "I", "inertance": 1},
    }
    joined = [{"from": "s", "to": "z"}, {"from": "z", "to": "r"}, {"from": "z", "to": "m"}]
    text = {
        "bgsim": 1,
        "name": "scale",
        "elements": {**parts, **(elements or {})},
        "bonds": joined + (bonds or []),
        "outputs": {"p": "m.p"},
        "scenes": {"run": {"stop": STOP, "samples": 3}},
    }
    return {**text, **more}


def sources(n, kind, effort):
    """A model with n sources on one junction."""
    return model(
        {f"s{i}": {"kind": kind, "effort": effort(i)} for i in range(n)},
        [{"from": f"s{i}", "to": "z"} for i in range(n)],
    )


def sines(n):
    return {"model.json": sources(n, "Se", lambda i: f"sin({1 + 0.01 * i}*t)")}


def one_signal(n):
    built = sources(n, "MSe", lambda i: f"{i}*a")
    return {"model.json": {**built, "signals": {"a": "sin(m.f)"}}}


def bonds(n):
    return {
        "model.json": model(
            {f"r{i}": {"kind": "R", "resistance": 1e-5} for i in range(n)},
            [{"from": "z", "to": f"r{i}"} for i in range(n)],
        )
    }


def parameters(n):
    chain = {"a0": 1, **{f"a{i}": f"a{i - 1}*1.0001" for i in range(1, n)}}
    built = model(parameters=chain)
    built["elements"]["r"]["resistance"] = f"a{n - 1}"
    return {"model.json": built}


def signals(n):
    chain = {"a0": "m.f", **{f"a{i}": f"a{i - 1}*1.0001" for i in range(1, n)}}
    return {"model.json": model(signals=chain, outputs={"y": f"a{n - 1}"})}


def outputs(n):
    return {"model.json": model(outputs={f"y{i}": f"m.p*{i} + 1" for i in range(n)})}


def scenes(n):
    return {"model.json": model(scenes={f"c{i}": {"stop": STOP, "samples": 3} for i in range(n)})}


def tables(n):
    text = "t,u\n" + "\n".join(f"{0.001 * i},{i % 3}" for i in range(12)) + "\n"
    files = {f"u{i}.csv": text for i in range(n)}
    return {"model.json": sources(n, "Se", lambda i: f'table("u{i}.csv", "u", t)'), **files}


def table_rows(n):
    rows = "\n".join(f"{i * 1e-7:.10g},{i * 7919 % 1000 / 1000}" for i in range(n))
    built = model()
    built["elements"]["s"]["effort"] = 'table("u.csv", "u", t)'
    built["scenes"]["run"]["stop"] = 1e-4
    return {"model.json": built, "u.csv": "t,u\n" + rows + "\n"}


def submodels(depth, used):
    """Files each of which uses the next one once or twice."""
    files = {}
    for k in range(depth):
        part = {"bgsim": 1, "name": f"p{k}", "ports": {"port": "j"}}
        if k == depth - 1:
            part["elements"] = {
                "j": {"kind": "1"},
                "r": {"kind": "R", "resistance": 1},
                "m": {"kind": "I", "inertance": 1},
            }
            part["bonds"] = [{"from": "j", "to": "r"}, {"from": "j", "to": "m"}]
        else:
            part["types"] = {"next": f"p{k + 1}.json"}
            part["elements"] = {"j": {"kind": "0"}, **{c: {"kind": "next"} for c in used}}
            part["bonds"] = [{"from": "j", "to": f"{c}.port"} for c in used]
        if k == 0:
            del part["ports"]
            part["elements"]["s"] = {"kind": "Se", "effort": 1}
            part["bonds"].append({"from": "s", "to": "j"})
            part["outputs"] = {"p": "a." * (depth - 1) + "m.p"}
            part["scenes"] = {"run": {"stop": STOP, "samples": 3}}
        files["model.json" if k == 0 else f"p{k}.json"] = part
    return files


def rows(n):
    built = model()
    built["elements"]["s"]["effort"] = "sin(t)"
    built["scenes"]["run"] = {"stop": 10, "samples": n}
    return {"model.json": built}


def conditions_of_t(n):
    return {"model.json": sources(n, "Se", lambda i: f"if(t > {STOP * (i + 0.5) / n}, 1, 0)")}


def conditions(n):
    return {"model.json": sources(n, "MSe", lambda i: f"if(m.p > {STOP * (i + 0.5) / n}, 1e-3, 0)")}


def pipe(n):
    """A pipe of n stores and laws that are solved for what they are not written for."""
    return {
        "model.json": model(
            {
                "n": {"kind": "0", "repeat": n},
                "c": {"kind": "C", "repeat": n, "capacitance": 1e-3},
                "j": {"kind": "1", "repeat": n},
                "w": {"kind": "R", "repeat": n, "law": "e = 1e-3*f + 1e-5*f*abs(f)"},
            },
            [
                {"from": "z", "to": "n[1]"},
                {"from": "n[i]", "to": "c[i]"},
                {"from": "n[i]", "to": "j[i]"},
                {"from": "j[i]", "to": "n[i+1]"},
                {"from": "j[i]", "to": "w[i]"},
            ],
        )
    }


SHAPES = {
    "sources sin(w t) on one junction": (sines, [2000, 4000, 8000]),
    "resistors on one junction": (bonds, [4000, 8000, 16000]),
    "elements that use one signal": (one_signal, [4000, 8000, 16000]),
    "laws that loops solve, in a pipe": (pipe, [250, 500, 1000]),
    "parameters in a chain": (parameters, [8000, 16000, 32000]),
    "signals in a chain": (signals, [8000, 16000, 32000]),
    "outputs": (outputs, [4000, 8000, 16000]),
    "scenes": (scenes, [4000, 8000, 16000]),
    "table files": (tables, [1000, 2000, 4000]),
    "rows of a table": (table_rows, [1000000, 3000000, 10000000]),
    "submodels, each with the next one twice: leaves": (
        lambda n: submodels(1 + round(math.log2(n)), "ab"),
        [2**13, 2**15, 2**17],
    ),
    "submodels within each other": (lambda n: submodels(n, "a"), [500, 1000, 2000]),
    "rows of the trace": (rows, [100000, 1000000, 10000000]),
    "conditions of t, each an event": (conditions_of_t, [500, 1000, 2000]),
    "conditions of states, each an event": (conditions, [500, 1000, 2000]),
}


def measured(bgsim, files):
    """Processor seconds and peak memory in MB of a run."""
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(content if isinstance(content, str) else json.dumps(content))
        command = [bgsim, os.path.join(folder, "model.json"), "--quiet", "--keep-all", "-o", os.path.join(folder, "x.csv")]
        process = subprocess.Popen(command)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            sys.exit(f"{' '.join(command)}: exit code {process.returncode}")
        return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    bgsim, wanted = sys.argv[1], sys.argv[2:]
    print(f"{'what grows':48}{'size':>10}{'seconds':>9}{'MB':>7}  exponent")
    for name, (files, sizes) in SHAPES.items():
        if wanted and not any(word in name for word in wanted):
            continue
        before = None
        for size in sizes:
            seconds, peak = measured(bgsim, files(size))
            exponent = f"{math.log(seconds / before[0]) / math.log(size / before[1]):8.2f}" if before else ""
            print(f"{name:48}{size:10}{seconds:9.2f}{peak:7.0f}  {exponent}", flush=True)
            before = (seconds, size)


if __name__ == "__main__":
    main()
