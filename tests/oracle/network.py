"""Networks of R, L, C, sources, switches and ideal diodes: the same network as a model and as equations of its nodes.

The equations E x' + A x = b(t) hold the voltages of nodes and the currents of sources, coils, diodes and switches. They are integrated by
Radau IIA of order 9 (five stages) in steps of one length; sides of diodes are found by trying all of them, the nearest to
the present ones first. Nothing is shared with bgsim: neither junctions, causality, states, complementarity nor the integrator.
"""
import itertools
import math

import numpy as np

from scenes import Scene


def radau_table(stages):
    """Nodes and coefficients: zeros of the derivative of order s-1 of x^(s-1) (x-1)^s."""
    p = np.polynomial.Polynomial([0, 1]) ** (stages - 1) * np.polynomial.Polynomial([-1, 1]) ** stages
    c = np.sort(p.deriv(stages - 1).roots().real)
    c[-1] = 1.0
    powers = np.vander(c, stages, increasing=True)
    integrals = np.array([[ci ** (k + 1) / (k + 1) for k in range(stages)] for ci in c])
    return c, integrals @ np.linalg.inv(powers)


NODES, TABLE = radau_table(5)
TINY = 1e-6  # of a step: how long stores take to jump


class Network:
    """Branches lead from node to node; node 0 is the ground."""

    def __init__(self):
        self.branches = []  # kind, name, tail, head, value

    def add(self, kind, name, tail, head, value=None, start=0.0):
        self.branches.append((kind, name, tail, head, value, start))
        return self

    # ---- as a model ----
    def scene(self, stop, outputs, records=41, **keys):
        """outputs: names of capacitors (their voltage) and coils (their current)"""
        scene = Scene(stop, records, **keys)
        nodes = sorted({n for b in self.branches for n in b[2:4]} - {0})
        for n in nodes:
            scene.element(f"n{n}", "0")
        for kind, name, tail, head, value, start in self.branches:
            scene.element(f"j_{name}", "1")
            if kind == "V":
                # a source gives power along its half-arrow: from its own junction to the node behind it
                scene.element(name, "Se", effort=value[0])
                ends = f"{name}>j_{name}"
                tail, head = head, tail
            else:
                ends = f"j_{name}>{name}"
                if kind == "R":
                    scene.element(name, "R", resistance=value)
                elif kind == "C":
                    scene.element(name, "C", capacitance=value, initial={"e": start})
                elif kind == "L":
                    scene.element(name, "I", inertance=value, initial={"f": start})
                elif kind == "D":
                    scene.element(name, "D", **({"threshold": value} if value else {}))
                elif kind == "S":
                    scene.element(name, "Sw", closed=value[0])
            scene.bonds(ends)
            if tail:
                scene.bonds(f"n{tail}>j_{name}")
            if head:
                scene.bonds(f"j_{name}>n{head}")
        kinds = {b[1]: b[0] for b in self.branches}
        scene.outputs(**{f"y_{o}": f"{o}.e" if kinds[o] == "C" else f"{o}.f" for o in outputs})
        return scene

    # ---- as equations ----
    def equations(self):
        nodes = sorted({n for b in self.branches for n in b[2:4]} - {0})
        self.at = {n: k for k, n in enumerate(nodes)}
        size = len(nodes)
        self.current = {}
        for kind, name, *_ in self.branches:
            if kind in "VLDS":
                self.current[name] = size
                size += 1
        self.size = size
        self.diodes = [b for b in self.branches if b[0] == "D"]
        self.switches = [b for b in self.branches if b[0] == "S"]

    def matrices(self, mode, sides):
        E, A = np.zeros((self.size, self.size)), np.zeros((self.size, self.size))
        constant = np.zeros(self.size)
        sources = []
        conducts = {b[1]: on for b, on in zip(self.diodes, mode)}
        conducts.update({b[1]: on for b, on in zip(self.switches, sides)})
        for kind, name, tail, head, value, _ in self.branches:
            ends = [(self.at[n], s) for n, s in ((tail, 1.0), (head, -1.0)) if n]
            if kind in "RC":
                M = A if kind == "R" else E
                g = 1.0 / value if kind == "R" else value
                for i, si in ends:
                    for j, sj in ends:
                        M[i, j] += si * sj * g
                continue
            k = self.current[name]
            for i, s in ends:
                A[i, k] += s
            if kind in "DS" and not conducts[name]:
                A[k, k] = 1.0
                continue
            for i, s in ends:
                A[k, i] += s
            if kind == "L":
                E[k, k] = -value
            elif kind == "V":
                sources.append((k, value[1]))
            elif kind == "D":
                constant[k] = value or 0.0
        return E, A, constant, sources

    def start(self):
        """Currents of coils and voltages of capacitors, as the solution of least squares: others follow in the first step."""
        rows, right = [], []
        for kind, name, tail, head, value, start in self.branches:
            row = np.zeros(self.size)
            if kind == "C":
                for n, s in ((tail, 1.0), (head, -1.0)):
                    if n:
                        row[self.at[n]] += s
            elif kind == "L":
                row[self.current[name]] = 1.0
            else:
                continue
            rows.append(row)
            right.append(start)
        return np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0]

    def value(self, x, name):
        """Current of a coil, voltage of a capacitor or any other branch."""
        kind, _, tail, head, *_ = next(b for b in self.branches if b[1] == name)
        if kind == "L":
            return x[self.current[name]]
        return self.voltage(x, tail, head)

    def voltage(self, x, tail, head):
        return (x[self.at[tail]] if tail else 0.0) - (x[self.at[head]] if head else 0.0)

    def solve(self, times, outputs, steps, breaks=(), sides_at=None):
        """Values of the outputs at the times, with `steps` steps over the whole of it."""
        self.equations()
        return Course(self, times, outputs, steps).run(breaks, sides_at)

    def answer(self, times, outputs, steps=400, breaks=(), sides_at=None):
        """Solved with steps of half the length until both agree to 1e-6 of each range, a hundredth of what is looked for."""
        coarse = self.solve(times, outputs, steps, breaks, sides_at)
        for _ in range(5):
            steps *= 2
            fine = self.solve(times, outputs, steps, breaks, sides_at)
            size = np.maximum(np.ptp(fine, axis=0), 1e-300)
            if (np.abs(fine - coarse).max(0) / size).max() < 1e-6:
                return fine
            coarse = fine
        raise ArithmeticError("no two step lengths agree")


class Course:
    """One solution of a network, with steps of one length."""

    def __init__(self, network, times, outputs, steps):
        self.network, self.outputs = network, outputs
        self.pending, self.found = list(times), []
        self.stop = times[-1]
        self.h = (self.stop - times[0]) / steps
        self.t, self.x = times[0], network.start()
        self.mode = (False,) * len(network.diodes)
        self.sides = ()
        self.slack = 1e-12  # by how much rounding may move a diode beyond its border
        self.kept = {}
        sources = [b[4][1] for b in network.branches if b[0] == "V"]
        self.size_u = max([abs(f(self.stop * k / 97)) for f in sources for k in range(97)] +
                          [abs(b[5]) for b in network.branches if b[0] == "C"] + [1e-30])
        resistances = [b[4] for b in network.branches if b[0] == "R"]
        self.size_i = max([abs(b[5]) for b in network.branches if b[0] == "L"] +
                          [1e-3 * self.size_u / max(resistances) if resistances else 1e-9])

    def step(self, x, t, h, mode, euler=False):
        """x at the stages, from x at t; none where the mode is singular. With euler one step of implicit Euler."""
        c, a = (np.array([1.0]), np.array([[1.0]])) if euler else (NODES, TABLE)
        if (mode, self.sides) not in self.kept:
            self.kept[mode, self.sides] = self.network.matrices(mode, self.sides)
        E, A, constant, sources = self.kept[mode, self.sides]
        # Unknowns are x at the stages: E (X - x) = h a (b - A X). What is used again and again is kept inverted.
        def matrix():
            return np.kron(np.linalg.inv(a) / h, E) + np.kron(np.eye(len(c)), A)
        b = np.tile(constant, (len(c), 1))
        for k, ck in enumerate(c):
            for row, f in sources:
                b[k, row] += f(t + ck * h)
        right = (b + np.outer(np.linalg.inv(a).sum(1), E @ x) / h).ravel()
        try:
            if h != self.h:
                return np.linalg.solve(matrix(), right).reshape(b.shape)
            if (mode, self.sides, "inverse") not in self.kept:
                self.kept[mode, self.sides, "inverse"] = np.linalg.inv(matrix())
            return (self.kept[mode, self.sides, "inverse"] @ right).reshape(b.shape)
        except np.linalg.LinAlgError:
            return None

    def margin(self, x, mode):
        """The least of what conducts and of what blocks, in parts of the largest currents and voltages."""
        least = np.inf
        for on, (_, name, tail, head, threshold, _) in zip(mode, self.network.diodes):
            if on:
                least = min(least, x[self.network.current[name]] / self.size_i)
            else:
                least = min(least, ((threshold or 0.0) - self.network.voltage(x, tail, head)) / self.size_u)
        return least

    def trial(self, mode, best):
        """How well the diodes keep this mode from now on, unless not as well as the best one does; and x after two short
        steps, in which the stores jump."""
        tiny, x, worst = TINY * self.h, self.x, np.inf
        for k in range(2):
            X = self.step(x, self.t + k * tiny, tiny, mode, euler=True)
            if X is None or not np.isfinite(X).all() or np.abs(X).max() > 1e25:
                return -np.inf, x
            x = X[0]
            worst = min(worst, self.margin(x, mode))
            if worst < min(best, -1e-9):
                return worst, x
        for part in (1e-4, 1e-2):
            X = self.step(x, self.t + 2 * tiny, part * self.h, mode)
            if X is None:
                return -np.inf, x
            worst = min(worst, min(self.margin(z, mode) for z in X))
        return worst, x

    def enter_mode(self):
        """The sides of the diodes from now on: those that keep best, of all."""
        best = (-np.inf, None, None)
        for mode in sorted(itertools.product((False, True), repeat=len(self.mode)),
                           key=lambda m: sum(a != b for a, b in zip(m, self.mode))):
            worst, x = self.trial(mode, best[0])
            if worst > best[0] + 1e-12:
                best = (worst, mode, x)
            if worst >= -1e-9:
                break
        if best[0] < -1e-4:
            raise ArithmeticError(f"no sides of the diodes at t = {self.t}: {best[0]}")
        _, self.mode, self.x = best
        self.t += 2 * TINY * self.h

    def violated(self, X):
        """The first stage at which a diode is on the wrong side."""
        before = self.margin(self.x, self.mode)
        allowed = min(-self.slack, 2 * before)
        return next((k for k, z in enumerate(X) if self.margin(z, self.mode) < allowed), None)

    def locate(self, low, high):
        """The length of step at which a diode comes to its border, between two."""
        while high - low > 1e-15 * max(self.t, self.h) and high > 1e-14 * self.h:
            middle = 0.5 * (low + high)
            if middle in (low, high):
                break
            if self.margin(self.step(self.x, self.t, middle, self.mode)[-1], self.mode) < -self.slack:
                high = middle
            else:
                low = middle
        return high

    def record(self, until, before_change):
        """Rows up to a time within the next step; at its end, where a mode ends, the row is that of the next mode."""
        while self.pending and self.pending[0] <= until * (1 + 1e-14):
            part = self.pending[0] - self.t
            if before_change and until < self.stop and abs(self.pending[0] - until) < 1e-12 * self.h:
                break
            # Where a mode has just begun the time is a little later already.
            x = self.x if part == 0 else self.step(self.x, self.t, part, self.mode)[-1]
            self.found.append([self.network.value(x, o) for o in self.outputs])
            self.pending.pop(0)

    def run(self, breaks, sides_at):
        changes = 0
        for limit in sorted({b for b in breaks if self.t < b < self.stop} | {self.stop}):
            self.sides = tuple(sides_at(0.5 * (self.t + limit))) if sides_at else ()
            self.enter_mode()
            while limit - self.t > 1e-13 * self.stop:
                h = self.h if limit - self.t > self.h * 1.0000001 else limit - self.t
                X = self.step(self.x, self.t, h, self.mode)
                if X is None:
                    raise ArithmeticError(f"singular at t = {self.t}")
                stage = self.violated(X)
                if stage is not None:
                    h = self.locate(0.0, h * NODES[stage])
                    X = self.step(self.x, self.t, h, self.mode)
                self.record(self.t + h, stage is not None or self.t + h >= limit)
                if h > 1e-3 * self.h:  # what is left of a jump is a large current for a very short time
                    self.size_i = max([self.size_i] + [abs(X[-1, k]) for k in self.network.current.values()])
                self.x, self.t = X[-1], self.t + h
                if stage is not None:
                    changes += 1
                    if changes > 20000:
                        raise ArithmeticError("the diodes change sides without end")
                    left = self.mode
                    self.enter_mode()
                    # Diodes at which nothing flows and nothing lies stay beyond their border by rounding.
                    self.slack = min(4 * self.slack, 1e-8) if self.mode == left else 1e-12
        self.record(self.stop, False)
        return np.array(self.found)


def sine(amplitude, omega, phase=0.0, offset=0.0):
    """A source as text and as a function."""
    return (f"{offset!r} + {amplitude!r}*sin({omega!r}*t + {phase!r})",
            lambda t: offset + amplitude * math.sin(omega * t + phase))


def steady(value):
    return f"{value!r}", lambda t: value
