"""Tanks, orifices, valves and cylinders: roots whose slopes are infinite at rest."""
from math import copysign, sin, sqrt

import numpy as np

from scenes import Scene, between as U, family, flat, one_of


def root(e):
    return copysign(sqrt(abs(e)), e)


def tank(s, outflow, inflow):
    """A tank of area A with an inflow and an outlet: the elements n, c, u, out."""
    s.junctions("n").element("c", "C", law="e = q/A", initial={"q": "A*start"}).element("u", "Sf", flow=inflow).element("out", "R", law="f = " + outflow)
    return s.bonds("u>n n>c n>out").outputs(h="c.e", f="out.f")


@family
def weir(r):
    """Starts below or above the crest."""
    A, h0, k, q, a, w, start = flat(r, .5, 5), flat(r, .5, 1.5), U(r, .2, 5), flat(r, .2, 1), flat(r, 0, 1), flat(r, .2, 2), flat(r, 0, 2)
    power = one_of(r, .5, 1, 1.5, 2.5)
    s = Scene(flat(r, 5, 20), 101).parameters(A=A, h0=h0, k=k, q0=q, a=a, w=w, start=start, power=power)
    tank(s, "if(e > h0, k*(e - h0)^power, 0)", "q0*(1 + a*sin(w*t))")
    f = lambda h: k * (h - h0)**power if h > h0 else 0.0
    return s.solved(lambda t, y: [(q * (1 + a * sin(w * t)) - f(y[0])) / A], [start], lambda t, y: [y[0], f(y[0])],
                    borders=[lambda t, y: y[0] - h0], stiff=power < 1)


@family
def starts_at_its_crest(r):
    """An outlet whose law begins where the run starts, with inflows that begin at 0 or not; all ways to write it."""
    A, k, h0, t0 = U(r, .1, 10), U(r, .1, 5), one_of(r, 0, 0, 1, 3.7), one_of(r, 0, 0, 5, -3)
    a, w, power = flat(r, .3, 2) * one_of(r, 1, -1), flat(r, .5, 4), one_of(r, .5, .5, 1.5, .7, 1)
    inflow, rate = one_of(r, ("a", lambda t: a), ("a*(t - t0)", lambda t: a * t), ("a*sin(w*(t - t0))", lambda t: a * sin(w * t)))
    d = "(e - h0)" if h0 else "e"
    odd, one_sided = (lambda x: copysign(abs(x)**power, x)), (lambda x: max(x, 0)**power)
    law, f = one_of(r, (f"sign({d})*abs({d})^power", odd), (f"if({d} > 0, {d}^power, -(-{d})^power)", odd),
                    (f"if({d} >= 0, {d}^power, 0)", one_sided), (f"max({d}, 0)^power", one_sided),
                    (f"sign({d})*min(abs({d}), 0.1)", lambda x: copysign(min(abs(x), .1), x)))
    s = Scene(t0 + flat(r, 1, 10), 81, t0).parameters(A=A, k=k, h0=h0, t0=t0, a=a, w=w, power=power, start=h0)
    tank(s, "k*(" + law + ")", inflow)
    # near 0 a chord: SciPy's slopes by differences
    near = lambda x: f(x) if abs(x) > 1e-14 else f(copysign(1e-14, x)) * abs(x) / 1e-14
    return s.solved(lambda t, y: [(rate(t - t0) - k * near(y[0])) / A], [0], lambda t, y: [h0 + y[0], k * f(y[0])], stiff=True, absolute=1e-15,
                    relative=1e-9)


@family
def two_tanks(r):
    """Level against level through an orifice, in either direction."""
    A1, A2, k, ko, q, w, h1, h2 = U(r, .3, 3), U(r, .3, 3), U(r, .2, 5), U(r, .1, 1), flat(r, .1, 1), flat(r, .3, 4), flat(r, 0, 2), flat(r, 0, 2)
    s = Scene(flat(r, 5, 20), 101).parameters(A1=A1, A2=A2, k=k, ko=ko, q=q, w=w).junctions("n1 n2", "j")
    s.element("u", "Sf", flow="q*(1 + sin(w*t))").element("c1", "C", capacitance="A1", initial={"e": h1}).element("c2", "C", capacitance="A2", initial={"e": h2})
    law = one_of(r, "f = k*sign(e)*sqrt(abs(e))", "f = if(e > 0, k*sqrt(e), -k*sqrt(-e))", "e = f*abs(f)/k^2")
    s.element("pipe", "R", law=law).element("out", "R", law="f = ko*sqrt(max(e, 0))").bonds("u>n1 n1>c1 n1>j j>pipe j>n2 n2>c2 n2>out")

    def rates(t, y):
        f = k * root(y[0] - y[1])
        return [(q * (1 + sin(w * t)) - f) / A1, (f - ko * sqrt(max(y[1], 0))) / A2]
    return s.outputs(h1="c1.e", h2="c2.e").solved(rates, [h1, h2], stiff=True, borders=[lambda t, y: y[0] - y[1]])


@family
def runs_empty(r):
    """Torricelli's tank, empty before the end."""
    A, k, h = U(r, .1, 10), U(r, .1, 5), U(r, .01, 10)
    empty = 2 * A * sqrt(h) / k
    s = Scene(empty * flat(r, .9, 3), 61).parameters(A=A, k=k, start=h)
    tank(s, one_of(r, "k*sqrt(max(e, 0))", "k*sign(e)*sqrt(abs(e))", "if(e > 0, k*sqrt(e), 0)"), "0")
    return s.known(lambda t: [h * max(1 - t / empty, 0)**2, k * sqrt(h) * max(1 - t / empty, 0)])


@family
def siphon(r):
    """Fills at a steady rate; the siphon starts at one level and breaks at a lower one."""
    A, k, q, low, high = U(r, .3, 3), U(r, 1, 5), flat(r, .05, .3), flat(r, .1, .4), flat(r, .6, 1.5)
    s = Scene(flat(r, 2, 6) * A * high / q, 101).parameters(A=A, k=k, q=q, low=low, high=high)
    s.signals(flows={"set": "c.e > high", "reset": "c.e < low"}).junctions("n").element("c", "C", capacitance="A").element("u", "Sf", flow="q")
    s.element("out", "MR", law="f = if(flows, k*sqrt(max(e, 0)), 0)").bonds("u>n n>c n>out").outputs(h="c.e")
    on = {"now": False}

    def switch(value):
        def act(t, y):
            on["now"] = value
        return act
    return s.solved(lambda t, y: [(q - (k * sqrt(max(y[0], 0)) if on["now"] else 0)) / A], [0], borders=[
        (lambda t, y: -1 if on["now"] else y[0] - high, switch(True)), (lambda t, y: low - y[0] if on["now"] else -1, switch(False))])


@family
def relief_valve(r):
    """Opens at a pressure with a jump of its flow, and is held there where neither side can last."""
    q, k, h, K, w = flat(r, .5, 2), flat(r, .2, 1), flat(r, .5, 2), flat(r, 1, 4), flat(r, .3, 2)
    s = Scene(flat(r, 3, 10), 71).parameters(q=q, k=k, h=h, K=K, w=w).junctions("n").element("u", "Sf", flow="q*(1 + sin(w*t))").element("c", "C", capacitance=1)
    condition = one_of(r, "e > h", "max(e, 0.1) > h", "min(e, 5) >= h", "abs(e - h) > 0 and e >= h")
    s.element("out", "R", law="f = k*ssqrt(e, 0.01)").element("relief", "R", law=f"f = if({condition}, K*(e - 0.9*h), 0)").bonds("u>n n>c n>out n>relief")
    mode = {"now": "shut"}
    shut = lambda t, x: q * (1 + sin(w * t)) - k * x / (x * x + 1e-4)**.25
    wide = lambda t, x: shut(t, x) - K * (x - .9 * h)

    def to(choose):
        def act(t, y):
            mode["now"] = choose(t)
            return [h]
        return act

    def rates(t, y):
        return [0.0 if mode["now"] == "held" else (wide if mode["now"] == "open" else shut)(t, y[0])]

    def border(side, value, choose):
        return lambda t, y: value(t, y[0]) if mode["now"] == side else -1, to(choose)
    return s.outputs(h="c.e").solved(rates, [0], borders=[
        border("shut", lambda t, x: x - h, lambda t: "open" if wide(t, h) > 0 else "held"),
        border("open", lambda t, x: h - x, lambda t: "shut" if shut(t, h) < 0 else "held"),
        border("held", lambda t, x: wide(t, h), lambda t: "open"), border("held", lambda t, x: -shut(t, h), lambda t: "shut")])


@family
def servo_valve(r):
    """A cylinder between four orifices that a sine opens and shuts."""
    K, ps, A, C, m, b, X, w = U(r, .005, .05), flat(r, 50, 200), flat(r, .5, 2), U(r, 1e-4, 1e-2), U(r, .1, 5), flat(r, .1, 5), flat(r, .2, 1), flat(r, 1, 8)
    s = Scene(flat(r, 1, 4), 101).parameters(K=K, ps=ps, A=A, C=C, m=m, b=b, X=X, w=w).signals(x="X*sin(w*t)").junctions("sn tn na nb", "jpa jta jpb jtb j")
    s.element("supply", "Se", effort="ps").element("return", "Se", effort=0).bonds("supply>sn return>tn")
    for c, way in (("a", "x"), ("b", "-x")):
        s.element("c" + c, "C", capacitance="C", initial={"e": "ps/2"})
        s.element("rp" + c, "R", law=f"f = K*max({way}, 0)*sign(e)*sqrt(abs(e))").element("rt" + c, "R", law=f"f = K*max(-({way}), 0)*sign(e)*sqrt(abs(e))")
        s.bonds(f"n{c}>c{c} sn>jp{c} jp{c}>rp{c} jp{c}>n{c} n{c}>jt{c} jt{c}>rt{c} jt{c}>tn")
    s.element("ta", "TF", modulus="1/A").element("tb", "TF", modulus="A").element("mass", "I", inertance="m").element("r", "R", resistance="b")

    def rates(t, y):
        x, (a, c, v) = X * sin(w * t), y
        up, down = K * max(x, 0), K * max(-x, 0)
        return [(up * root(ps - a) - down * root(a) - A * v) / C, (down * root(ps - c) - up * root(c) + A * v) / C, (A * (a - c) - b * v) / m]
    s.bonds("na>ta ta>j j>mass j>r j>tb tb>nb").outputs(a="ca.e", b="cb.e", v="mass.f")
    return s.solved(rates, [ps / 2, ps / 2, 0], stiff=True, absolute=1e-11, longest=.004)


@family
def level_controller(r):
    """Proportional and integral, with a valve that is limited and an integral that knows it."""
    A, k, kp, ti, goal, top = flat(r, .5, 3), flat(r, .2, 1), flat(r, 1, 10), flat(r, .5, 5), flat(r, .5, 2), flat(r, 1, 3)
    s = Scene(flat(r, 5, 30), 101).parameters(A=A, k=k, kp=kp, ti=ti, goal=goal, top=top, start=0)
    tank(s, "k*sign(e)*sqrt(abs(e))", "0").element("u", "MSf", flow="valve")
    s.signals(error="goal - c.e", wish="kp*error + sum", valve="min(max(wish, 0), top)", sum={"integral": "(kp*error + 2*(valve - wish))/ti"})
    limited = lambda x: min(max(x, 0), top)

    def rates(t, y):
        wish = kp * (goal - y[0]) + y[1]
        return [(limited(wish) - k * root(y[0])) / A, (kp * (goal - y[0]) + 2 * (limited(wish) - wish)) / ti]
    wish = lambda t, y: kp * (goal - y[0]) + y[1]
    return s.solved(rates, [0, 0], lambda t, y: [y[0], k * root(y[0])], stiff=True, borders=[wish, lambda t, y: wish(t, y) - top])


@family
def accumulator(r):
    """A gas cushion, filled by a pump with pulses through an orifice and a check valve with a soft knee."""
    p0, V, k, q, w, load = flat(r, 10, 50), flat(r, .5, 2), U(r, .05, .5), flat(r, .1, 1), flat(r, 2, 30), U(r, 50, 500)
    s = Scene(flat(r, 1, 8), 101).parameters(p0=p0, V=V, k=k, q0=q, w=w, load=load).junctions("line gas", "j").element("pump", "Sf", flow="q0*abs(sin(w*t))")
    s.element("hose", "C", capacitance=1e-2, initial={"e": "p0"}).element("gas_", "C", law="e = p0*(V/(V - q))^1.4", initial={"q": 0})
    s.element("valve", "R", law="f = k*ssqrt(max(e, 0), 0.1)").element("load_", "R", resistance="load")
    s.bonds("pump>line line>hose line>j j>valve j>gas gas>gas_ gas>load_").outputs(hose="hose.e", gas="gas_.e")
    gas = lambda x: p0 * (V / (V - x))**1.4
    valve = lambda e: k * e / (e * e + .01)**.25 if e > 0 else 0.0

    def rates(t, y):
        f = valve(y[0] - gas(y[1]))
        return [(q * abs(sin(w * t)) - f) / 1e-2, f - gas(y[1]) / load]
    return s.solved(rates, [p0, 0], lambda t, y: [y[0], gas(y[1])], stiff=True, borders=[lambda t, y: y[0] - gas(y[1])],
                    breaks=[n * np.pi / w for n in range(1, 80)])


@family
def water_column(r):
    """A pipe with friction of the square of the flow between two tanks: it swings and comes to rest."""
    A1, A2, I, k, h1, h2 = U(r, .1, 3), U(r, .1, 3), U(r, .05, 5), U(r, .05, 20), flat(r, 0, 3), flat(r, 0, 3)
    s = Scene(sqrt(I * A1 * A2 / (A1 + A2)) * flat(r, 5, 60), 101).parameters(A1=A1, A2=A2, I=I, k=k).junctions("n1 n2", "j")
    s.element("c1", "C", capacitance="A1", initial={"e": h1}).element("c2", "C", capacitance="A2", initial={"e": h2}).element("i", "I", inertance="I")
    s.element("r", "R", law=one_of(r, "e = k*f*abs(f)", "e = if(f > 0, k*f^2, -k*f^2)")).bonds("n1>c1 n1>j j>i j>r j>n2 n2>c2")
    return s.outputs(h1="c1.e", f="i.f").solved(lambda t, y: [-y[2] / A1, y[2] / A2, (y[0] - y[1] - k * y[2] * abs(y[2])) / I], [h1, h2, 0],
                                                lambda t, y: [y[0], y[2]], borders=[lambda t, y: y[2]])


@family
def colebrook(r):
    """Two tanks level through a rough pipe whose friction is an implicit law."""
    A1, A2, K, c, rough, h1, h2 = U(r, .1, 3), U(r, .1, 3), U(r, 100, 1e4), U(r, 1e5, 1e8), U(r, 1e-6, 1e-2), flat(r, 3, 6), flat(r, 0, 1)
    # the friction at full turbulence, for the length of the scene: not until they are level, where the law ends
    guess = (-2 * np.log10(rough / 3.7))**2
    s = Scene(.7 * A1 * A2 / (A1 + A2) * 2 * sqrt(h1 - h2) * sqrt(K / guess), 61).parameters(A1=A1, A2=A2, K=K, c=c, rough=rough).junctions("n1 n2", "j")
    s.element("c1", "C", capacitance="A1", initial={"e": h1}).element("c2", "C", capacitance="A2", initial={"e": h2})
    s.element("pipe", "R", law="0 = f/sqrt(e/K) + 2*log10(rough/3.7 + 2.51/(c*sqrt(e/K)))").bonds("n1>c1 n1>j j>pipe j>n2 n2>c2").outputs(h="c1.e", f="pipe.f")
    f = lambda e: -2 * sqrt(e / K) * np.log10(rough / 3.7 + 2.51 / (c * sqrt(e / K)))
    return s.solved(lambda t, y: [-f(y[0] - y[1]) / A1, f(y[0] - y[1]) / A2], [h1, h2], lambda t, y: [y[0], f(y[0] - y[1])])


@family
def measured_orifice(r):
    """A resistance by a spline of measured flows, on a chamber that a piston presses."""
    k, C, P, w = flat(r, .5, 2), U(r, .05, 1), flat(r, .5, 2), flat(r, .5, 5)
    x = np.linspace(-6, 6, 13)
    y = (k * np.sign(x) * np.sqrt(np.abs(x)) + .3 * x).round(4)
    s = Scene(flat(r, 4, 15), 101).parameters(C=C, P=P, w=w).junctions("n", "j").element("u", "Se", effort="P + P*sin(w*t)")
    s.files["orifice.csv"] = "e,f\n" + "".join(f"{a},{b}\n" for a, b in zip(x, y))
    s.element("r", "R", law="f = table('orifice.csv', 'f', e, spline)").element("c", "C", capacitance="C").element("load", "R", resistance="2").bonds("u>j j>r j>n n>c n>load")

    def answer():
        from integrated import solution
        from scipy.interpolate import CubicSpline
        flow, push = CubicSpline(x, y, bc_type="not-a-knot"), lambda t: P + P * sin(w * t)
        states = solution(lambda t, v: [(float(flow(push(t) - v[0])) - v[0] / 2) / C], [0], s.times)
        return [[v[0], float(flow(push(t) - v[0]))] for t, v in zip(s.times, states)]
    s.answer = answer
    return s.outputs(v="c.e", f="r.f")


@family
def hydraulic_ram(r):
    """A long pipe, a waste valve that shuts at a speed of the flow, and a check valve into an air vessel."""
    I, R, C, h, close, load = flat(r, .5, 3), flat(r, .1, .5), U(r, .05, .5), flat(r, 1, 3), flat(r, .5, 1.5), U(r, 5, 50)
    s = Scene(flat(r, 5, 20), 121).parameters(I=I, R=R, C=C, h=h, close=close, load=load).junctions("n vessel", "pipe up")
    s.element("spring", "Se", effort="h").element("i", "I", inertance="I").element("r", "R", resistance="R").element("c", "C", capacitance="C", initial={"e": "h"})
    s.element("waste", "Sw", open="i.f > close", close="i.f < 0.01", initial="closed").element("check", "D").element("loss", "R", resistance="0.05")
    s.element("use", "R", resistance="load").bonds("spring>pipe pipe>i pipe>r pipe>n n>waste n>up up>check up>loss up>vessel vessel>c vessel>use")
    shut = {"now": False}

    def switch(value):
        def act(t, y):
            shut["now"] = value
        return act

    def rates(t, y):
        if not shut["now"]:
            return [(h - R * y[0]) / I, -y[1] / (load * C)]
        return [(h - (R + .05) * y[0] - y[1]) / I, (y[0] - y[1] / load) / C]
    return s.outputs(f="i.f", e="c.e").solved(rates, [0, h], borders=[
        (lambda t, y: -1 if shut["now"] else y[0] - close, switch(True)), (lambda t, y: .01 - y[0] if shut["now"] else -1, switch(False))])
