"""Poles, zeros and frequency responses of bgsim beside those of Octave's control package: see scripts/oracle-octave.

Shipped models: Octave takes the matrices that `bgsim linearize` writes, for responses in descriptor form, where loops are not
eliminated. Random graphs (trees of junctions with R, C, I, TF, GY and a source): Octave takes E, A, B, C, D as written down here from
the graph, all bonds' efforts and flows as variables, without causality.
"""
import argparse
import json
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

import numpy as np

FREQUENCIES = 25
LIMIT = 1e-5  # of printed poles and zeros, which have six digits: half a unit of the last is 5e-6 at most. Where several are alike,
# what rounding makes of them counts as this much
EPSILON, TINY = 2.2e-16, 1e-12
RESPONSE_LIMIT = 1e-8  # of the largest magnitude of a response


# ---- random graphs

def random_graph(seed):
    """(model, E, A, B, C, D): one input, one output."""
    dice = random.Random(seed)
    elements, bonds = {}, []
    kinds = [dice.choice("01")]
    elements["j0"] = {"kind": kinds[0]}
    value = lambda: round(10 ** dice.uniform(-1.5, 1.5), 4)
    links = []  # (from, to): through the two-port "x", or none
    for i in range(1, dice.randint(1, 5) + 1):
        parent = dice.randrange(i)
        way = dice.choice(["bond", "bond", "TF", "GY"])
        kinds.append({"0": "1", "1": "0"}[kinds[parent]] if way == "bond" else dice.choice("01"))
        elements[f"j{i}"] = {"kind": kinds[i]}
        if way == "bond":
            links.append((f"j{parent}", f"j{i}"))
        else:
            elements[f"x{i}"] = {"kind": way, "modulus": value()}
            links += [(f"j{parent}", f"x{i}"), (f"x{i}", f"j{i}")]
    ports = []
    for i, _ in enumerate(kinds):
        for k in range(dice.randint(1, 3)):
            kind = dice.choice("RCI")
            key = {"R": "resistance", "C": "capacitance", "I": "inertance"}[kind]
            elements[f"{kind.lower()}{i}_{k}"] = {"kind": kind, key: value()}
            ports.append((f"j{i}", f"{kind.lower()}{i}_{k}"))
    at = dice.randrange(len(kinds))
    elements["s"] = {"kind": "Se", "effort": 1} if kinds[at] == "1" else {"kind": "Sf", "flow": 1}
    bonds = links + ports + [("s", f"j{at}")]
    stores = [name for name, e in elements.items() if e["kind"] in "CI"]
    seen = dice.choice(ports)[1]
    letter = dice.choice("ef")
    model = {"bgsim": 1, "name": f"graph{seed}", "elements": elements, "bonds": [{"from": a, "to": b} for a, b in bonds],
             "outputs": {"y": f"{seen}.{letter}"}, "scenes": {"s": {"stop": 1, "samples": 2}}}
    # Variables: stores, then efforts and flows by bond, then y.
    n, m = len(stores), len(bonds)
    size = n + 2 * m
    E, A, B = [], [], []
    column = {name: i for i, name in enumerate(stores)}

    def row(terms, rate=None, source=0.0):
        line, of_rate = [0.0] * size, [0.0] * size
        for at_column, factor in terms:
            line[at_column] += factor
        if rate is not None:
            of_rate[rate] = 1.0
        A.append(line), E.append(of_rate), B.append([source])

    e, f = lambda b: n + b, lambda b: n + m + b
    for name, element in elements.items():
        kind = element["kind"]
        mine = [(b, 1.0 if to == name else -1.0) for b, (begin, to) in enumerate(bonds) if name in (begin, to)]
        first = mine[0][0]
        if kind in "01":
            same, summed = (e, f) if kind == "0" else (f, e)
            for b, _ in mine[1:]:
                row([(same(b), 1.0), (same(first), -1.0)])
            row([(summed(b), sign) for b, sign in mine])
        elif kind == "R":
            row([(e(first), 1.0), (f(first), -element["resistance"])])
        elif kind in "CI":
            rate, other, size_of = (f, e, element.get("capacitance")) if kind == "C" else (e, f, element.get("inertance"))
            row([(rate(first), 1.0)], rate=column[name])
            row([(other(first), 1.0), (column[name], -1.0 / size_of)])
        elif kind in ("Se", "Sf"):
            row([((e if kind == "Se" else f)(first), -1.0)], source=1.0)
        else:
            (one, _), (two, _), r = mine[0], mine[1], element["modulus"]
            pairs = [(e(one), e(two)), (f(two), f(one))] if kind == "TF" else [(e(one), f(two)), (e(two), f(one))]
            for left, right in pairs:
                row([(left, 1.0), (right, -r)])
    C = [[0.0] * size]
    C[0][(e if letter == "e" else f)(next(b for b, (_, to) in enumerate(bonds) if to == seen))] = 1.0
    assert len(A) == size, (len(A), size)
    return model, *(np.array(matrix, dtype=float) for matrix in (E, A, B, C)), np.zeros((1, 1))


# ---- bgsim

NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]\d+)?"


def printed_roots(text, word=None):
    """Poles or zeros of a printed table, each with how many there are that rounding does not tell apart."""
    roots = []
    for line in text.splitlines():
        if word is not None:
            if not line.startswith(word + " "):
                continue
            line = line[len(word):].strip()
        match = re.match(rf"({NUMBER})(?: \+- ({NUMBER})j)?(?:\s|$)|\+- ({NUMBER})j", line)
        if not match or "grow: " in line or "grows: " in line:
            continue
        real, imaginary, alone = match.groups()
        value = complex(float(real or 0), float(imaginary or alone or 0))
        several = re.search(r"(\d+) that rounding does not tell apart", line)
        alike = int(several[1]) if several else 1
        roots += [(value, alike), (value.conjugate(), alike)] if value.imag else [(value, alike)]
    return roots


class Command:
    def __init__(self, words, folder):
        self.words, self.folder = words, pathlib.Path(folder)

    def __call__(self, *arguments):
        """Standard output and notes. Raises Refused."""
        done = subprocess.run([self.words, *map(str, arguments)], capture_output=True, text=True, timeout=120, check=False)
        if done.returncode:
            raise Refused(next((line for line in done.stderr.split("\n") if "error" in line), done.stderr[:200]))
        return done.stdout + done.stderr


class Refused(Exception):
    pass


def linearized(command, file, arguments, name):
    target = command.folder / f"{name}_linear.json"
    command("linearize", file, *arguments, "-o", target)
    system = json.loads(target.read_text())
    return system, {key: np.array(value, dtype=float) for key, value in system.items() if re.fullmatch(r"[A-E]\d?", key)}


def shape(matrix, rows, columns):
    return np.asarray(matrix, dtype=float).reshape(rows, columns)


def cases_of(command, file, name, own=None):
    """One for each input and output: what bgsim says, and the matrices for Octave."""
    system, state_form = linearized(command, file, [], name)
    inputs, outputs, n = [i["name"] for i in system["inputs"]], [o["name"] for o in system["outputs"]], len(system["states"])
    if not n or n > 60 or not inputs or not outputs:
        raise Refused("no states, inputs or outputs" if n <= 60 else "more than 60 states")
    poles = printed_roots(command("poles", file))
    _, free_form = linearized(command, file, ["--descriptor"], name + "_d")
    A = shape(state_form["A"], n, n)
    for i, source in enumerate(inputs[:2]):
        for o, output in enumerate(outputs[:3]):
            case = {"name": f"{name}: {source} to {output}", "A": A, "poles": poles if i == o == 0 else None}
            if own is not None:
                case |= dict(zip("EFBCD", own))
            else:
                size = len(free_form["A"])
                case |= {"E": shape(free_form["E"], size, size), "F": shape(free_form["A"], size, size),
                         "B": shape(free_form["B"], size, len(inputs))[:, [i]], "C": shape(free_form["C"], len(outputs), size)[[o], :],
                         "D": shape(free_form["D"], len(outputs), len(inputs))[[o]][:, [i]]}
            if not any(key[1:] for key in state_form):  # no derivatives of inputs
                case |= {"B0": shape(state_form["B"], n, len(inputs))[:, [i]], "C0": shape(state_form["C"], len(outputs), n)[[o], :],
                         "D0": shape(state_form["D"], len(outputs), len(inputs))[[o]][:, [i]]}
            try:
                table = command.folder / "bode.csv"
                said = command("bode", file, "--in", source, "--out", output, "--points", FREQUENCIES, "-o", table)
                rows = np.atleast_2d(np.genfromtxt(table, delimiter=",", skip_header=1))
                if "the response is known to" in said:
                    case["doubted"] = ["responses"]
                case["w"], case["response"] = rows[:, 0], rows[:, 5] + 1j * rows[:, 6]
                text = command("zeros", file, "--in", source, "--out", output)
                if "known to few digits" in text:
                    case["doubted"] = case.get("doubted", []) + ["zeros"]
                case["zeros"] = printed_roots(text, "zero")
            except Refused as why:
                case["refused"] = str(why)
            yield case


# ---- Octave

def octave_matrix(matrix):
    rows = ["[" + " ".join(repr(float(x)) for x in row) + "]" for row in np.atleast_2d(matrix)]
    return "[" + ";".join(rows) + "]" if np.size(matrix) else f"zeros({np.shape(matrix)[0]}, {np.shape(matrix)[1]})"


PROLOGUE = """pkg load control
warning("off", "all");
function show(kind, z)
  printf("%s", kind); z = z(:).';
  for k = 1:numel(z), printf(" %.17g %.17g", real(z(k)), imag(z(k))); end
  printf("\\n");
end
function try_show(kind, f)
  try, show(kind, f()); catch err, printf("%s! %s\\n", kind, strrep(err.message, "\\n", " ")); end
end
"""


def octave(cases, folder):
    lines = [PROLOGUE]
    for k, case in enumerate(cases):
        lines.append(f'printf("case {k}\\n");')
        for key in ("A", "E", "F", "B", "C", "D", "B0", "C0", "D0"):
            if key in case:
                lines.append(f"{key} = {octave_matrix(case[key])};")
        if case["poles"] is not None:
            lines.append('try_show("poles", @() pole(dss(F, B, C, D, E)));' if case.get("own") else
                         'try_show("poles", @() pole(ss(A, zeros(rows(A), 1), zeros(1, rows(A)), 0)));')
        if "response" in case:
            lines.append(f"w = {octave_matrix(case['w'])};")
            lines.append('try_show("response", @() freqresp(dss(F, B, C, D, E), w));')
        if "zeros" in case and "B0" in case:
            lines.append('try_show("zeros", @() zero(ss(A, B0, C0, D0)));')
    script = pathlib.Path(folder) / "cases.m"
    script.write_text("\n".join(lines) + "\n")
    done = subprocess.run(["octave", "--no-gui", "--quiet", "--norc", str(script)], capture_output=True, text=True, timeout=1800, check=False)
    results, now = {}, None
    for line in done.stdout.splitlines():
        word, *rest = line.split()
        if word == "case":
            now = results.setdefault(int(rest[0]), {})
        elif word.endswith("!"):
            now[word[:-1]] = " ".join(rest)
        else:
            numbers = np.array([float(x) for x in rest])
            now[word] = numbers[0::2] + 1j * numbers[1::2]
    if len(results) != len(cases):
        sys.exit(f"Octave ended early: {done.stderr[-500:]}")
    return results


# ---- comparison

def spread(root, alike, size):
    """How far apart rounding puts roots of which several are alike."""
    return max(LIMIT * abs(root), 100 * size * EPSILON ** (1 / alike), TINY) if alike > 1 else max(abs(root) * LIMIT, TINY)


def zeros_apart(ours, theirs, poles, size):
    """As roots_apart, but what a pole cancels may be in one list and not in the other: what input and output do not see is a
    matter of definition. Each zero beside the nearest of the other list and the poles."""
    worst = 0.0
    for one, other in ((ours, theirs), ([(z, 1) for z in theirs], [z for z, _ in ours])):
        for zero, alike in one:
            nearest = min([*other, *poles], key=lambda z: abs(z - zero), default=math.inf)
            # Without marks of its own Octave's are compared as if four were alike near 0.
            alike = max(alike, 4 if abs(zero) <= 2 * size * EPSILON ** 0.25 else 1)
            worst = max(worst, LIMIT * abs(nearest - zero) / max(spread(zero, alike, size), 100 * size * EPSILON))
    return worst


def away_from_poles(case):
    """Frequencies at which there is a response: a pole on the axis leaves none."""
    poles = np.linalg.eigvals(case["A"])
    return np.array([np.min(np.abs(1j * w - poles), initial=np.inf) > 1e-4 * w for w in case["w"]]) & np.isfinite(case["response"])


def scale_of(case, known):
    """How large a response is, or the terms that it is the sum of where these cancel."""
    terms = 0.0
    for w in case["w"][known]:
        inverse = np.abs(np.linalg.pinv(1j * w * case["E"] - case["F"]))
        terms = max(terms, float((np.abs(case["C"]) @ inverse @ np.abs(case["B"]) + np.abs(case["D"]))[0, 0]))
    return max(float(np.max(np.abs(case["response"][known]))), 1e-8 * terms, 1e-300)


def roots_apart(ours, theirs, size):
    """The largest difference of two lists over what may be, each root beside the nearest of the other that is left; or words."""
    if len(ours) != len(theirs):
        return f"{len(ours)} and {len(theirs)} of them"
    rest, worst = list(theirs), 0.0
    for root, alike in sorted(ours, key=lambda pair: -abs(pair[0])):
        nearest = min(rest, key=lambda other: abs(other - root))
        rest.remove(nearest)
        # Octave's roots near 0 have the rounding of the largest.
        worst = max(worst, LIMIT * abs(nearest - root) / max(spread(root, alike, size), 100 * size * EPSILON))
    return worst


class Tally:
    def __init__(self):
        self.found, self.odd, self.doubted = {}, [], {}

    def take(self, case, kind, apart, limit):
        name = case["name"]
        if kind in case.get("doubted", ()):
            self.doubted[kind] = self.doubted.get(kind, 0) + 1
            return
        if isinstance(apart, str) or apart > limit:
            self.odd.append(f"{kind:9} {name}: {apart if isinstance(apart, str) else f'{apart:.1e}'}")
        if not isinstance(apart, str):
            self.found.setdefault(kind, []).append(apart)


def compare(cases, results, tally):
    for k, case in enumerate(cases):
        theirs = results[k]
        size = max(np.abs(np.linalg.eigvals(case["A"])), default=0.0)
        for kind in ("poles", "zeros"):
            if case.get(kind) is None or kind not in theirs:
                continue
            other = theirs[kind]
            if isinstance(other, str):
                tally.take(case, kind, "Octave: " + other, LIMIT)
                continue
            other = [z for z in other if np.isfinite(z)]
            if kind == "zeros" and (case[kind] or other):
                tally.take(case, kind, zeros_apart(case[kind], other, np.linalg.eigvals(case["A"]), size), LIMIT)
            elif kind == "poles":
                tally.take(case, kind, roots_apart(case[kind], other, size), LIMIT)
        if "response" in case and "response" in theirs:
            other, known = theirs["response"], away_from_poles(case)
            if not known.any():
                continue
            apart = "Octave: " + other if isinstance(other, str) else float(
                np.max(np.abs(other - case["response"])[known]) / scale_of(case, known))
            tally.take(case, "responses", apart, RESPONSE_LIMIT)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("models", type=pathlib.Path)
    parser.add_argument("--graphs", type=int, default=300, help="random graphs (default: 300)")
    parser.add_argument("--seed", type=int, default=1, help="of the first (default: 1)")
    parser.add_argument("--only", default="", help="shipped models whose name contains this")
    options = parser.parse_args()
    worst = 0
    with tempfile.TemporaryDirectory() as folder:
        command = Command(options.command, folder)
        for title, jobs in (("shipped models", [(path, path.stem, None) for path in sorted(options.models.glob("*.json"))
                                                if options.only in path.stem]),
                            ("random graphs", [(None, f"graph{seed}", seed)
                                               for seed in range(options.seed, options.seed + options.graphs)])):
            cases, refused, tally = [], {}, Tally()
            for path, name, seed in jobs:
                own = None
                if seed is not None:
                    model, *own = random_graph(seed)
                    path = pathlib.Path(folder) / f"{name}.json"
                    path.write_text(json.dumps(model))
                try:
                    for case in cases_of(command, path, name, own):
                        case["own"] = own is not None
                        cases.append(case)
                except Refused as why:
                    code = re.search(r"BG\d+", str(why))
                    refused.setdefault(code[0] if code else str(why), []).append(name)
            compare(cases, octave(cases, folder), tally)
            compared = len(jobs) - sum(map(len, refused.values()))
            print(f"{title}: {compared} compared, {len(cases)} pairs of input and output")
            for code, names in sorted(refused.items()):
                print(f"  refused {code}: {len(names)} ({', '.join(names[:6])}{', ...' if len(names) > 6 else ''})")
            for kind, values in tally.found.items():
                print(f"  {kind}: {len(values)}, median difference {np.median(values):.1e}, largest {max(values):.1e}")
            for kind, count in tally.doubted.items():
                print(f"  {kind}: {count} that bgsim says it does not know well are left out")
            for line in tally.odd:
                print("  " + line)
            worst += len(tally.odd)
    sys.exit(worst > 0)


main()
