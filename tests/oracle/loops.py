"""Algebraic loops with kinks, implicit laws, gyrator rings, dependent stores and leaks."""
from itertools import product
from math import copysign, exp, sin, sqrt

import numpy as np

from scenes import Scene, between as U, family, flat, one_of


def root_of(residual, low, high):
    """Of a rising function, by bisection."""
    while residual(low) > 0:
        low -= high - low
    while residual(high) < 0:
        high += high - low
    for _ in range(200):
        middle = (low + high) / 2
        if not low < middle < high:
            break
        low, high = (middle, high) if residual(middle) < 0 else (low, middle)
    return (low + high) / 2


def rising_law(r):
    """(law of an R, its flow by its effort): strictly rising, with a kink or a bend."""
    a, b, c = U(r, .05, 20), U(r, .05, 20), flat(r, -1, 1)
    kind = one_of(r, "two", "two_e", "shifted", "square", "cubic", "sinh", "max", "abs", "root", "implicit", "three")
    if kind == "two":
        return f"f = if(e > 0, e*{a}, e*{b})", lambda e: e * (a if e > 0 else b)
    if kind == "two_e":
        return f"e = if(f > 0, f*{a}, f*{b})", lambda e: e / (a if e > 0 else b)
    if kind == "shifted":
        return f"f = {b}*e + {a}*max(e - {abs(c)}, 0)", lambda e: b * e + a * max(e - abs(c), 0)
    if kind == "square":
        return f"e = {a}*f*abs(f) + {b}*f", lambda e: copysign((sqrt(b * b + 4 * a * abs(e)) - b) / (2 * a), e)
    if kind == "cubic":
        return f"f = {a}*e^3 + {b}*e", lambda e: a * e**3 + b * e
    if kind == "sinh":
        return f"e = {a}*asinh(f/{b})", lambda e: b * np.sinh(min(max(e / a, -300), 300))
    if kind == "max":
        return f"f = max({a}*e, {b}*e)", lambda e: max(a * e, b * e)
    if kind == "abs":
        return f"f = {a + b}*e + {a}*abs(e)", lambda e: (a + b) * e + a * abs(e)
    if kind == "root":
        return f"f = {a}*sign(e)*sqrt(abs(e)) + {b}*e", lambda e: a * copysign(sqrt(abs(e)), e) + b * e
    if kind == "implicit":
        return f"0 = f + {a}*f^3 - {b}*e", lambda e: root_of(lambda f: f + a * f**3 - b * e, -1 - abs(b * e), 1 + abs(b * e))
    return (f"f = if(e > 1, {a}*(e - 1) + {b}, if(e < -1, {a}*(e + 1) - {b}, {b}*e))",
            lambda e: a * (e - 1) + b if e > 1 else a * (e + 1) - b if e < -1 else b * e)


def growth(A, t):
    """exp(A t) of a matrix whose entries beside the diagonal are not negative: all terms are positive, so none cancels."""
    A = A.astype(np.longdouble)
    rate = -A.diagonal().min()
    halvings = max(0, int(np.ceil(np.log2(float(rate * t) + 1e-300))))
    h = t / 2.0**halvings
    part, term = np.eye(len(A), dtype=np.longdouble), np.eye(len(A), dtype=np.longdouble)
    for k in range(1, 40):
        term = term @ (A + rate * np.eye(len(A))) * h / k
        part = part + term
    part = part * np.exp(-rate * h)
    for _ in range(halvings):
        part = part @ part
    return part


def rooted_law(r):
    """(law of an R, its flow by its effort): rising, with a slope without bound at 0, in one of several spellings."""
    a, b, g = U(r, .1, 10), U(r, .1, 10), one_of(r, 0, U(r, .01, 5))
    n = one_of(r, .5, .5, 1 / 3, .57, .8)
    root, size = ("sqrt({})", "sqrt(abs(e))") if n == .5 else (f"({{}})^{n}", f"abs(e)^{n}")
    above, below = root.format("e"), root.format("-e")
    linear = f" + {g}*e" if g else ""
    kind = one_of(r, "sign", "parts", "ways", "max", "way", "cbrt")
    if kind == "sign":
        return f"f = {a}*sign(e)*{size}{linear}", lambda e: a * copysign(abs(e)**n, e) + g * e
    if kind == "parts":
        return f"f = if(e > 0, {a}*{above}, -{a}*{below}){linear}", lambda e: a * copysign(abs(e)**n, e) + g * e
    if kind == "ways":
        return f"f = if(e >= 0, {a}*{above}, -{b}*{below}){linear}", lambda e: (a if e > 0 else b) * copysign(abs(e)**n, e) + g * e
    if kind == "max":
        return (f"f = {a}*{root.format('max(e, 0)')} - {b}*{root.format('max(-e, 0)')}{linear}",
                lambda e: (a if e > 0 else b) * copysign(abs(e)**n, e) + g * e)
    if kind == "way":
        return f"f = {a}*{root.format('max(e, 0)')} + {b}*e", lambda e: a * max(e, 0)**n + b * e
    return f"f = {a}*cbrt(e){linear}", lambda e: a * float(np.cbrt(e)) + g * e


def in_series(r, laws):
    """Two rising laws side by side, in series with a third, between a sine and a capacitor: a loop at every instant."""
    V, w, C, G = flat(r, .5, 10), flat(r, .5, 5), U(r, .1, 5), U(r, .05, 2)
    s = Scene(flat(r, 3, 12), 61).parameters(V=V, w=w, C=C, G=G).junctions("m n", "ja jb jc").element("u", "Se", effort="V*sin(w*t)")
    for name, (law, _) in zip("abc", laws):
        s.element("r" + name, "R", law=law)
    s.element("c", "C", capacitance="C").element("leak", "R", resistance="1/G")
    s.bonds("u>jc jc>rc jc>m m>ja m>jb ja>ra jb>rb ja>n jb>n n>c n>leak").outputs(v="c.e", m="m.e", i="rc.f")
    a, b, c = (law for _, law in laws)

    def middle(t, v):
        u = V * sin(w * t)
        return root_of(lambda m: a(m - v) + b(m - v) - c(u - m), min(u, v) - 1e-9, max(u, v) + 1e-9)

    def row(t, y):
        m = middle(t, y[0])
        return [y[0], m, c(V * sin(w * t) - m)]
    return s.solved(lambda t, y: [(a(middle(t, y[0]) - y[0]) + b(middle(t, y[0]) - y[0]) - G * y[0]) / C], [0], row, stiff=False, relative=1e-9, absolute=1e-11)


@family
def parallel_in_series(r):
    return in_series(r, [rising_law(r) for _ in range(3)])


@family
def roots_in_series(r):
    return in_series(r, [rooted_law(r) for _ in range(3)])


ALL_SIDES = list(product((False, True), repeat=4))


@family
def bridge_of_two_slopes(r):
    """A bridge of four two-slope diodes behind a source with a resistance; the load is R and C."""
    on, off, Rs, R, C, V, w = U(r, 1e-3, 1), U(r, 1e2, 1e6), U(r, .01, 2), U(r, 5, 500), U(r, 1e-3, 1), flat(r, 1, 50), flat(r, .5, 5)
    s = Scene(flat(r, 5, 15), 61).parameters(on=on, off=off, Rs=Rs, R=R, C=C, V=V, w=w)
    s.junctions("a b p m", "ju j1 j2 j3 j4").element("u", "Se", effort="V*sin(w*t)").element("rs", "R", resistance="Rs")
    for k in "1234":
        s.element("d" + k, "R", law="f = if(e > 0, e/on, e/off)")
    s.element("c", "C", capacitance="C").element("load", "R", resistance="R").junctions("top", "across")
    # a - d1 - p, b - d2 - p, m - d3 - a, m - d4 - b; the load from p to m
    s.bonds("b>ju u>ju ju>rs ju>a a>j1 j1>d1 j1>p b>j2 j2>d2 j2>p m>j3 j3>d3 j3>a m>j4 j4>d4 j4>b p>across across>top across>m top>c top>load")
    s.outputs(v="c.e", i="rs.f")
    sides = {"now": (False,) * 4}
    slope = lambda conducts: 1 / on if conducts else 1 / off

    def current(t, v):
        """(from the source, into the load): linear for the sides that all four diodes agree with. Nodes a = x, b = 0, m = y, p = y + v."""
        u = V * sin(w * t)
        for now in (sides["now"], *ALL_SIDES):
            c1, c2, c3, c4 = map(slope, now)
            # what p gets is what m gives; what a gets through Rs is what it gives
            A = ((c1 + c3, -(c1 + c2 + c3 + c4)), (1 / Rs + c1 + c3, -(c1 + c3)))
            right = ((c1 + c2) * v, u / Rs + c1 * v)
            D = A[0][0] * A[1][1] - A[0][1] * A[1][0]
            x, y = (right[0] * A[1][1] - A[0][1] * right[1]) / D, (A[0][0] * right[1] - A[1][0] * right[0]) / D
            over = x - y - v, -y - v, y - x, y
            if all((e >= -1e-12) if side else (e <= 1e-12) for e, side in zip(over, now)):
                sides["now"] = now
                return (u - x) / Rs, c1 * over[0] + c2 * over[1]
        raise ArithmeticError("no sides of the diodes agree")
    return s.solved(lambda t, y: [(current(t, y[0])[1] - y[0] / R) / C], [0], lambda t, y: [y[0], current(t, y[0])[0]], stiff=True, relative=1e-11, absolute=1e-13,
                    longest=.05)


@family
def implicit_diode(r):
    """A diode with its series resistance by an implicit law, a half wave into R and C."""
    Is, Vt, Rs, R, C, V, w = U(r, 1e-15, 1e-6), .02585 * flat(r, 1, 2), U(r, .01, 10), U(r, 50, 5e3), U(r, 1e-6, 1e-3), flat(r, .3, 30), U(r, 50, 1e3)
    s = Scene(flat(r, 1, 5) * 6.28 / w, 81).parameters(Is=Is, Vt=Vt, Rs=Rs, R=R, C=C, V=V, w=w).junctions("n", "j").element("u", "Se", effort="V*sin(w*t)")
    s.element("d", "R", law="0 = f - Is*(exp((e - Rs*f)/Vt) - 1)").element("c", "C", capacitance="C").element("load", "R", resistance="R")
    s.bonds("u>j j>d j>n n>c n>load").outputs(v="c.e", i="d.f")

    def i(e):
        if e <= 0:
            return root_of(lambda f: f - Is * (exp((e - Rs * f) / Vt) - 1), -Is, 0.0)
        # by the voltage of the junction, on a logarithmic scale where it conducts
        x = root_of(lambda x: x + Rs * Is * (exp(min(x / Vt, 700)) - 1) - e, 0.0, e)
        return Is * (exp(x / Vt) - 1)
    return s.solved(lambda t, y: [(i(V * sin(w * t) - y[0]) - y[0] / R) / C], [0], lambda t, y: [y[0], i(V * sin(w * t) - y[0])], stiff=True, relative=1e-11,
                    absolute=1e-10, longest=.02 / w)


@family
def leaks(r):
    """Capacitors at nodes between resistances of 1e-2 to 1e18: linear, by the matrix exponential."""
    n, C = int(r.integers(2, 5)), 1e-6
    R = [U(r, 1e-2, 1e4) if r.uniform() < .6 else U(r, 1e9, 1e18) for _ in range(n)]
    leak = [U(r, 1e9, 1e18) for _ in range(n)]
    V, stop = one_of(r, 0, 0, 5), U(r, 1e-4, 100)
    s = Scene(stop, 41).parameters(V=V).element("u", "Se", effort="V")
    start = [one_of(r, 0, 0, 3.3) if V else 3.3 for _ in range(n)]
    for k in range(n):
        s.junctions(f"n{k}", f"j{k}").element(f"r{k}", "R", resistance=R[k]).element(f"c{k}", "C", capacitance=C * (k + 1), initial={"e": start[k]})
        s.element(f"l{k}", "R", resistance=leak[k]).bonds(f"{'u' if k == 0 else f'n{k - 1}'}>j{k} j{k}>r{k} j{k}>n{k} n{k}>c{k} n{k}>l{k}").outputs(**{f"v{k}": f"c{k}.e"})
    A = np.zeros((n + 1, n + 1))  # the last one is the source, whose voltage stays
    for k in range(n):
        before = n if k == 0 else k - 1
        for at, other in ((k, before), (before, k)):
            A[at, other] += 1 / R[k]
            A[at, at] -= 1 / R[k]
        A[k, k] -= 1 / leak[k]
    A[:n] /= C * np.arange(1, n + 1)[:, None]
    A[n] = 0
    return s.computed(lambda: [(growth(A, t) @ np.array([*start, V], np.longdouble))[:n].astype(float) for t in s.times])


@family
def fast_and_damped(r):
    """A slow swing beside a weakly damped fast one that is let go at the start; by the modes of each."""
    fast, zf, slow, zs, x0 = U(r, 1e2, 1e4), U(r, 1e-4, .3), flat(r, .5, 3), flat(r, 0, .3), flat(r, .1, 1)
    s = Scene(flat(r, 2, 10), 61).parameters(fast=fast, zf=zf, slow=slow, zs=zs).junctions(ones="a b").outputs(x="kb.q", late="late")
    s.element("ia", "I", inertance=1).element("ka", "C", capacitance="1/fast^2", initial={"q": 1 / fast}).element("da", "R", resistance="2*zf*fast")
    s.element("ib", "I", inertance=1).element("kb", "C", capacitance="1/slow^2", initial={"q": x0}).element("db", "R", resistance="2*zs*slow")
    s.element("push", "MSe", effort="ka.q*fast").bonds("a>ia a>ka a>da b>ib b>kb b>db push>b").signals(late={"integral": "ka.q*fast - 0.3*late"})
    # exact by a matrix of five states
    A = np.array([[0, 1, 0, 0, 0], [-fast**2, -2 * zf * fast, 0, 0, 0], [0, 0, 0, 1, 0], [fast, 0, -slow**2, -2 * zs * slow, 0], [fast, 0, 0, 0, -.3]])

    def answer():
        poles, modes = np.linalg.eig(A)
        shares = np.linalg.solve(modes, np.array([1 / fast, 0, x0, 0, 0], complex))
        return [[*((modes @ (np.exp(poles * t) * shares)).real[[2, 4]])] for t in s.times]
    return s.computed(answer)


@family
def gyrators(r):
    """A ring of gyrators and resistances between stores, by the matrix of its equations."""
    n = int(r.integers(3, 6))
    g = [U(r, .2, 5) * one_of(r, 1, -1) for _ in range(n)]
    C, R, start = [U(r, .2, 5) for _ in range(n)], [U(r, .5, 50) for _ in range(n)], [flat(r, -1, 1) for _ in range(n)]
    s = Scene(flat(r, 3, 15), 61)
    for k in range(n):
        s.junctions(f"n{k}").element(f"c{k}", "C", capacitance=C[k], initial={"e": start[k]}).element(f"r{k}", "R", resistance=R[k])
        s.element(f"g{k}", "GY", modulus=g[k]).bonds(f"n{k}>c{k} n{k}>r{k} n{k}>g{k} g{k}>n{(k + 1) % n}").outputs(**{f"v{k}": f"c{k}.e"})
    A = np.zeros((n, n))
    for k in range(n):  # e1 = g f2, e2 = g f1
        to = (k + 1) % n
        A[k, to] -= 1 / g[k]
        A[to, k] += 1 / g[k]
        A[k, k] -= 1 / R[k]
    A /= np.array(C)[:, None]

    def answer():
        poles, modes = np.linalg.eig(A)
        shares = np.linalg.solve(modes, np.array(start, complex))
        return [(modes @ (np.exp(poles * t) * shares)).real for t in s.times]
    return s.computed(answer)


@family
def tied_stores(r):
    """Two capacitors side by side, one with a law that bends, and a mass behind a lever of changing length: dependent stores."""
    a, C, R, V, w = U(r, .1, 5), U(r, .1, 5), U(r, .1, 5), flat(r, .5, 5), flat(r, .5, 4)
    law, q = one_of(r, ("e = q + a*q^3", None), ("e = a*asinh(q)", lambda e: np.sinh(e / a)), ("q = a*e + sign(e)*e^2", None), ("e = if(q > 0, q, a*q)", lambda e: e if e > 0 else e / a))
    if law.startswith("q"):
        q = lambda e: a * e + copysign(e * e, e)
    if "q^3" in law:
        q = lambda e: root_of(lambda x: x + a * x**3 - e, -1 - abs(e), 1 + abs(e))
    s = Scene(flat(r, 3, 12), 61).parameters(a=a, C=C, R=R, V=V, w=w).junctions("n", "j").element("u", "Se", effort="V*sin(w*t)").element("r", "R", resistance="R")
    s.element("c1", "C", law=law).element("c2", "C", capacitance="C").bonds("u>j j>r j>n n>c1 n>c2").outputs(v="c2.e", q="c1.q")
    volts = lambda Q: root_of(lambda e: q(e) + C * e - Q, -1 - abs(Q) / C, 1 + abs(Q) / C)
    return s.solved(lambda t, y: [(V * sin(w * t) - volts(y[0])) / R], [0], lambda t, y: [volts(y[0]), q(volts(y[0]))], relative=1e-10)


@family
def sliding_mass_on_an_arm(r):
    """A mass that slides on a rotating arm: an IC field of one energy."""
    J, m, k, L, T, b = U(r, .2, 2), U(r, .1, 2), U(r, 5, 50), flat(r, .2, 1), flat(r, .1, 2), flat(r, 0, .5)
    w0 = flat(r, -3, 3)
    s = Scene(flat(r, 3, 10), 81).parameters(J=J, m=m, k=k, L=L, T=T, b=b).junctions(ones="turn slide").element("motor", "Se", effort="T*sin(t)")
    s.element("arm", "IC", ports={"h": "p", "x": "q", "p": "p"}, energy="h.p^2/(2*(J + m*(L + x.q)^2)) + p.p^2/(2*m) + k*x.q^2/2", initial={"h.p": w0 * (J + m * L * L)})
    s.element("r", "R", resistance="b").bonds("motor>turn turn>arm.h slide>arm.x slide>arm.p slide>r")

    def rates(t, y):
        h, x, p = y
        I = J + m * (L + x)**2
        return [T * sin(t), p / m, h * h / I**2 * m * (L + x) - k * x - b * p / m]
    return s.outputs(w="arm.h.f", x="arm.x.q").solved(rates, [w0 * (J + m * L * L), 0, 0], lambda t, y: [y[0] / (J + m * (L + y[1])**2), y[1]])
