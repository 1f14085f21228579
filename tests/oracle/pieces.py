"""Rates made at random of pieces: conditions, kinks, steps, floors, nests of them, over states and time."""
import math
import re

import numpy as np

from scenes import Scene, between as U, family, flat, one_of

WORDS = {"sin": math.sin, "cos": math.cos, "tanh": math.tanh, "exp": math.exp, "sqrt": math.sqrt, "abs": abs, "min": min, "max": max, "floor": math.floor,
         "ceil": math.ceil, "mod": lambda a, b: a - b * math.floor(a / b), "sign": lambda a: (a > 0) - (a < 0), "step": lambda a: a >= 0,
         "if_": lambda c, a, b: a if c else b}
MOST = 300_000  # evaluations: rates that slide along a border take any number of them


def code_of(text):
    """The same expression in Python. Both sides of an `if_` are evaluated: they are made to have a value everywhere."""
    return compile(re.sub(r"\bif\(", "if_(", text).replace("^", "**"), text, "eval")


def followed(states, rates, start, times, known=()):
    """By an explicit method that meets jumps by its error test: two runs with other steps must agree."""
    from scipy.integrate import solve_ivp
    code, names, count = [code_of(rate) for rate in rates], {**WORDS, **dict(known)}, [0]

    def right(t, y):
        count[0] += 1
        if count[0] > MOST:
            raise ArithmeticError("slides along a border")
        names.update(zip(states, y.tolist()))
        names["t"] = t
        return [eval(c, names) for c in code]  # noqa: S307
    found = []
    for steps, tolerance in ((1500, 1e-9), (2311, 1e-10)):
        count[0] = 0
        done = solve_ivp(right, (times[0], times[-1]), start, method="DOP853", rtol=tolerance, atol=tolerance * 1e-2, t_eval=times,
                         max_step=(times[-1] - times[0]) / steps)
        if done.status < 0:
            raise ArithmeticError(done.message)
        found.append(done.y.T)
    apart = np.abs(found[0] - found[1]).max(axis=0) / np.maximum(np.ptp(found[1], axis=0), 1e-9)
    if apart.max() > 2e-5:
        raise ArithmeticError(f"two references are {apart.max():.1e} of a range apart")
    return found[1]


class Pieces:
    """Bounded expressions of states and time, deeper ones from shallower ones."""

    def __init__(self, random, states, smooth=False):
        self.random, self.states, self.smooth = random, states, smooth

    def number(self, low=.2, high=3.0):
        return f"{flat(self.random, low, high):.3g}"

    def line(self):
        """A linear function of some of it, of order 1."""
        x = one_of(self.random, *self.states, "t" if self.random.uniform() < .3 else self.states[0])
        if x == "t":
            return f"sin({self.number()}*t + {self.number(0, 6)})"
        return one_of(self.random, x, f"({x} - {self.number(-1, 1)})", f"{self.number(.5, 2)}*{x}", f"({x} + 0.5*sin({self.number()}*t))")

    def condition(self, depth):
        a = f"{self.value(depth - 1)} {one_of(self.random, '>', '<', '>=', '<=')} {self.number(-.8, .8)}"
        if self.random.uniform() < .25:
            b = f"{self.value(depth - 1)} {one_of(self.random, '>', '<')} {self.number(-.5, .5)}"
            return f"({a} {one_of(self.random, 'and', 'or')} {b})"
        return f"(not {a})" if self.random.uniform() < .1 else a

    def value(self, depth):
        if depth <= 0:
            return self.line()
        a, b = (lambda: self.value(depth - 1)), (lambda: self.value(depth - int(self.random.integers(1, 3))))
        kinks = [lambda: f"min({a()}, {b()})", lambda: f"max({a()}, {b()})", lambda: f"abs({a()})", lambda: f"min(max({a()}, -{self.number()}), {self.number()})",
                 lambda: f"max({a()}, {self.number(-1, 1)})"]
        smooth = [lambda: f"tanh({self.number(1, 20)}*{a()})", lambda: f"sin({self.number(1, 6)}*{a()})", lambda: f"exp(-({self.number(1, 30)}*{a()})^2)",
                  lambda: f"{a()}/(1 + ({b()})^2)", lambda: f"({a()} - {b()})", lambda: f"sqrt(0.01 + ({a()})^2)"]
        jumps = [lambda: f"if({self.condition(depth)}, {a()}, {b()})", lambda: f"floor({self.number(1, 5)}*{a()})/4", lambda: f"ceil({self.number(1, 4)}*{a()})/4",
                 lambda: f"0.5*sign({a()})", lambda: f"step({a()} - {self.number(-.5, .5)})", lambda: f"mod({a()}, {self.number(.3, 2)})",
                 lambda: f"if({self.condition(depth)}, {self.number(-1, 1)}, {a()})"]
        return one_of(self.random, *smooth, *kinks, *([] if self.smooth else jumps))()


def made(r, smooth):
    n = int(r.integers(1, 4))
    states = [f"x{i}" for i in range(n)]
    pieces = Pieces(r, states, smooth)
    rates = []
    for i, x in enumerate(states):
        others = states[(i + 1) % n]
        swing = f" {one_of(r, '+', '-')} {pieces.number(.3, 3)}*{others}" if n > 1 else f" + sin({pieces.number()}*t)"
        bounded = " + ".join(f"{pieces.number(.3, 2)}*{one_of(r, 'tanh', 'sin', 'cos')}({pieces.value(int(r.integers(1, 4)))})" if r.uniform() < .3 else
                             f"min(max({pieces.value(int(r.integers(1, 4)))}, -3), 3)" for _ in range(int(r.integers(1, 3))))
        rates.append(f"-{pieces.number(.1, 1.5)}*{x}{swing} + {bounded}")
    if n > 1:  # pairs that swing keep their energy
        rates[1] = rates[1].replace(" + ", " - ", 1) if " + " in rates[0][:30] else rates[1]
    start = [flat(r, -1, 1) for _ in states]
    s = Scene(flat(r, 2, 12), 61).only_signals()
    for x, rate, x0 in zip(states, rates, start):
        s.signals(**{x: {"integral": rate, "initial": x0}}).outputs(**{x: x})
    s.answer = lambda: followed(states, rates, start, s.times)
    return s


@family
def pieces_with_jumps(r):
    return made(r, False)


@family
def pieces_with_kinks(r):
    return made(r, True)
