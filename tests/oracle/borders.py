"""What reaches a border and stays, passes a narrow window, or divides by what comes to zero: in closed form."""
from math import ceil, cos, erf, exp, floor, log, pi, sin, sqrt

import numpy as np

from scenes import Scene, between as U, family, flat, one_of


def clipped(rate, low, high, start, times, parts=40_000):
    """x' = rate(t), held between two limits: by the trapezoid over fine parts whose ends are clipped."""
    grid = np.linspace(times[0], times[-1], parts + 1)
    steps = np.diff(grid) * (rate(grid[:-1]) + 4 * rate((grid[:-1] + grid[1:]) / 2) + rate(grid[1:])) / 6
    x = np.empty(parts + 1)
    x[0] = now = start
    for k, step in enumerate(steps):
        now = min(max(now + step, low), high)
        x[k + 1] = now
    return np.interp(times, grid, x)


@family
def limited_integrator(r):
    """An integral that stops at its limits and leaves them when its rate turns: equality is reached and kept."""
    A, B, w, v, tau = flat(r, .5, 3), flat(r, 0, 1), flat(r, .5, 3), flat(r, 3, 9), one_of(r, 1.0, 1.0, 1e-6, 1e4)
    low, high, start = flat(r, -1, -.2), flat(r, .2, 1), flat(r, -.1, .1)
    s = Scene(flat(r, 4, 15) * tau, 81).parameters(A=A, B=B, w=w, v=v, tau=tau, low=low, high=high).only_signals().outputs(x="x")
    s.signals(u="(A*sin(w*t/tau) + B*cos(v*t/tau))/tau")
    s.signals(x={"integral": one_of(r, "if(x >= high and u > 0 or x <= low and u < 0, 0, u)", "if(x >= high, min(u, 0), if(x <= low, max(u, 0), u))",
                                    "if(not (x < high), min(u, 0), if(not (x > low), max(u, 0), u))"), "initial": start})
    return s.computed(lambda: [[x] for x in clipped(lambda t: A * np.sin(w * t) + B * np.cos(v * t), low, high, start, np.array(s.times) / tau)])


@family
def full_tank(r):
    """A tank that overflows at its rim: `min(c.q, top) >= top`."""
    top, A, w, out = flat(r, .5, 2), flat(r, .5, 3), flat(r, .5, 3), flat(r, 0, .4)
    s = Scene(flat(r, 4, 15), 81).parameters(top=top, A=A, w=w, out=out).junctions("n").element("c", "C", capacitance=1)
    s.signals(u="A*sin(w*t)^2 - out", full=one_of(r, "min(c.q, top) >= top", "c.q >= top", "top - c.q <= 0"))
    s.element("in", "MSf", flow="u").element("spill", "MSf", flow="if(full, max(u, 0), 0)").element("ground", "MSf", flow="if(c.q <= 0, max(-u, 0), 0)")
    s.bonds("in>n n>c n>spill ground>n").outputs(q="c.q")
    return s.computed(lambda: [[x] for x in clipped(lambda t: A * np.sin(w * t)**2 - out, 0, top, 0, np.array(s.times))])


@family
def windows(r):
    """A state that runs at a steady pace passes narrow openings of several shapes."""
    pace, shape = flat(r, .3, 3) * one_of(r, 1, -1), one_of(r, "abs", "and", "sin", "bell", "floor", "root", "hat")
    width, at, k = U(r, 1e-8, .2), flat(r, 1, 8) * (1 if pace > 0 else -1), flat(r, 3, 300)
    stop = 10 / abs(pace)
    s = Scene(stop, 21).parameters(pace=pace, width=width, at=at, k=k).only_signals().outputs(y="y").signals(x={"integral": "pace"})
    law, whole = {
        "abs": ("if(abs(x - at) < width, 1/width, 0)", lambda x: min(max((x - at) / width, -1), 1)),
        "and": ("if(x > at - width and x < at + width, 1/width, 0)", lambda x: min(max((x - at) / width, -1), 1)),
        "bell": ("exp(-((x - at)/width)^2)/width", lambda x: sqrt(pi) / 2 * erf((x - at) / width)),
        "hat": ("max(0, 1 - abs(x - at)/width)/width", lambda x: (lambda z: z - z * abs(z) / 2)(min(max((x - at) / width, -1), 1))),
        "root": ("if(width^2 > (x - at)^2, sqrt(width^2 - (x - at)^2)/width^2, 0)",
                 lambda x: (lambda z: (z * sqrt(1 - z * z) + np.arcsin(z)) / 2)(min(max((x - at) / width, -1), 1))),
        "sin": ("if(sin(k*x) > 0.5, 1, 0)", None),
        "floor": ("mod(floor(k*x), 2)", None)}[shape]
    if shape == "sin":  # open for 2/3 pi in every 2 pi
        whole = lambda x: (floor(k * x / (2 * pi)) * 2 / 3 * pi + min(max(k * x % (2 * pi) - pi / 6, 0), 2 / 3 * pi)) / k
    if shape == "floor":
        whole = lambda x: (floor(k * x / 2) + max(k * x % 2 - 1, 0)) / k
    s.signals(y={"integral": f"pace*({law})"})
    return s.known(lambda t: [whole(pace * t) - whole(0)])


@family
def turning_points(r):
    """A window around the amplitude of an oscillation, which is reached only just, or only just not."""
    a, w, near = flat(r, .5, 2), flat(r, .5, 5), one_of(r, 1, -1) * U(r, 1e-6, 1e-2)
    s = Scene(flat(r, 5, 30) / w, 41).parameters(a=a, w=w, level=a * (1 - near)).junctions(ones="j").element("i", "I", inertance=1, initial={"f": a * w})
    s.element("c", "C", capacitance="1/w^2").bonds("j>i j>c").outputs(y="y").signals(y={"integral": "if(c.q > level, 1, 0)"})
    half = np.arccos(1 - near) if near > 0 else 0.0

    def row(t):
        turns, phase = divmod(w * t - pi / 2 + pi, 2 * pi)  # the middle of an opening at phase pi
        return [(turns * 2 * half + min(max(phase - pi + half, 0), 2 * half)) / w]
    return s.known(row)


@family
def removable(r):
    """Quotients that stay finite where their denominator passes zero."""
    pace, start, kind = flat(r, .3, 2), -flat(r, .5, 3), one_of(r, "sinc", "square", "root")
    s = Scene(flat(r, 3, 6), 31).parameters(pace=pace).only_signals().outputs(y="y").signals(x={"integral": "pace", "initial": start})
    law, whole = {"sinc": ("sin(x)/x", None), "square": ("(x^3 - x)/x", lambda x: x**3 / 3 - x), "root": ("1/(1 + sqrt(abs(x)))", None)}[kind]
    if kind == "sinc":
        whole = lambda x: sum((-1)**n * x**(2 * n + 1) / ((2 * n + 1) * np.prod(np.arange(1.0, 2 * n + 2))) for n in range(40))
    if kind == "root":
        whole = lambda x: (lambda z: 2 * (z - log(1 + z)) * (1 if x > 0 else -1))(sqrt(abs(x)))
    s.signals(y={"integral": f"pace*({law})"})
    return s.known(lambda t: [whole(start + pace * t) - whole(start)])


@family
def staircase(r):
    """floor, ceil, round and mod of a state that swings; their integral by the times at which it passes."""
    a, w, k, what = flat(r, .5, 4), flat(r, .5, 3), flat(r, .5, 6), one_of(r, "floor", "ceil", "round", "mod")
    s = Scene(flat(r, 2, 12), 41).parameters(a=a, w=w, k=k).only_signals().outputs(y="y")
    s.signals(x={"integral": "v", "initial": 0.123}, v={"integral": "-w^2*(x - 0.123)", "initial": "a*w"})
    s.signals(y={"integral": {"mod": "mod(k*x, 1)"}.get(what, f"{what}(k*x)")})
    f = {"floor": floor, "ceil": ceil, "round": lambda z: floor(z + .5), "mod": lambda z: z - floor(z)}[what]

    def answer():
        times, shift = s.times, .5 if what == "round" else 0.0
        passes = {0.0, *times}
        for n in range(floor(k * (.123 - a)) - 1, ceil(k * (.123 + a)) + 2):
            z = ((n - shift) / k - .123) / a
            if abs(z) < 1:
                for turn in range(int(s.stop * w / (2 * pi)) + 2):
                    passes |= {p for p in ((np.arcsin(z) + 2 * pi * turn) / w, (pi - np.arcsin(z) + 2 * pi * turn) / w) if 0 < p < s.stop}
        marks, rows, y = sorted(passes), {}, 0.0
        whole = lambda t: k * (.123 * t - a / w * cos(w * t))
        for p, q in zip(marks, [*marks[1:], None]):
            rows[p] = [y]
            if q is not None:
                z = k * (.123 + a * sin(w * (p + q) / 2))
                y += whole(q) - whole(p) - floor(z) * (q - p) if what == "mod" else f(z) * (q - p)
        return [rows[t] for t in times]
    return s.computed(answer)


@family
def steep_table(r):
    """A table with rows far nearer to each other than the rest, over a state that passes them."""
    n, steep = int(r.integers(3, 8)), U(r, 1e-7, 1e-2)
    x = np.sort(r.uniform(0, 10, n)).round(3)
    x = np.unique(np.concatenate([[-1, 12], x, x[:2] + steep]))
    y = r.uniform(-2, 2, len(x)).round(3)
    pace = flat(r, .3, 3)
    s = Scene(10 / pace, 41).parameters(pace=pace).only_signals().outputs(y="y").signals(x={"integral": "pace"}, y={"integral": "pace*table('d.csv', 'y', x)"})
    s.files["d.csv"] = "x,y\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(x.tolist(), y.tolist()))
    areas = np.concatenate([[0], np.cumsum(np.diff(x) * (y[1:] + y[:-1]) / 2)])

    def whole(z):
        i = min(int(np.searchsorted(x, z, "right")) - 1, len(x) - 2)
        slope = (y[i + 1] - y[i]) / (x[i + 1] - x[i])
        return areas[i] + (z - x[i]) * (y[i] + slope * (z - x[i]) / 2)
    return s.known(lambda t: [whole(pace * t) - whole(0)])


@family
def shrinks_and_grows(r):
    """Linear growth whose sign changes with time: lost in rounding of the tolerance unless that follows."""
    k, T, kind = U(r, 2, 60), flat(r, .5, 1.5), one_of(r, "line", "sine", "steps")
    rate, whole = {"line": ("k*(t - T)", lambda t: k * (t * t / 2 - T * t)), "sine": ("-k*cos(3*t/T)", lambda t: -k * T / 3 * sin(3 * t / T)),
                   "steps": ("if(t < T, -k, k)", lambda t: k * (abs(t - T) - T))}[kind]
    s = Scene(2 * T, 41).parameters(k=k, T=T).only_signals().signals(x={"integral": f"x*({rate})", "initial": 1}).outputs(x="x", log="log(x)")
    return s.known(lambda t: [exp(whole(t)), whole(t)])


@family
def narrow_pulses_of_time(r):
    """Smooth and sharp pulses in a period, of which all count."""
    T, width, RC, n = flat(r, .5, 2), U(r, 1e-5, .05), U(r, .2, 5), int(r.integers(5, 60))
    s = Scene(n * T, 41).parameters(T=T, width=width * T, RC=RC).junctions(ones="j").element("r", "R", resistance="RC").element("c", "C", capacitance=1)
    s.element("u", "Se", effort="exp(-((mod(t, T) - T/2)/width)^2)/width").bonds("u>j j>r j>c").outputs(v="c.e")
    area, late = sqrt(pi), width * T

    def row(t):
        k, z = divmod(t, T)
        decayed = sum(exp(-(t - (i + .5) * T) / RC) for i in range(int(k)))
        v = area / RC * decayed * exp((late / RC)**2 / 4)
        here = z - T / 2
        if abs(here) < 8 * late:
            v += area / (2 * RC) * exp(-here / RC + (late / RC)**2 / 4) * (1 + erf(here / late - late / (2 * RC)))
        elif here > 0:
            v += area / RC * exp(-here / RC) * exp((late / RC)**2 / 4)
        return [v]
    return s.known(row)
