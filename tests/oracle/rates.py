"""Heat, reactions, populations and oscillators: equations of rates, written as graphs or as integrals."""
import json
import re
from math import cos, exp, log, sin, sqrt

import numpy as np

from scenes import Scene, between as U, family, flat, one_of


@family
def radiation(r):
    s0, C1, C2, T1, T2, A = 5.67e-8, U(r, 1e2, 1e4), U(r, 1e2, 1e4), flat(r, 300, 1500), flat(r, 250, 500), U(r, .01, 1)
    s = Scene(U(r, 100, 1e5), 61).parameters(C1=C1, C2=C2, A=A, s=s0).junctions("n1 n2")
    s.element("c1", "C", capacitance="C1", initial={"e": T1}).element("c2", "C", capacitance="C2", initial={"e": T2})
    s.element("gap", "RR", ports=["a", "b"], laws=["a.f = s*A*(a.e^4 - b.e^4)", "b.f = -s*A*(a.e^4 - b.e^4)"]).bonds("n1>c1 n2>c2 n1>gap.a n2>gap.b")

    def rates(t, y):
        flow = s0 * A * (y[0]**4 - y[1]**4)
        return [-flow / C1, flow / C2]
    return s.outputs(T1="c1.e", T2="c2.e").solved(rates, [T1, T2], stiff=True, absolute=1e-10)


@family
def melting(r):
    """A temperature that stands still while a solid melts; in closed form."""
    c1, c2, latent, G, hot, melt, cold = U(r, .5, 5), U(r, .5, 5), U(r, 1, 50), U(r, .1, 5), flat(r, 20, 60), flat(r, 0, 10), flat(r, -30, -5)
    first = c1 / G * log((hot - cold) / (hot - melt))
    last = first + latent / (G * (hot - melt))
    s = Scene(last * flat(r, .5, 2) + c2 / G * flat(r, 0, 2), 101).parameters(c1=c1, c2=c2, L=latent, G=G, hot=hot, melt=melt, cold=cold, solid=c1 * (melt - cold))
    s.element("c", "C", law="e = if(q < solid, cold + q/c1, if(q < solid + L, melt, melt + (q - solid - L)/c2))").element("r", "R", resistance="1/G")
    s.element("u", "Se", effort="hot").junctions("n", "j").bonds("u>j j>r j>n n>c").outputs(T="c.e", q="c.q")

    def row(t):
        solid = c1 * (melt - cold)
        if t < first:
            T = hot - (hot - cold) * exp(-G * t / c1)
            return [T, c1 * (T - cold)]
        if t < last:
            return [melt, solid + G * (hot - melt) * (t - first)]
        T = hot - (hot - melt) * exp(-G * (t - last) / c2)
        return [T, solid + latent + c2 * (T - melt)]
    return s.known(row)


@family
def thermostat(r):
    """A heater with two levels; in closed form, at any scale of time and temperature."""
    tau, low, high, A = one_of(r, 1, 1, 1e-9, 1e5), flat(r, .2, .4), flat(r, .5, .8), U(r, 1e-6, 1e6)
    t0 = one_of(r, 0, 0, -.37, 2.5) * tau
    s = Scene(t0 + flat(r, 2, 20) * tau, 77, t0).parameters(low=low * A, high=high * A, A=A, tau=tau).signals(off={"set": "room.e > high", "reset": "room.e < low"})
    s.junctions("n").element("heater", "MSf", flow="if(off, 0, A/tau)").element("room", "C", capacitance=1).element("leak", "R", resistance="tau")
    first, down, up = -log(1 - high), log(high / low), log((1 - low) / (1 - high))

    def row(t):
        t = (t - t0) / tau
        if t < first:
            return [A * (1 - exp(-t))]
        t = (t - first) % (down + up)
        return [A * (high * exp(-t) if t < down else 1 - (1 - low) * exp(down - t))]
    return s.bonds("heater>n n>room n>leak").outputs(T="room.e").known(row)


@family
def rod(r):
    """A rod of repeated pieces that radiates at its end."""
    n, G, T0, hot, s0 = int(r.integers(3, 13)), U(r, .05, 5), flat(r, 250, 400), flat(r, 500, 1500), 1e-9
    s = Scene(U(r, 1, 100) / G, 61).parameters(G=G, T0=T0, hot=hot, s=s0).element("u", "Se", effort="hot").element("j", "1", repeat=n)
    s.element("r", "R", repeat=n, resistance="1/G").element("n", "0", repeat=n).element("c", "C", repeat=n, capacitance=1, initial={"e": "T0"})
    s.element("end", "R", law="f = s*(e^4 - T0^4)").bonds(f"u>j[1] j[i]>r[i] j[i]>n[i] n[i]>c[i] n[i]>j[i+1] n[{n}]>end")

    def rates(t, y):
        flow = G * -np.diff(np.concatenate([[hot], y]))
        return flow - np.append(flow[1:], s0 * (y[-1]**4 - T0**4))
    return s.outputs(last=f"c[{n}].e", into="r[1].f").solved(rates, [T0] * n, lambda t, y: [y[-1], G * (hot - y[0])], stiff=True, absolute=1e-9)


@family
def diffusion_of_species(r):
    """Three species as stores of a logarithmic potential with two reversible reactions."""
    k, K, start = [U(r, .1, 1e3), U(r, .1, 10)], [U(r, .1, 10) for _ in range(3)], [flat(r, .5, 2), U(r, 1e-8, 1), U(r, 1e-8, 1)]
    s = Scene(U(r, .1, 20), 61).parameters(k1=k[0], k2=k[1], Ka=K[0], Kb=K[1], Kc=K[2]).junctions("na nb nc")
    for name, q in zip("abc", start):
        s.element(name, "C", law=f"e = log(K{name}*q)", initial={"q": q}).bonds(f"n{name}>{name}")
    for i in (1, 2):
        s.element(f"r{i}", "RR", ports=["a", "b"], laws=[f"a.f = k{i}*(exp(a.e) - exp(b.e))", f"b.f = -k{i}*(exp(a.e) - exp(b.e))"])

    def rates(t, y):
        u, v = k[0] * (K[0] * y[0] - K[1] * y[1]), k[1] * (K[1] * y[1] - K[2] * y[2])
        return [-u, u - v, v]
    return s.bonds("na>r1.a nb>r1.b nb>r2.a nc>r2.b").outputs(a="a.q", b="b.q", c="c.q").solved(rates, start, stiff=True, absolute=1e-15)


SYSTEMS = {  # states, rates, parameters, starts, length of the scene, stiff
    "van_der_pol": (["x", "y"], ["y", "mu*(1-x^2)*y-x"], dict(mu=(.5, 60)), [(1, 3), (-1, 1)], (5, 40), True),
    "lotka_volterra": (["x", "y"], ["x*(a-y)", "y*(x-b)"], dict(a=(.5, 2), b=(.5, 2)), [(.1, 6), (.1, 6)], (5, 60), False),
    "duffing": (["x", "y"], ["y", "-d*y+x-x^3+g*cos(w*t)"], dict(d=(.1, .5), g=(.1, .3), w=(.5, 1.5)), [(-1, 1), (-1, 1)], (5, 25), False),
    "pendulum": (["x", "y"], ["y", "-k*sin(x)-d*y"], dict(k=(1, 30), d=(.01, 1)), [(-3, 3), (-3, 3)], (2, 30), False),
    "brusselator": (["x", "y"], ["1+x^2*y-(b+1)*x", "b*x-x^2*y"], dict(b=(1.5, 5)), [(.2, 3), (.2, 3)], (5, 30), True),
    "oregonator": (["x", "y", "z"], ["s*(y-x*y+x-q*x^2)", "(-y-x*y+z)/s", "0.161*(x-z)"], dict(s=(77, 77.3), q=(8e-6, 9e-6)),
                   [(1, 3), (1, 3), (1, 3)], (50, 360), True),
    "robertson": (["x", "y", "z"], ["-k*x+1e4*y*z", "k*x-1e4*y*z-3e7*y^2", "3e7*y^2"], dict(k=(.01, .1)), [(1, 1.0001), (0, 1e-9), (0, 1e-9)],
                  (1, 1e5), True),
    "logistic": (["x"], ["r*x*(1-x)"], dict(r=(.5, 20)), [(1e-12, 1e-3)], (5, 40), False),
    "regrowth": (["x"], ["k*(t-T)*x"], dict(k=(2, 40), T=(.5, 1.5)), [(.5, 2)], (1, 3), False),
    "euler_top": (["x", "y", "z"], ["a*y*z", "-b*x*z", "c*x*y"], dict(a=(.2, 2), b=(.2, 2), c=(.2, 2)), [(.1, 2), (.1, 2), (1e-6, 2)], (5, 40), False),
    "epidemic": (["x", "y"], ["-b*x*y", "b*x*y-g*y"], dict(b=(1, 20), g=(.1, 1)), [(.5, 1), (1e-10, 1e-3)], (5, 60), False),
    "nerve": (["x", "y"], ["x-x^3/3-y+I", "0.08*(x+0.7-0.8*y)"], dict(I=(.3, .6)), [(-1, 1), (-1, 1)], (20, 150), False),
    "reactor": (["c", "T"], ["1-c-D*c*exp(T/(1+T/20))", "-T+8*D*c*exp(T/(1+T/20))-b*T"], dict(D=(.05, .3), b=(.5, 3)), [(.2, 1), (0, 1)], (3, 40), True),
    "enzyme": (["s", "c", "p"], ["-k*s*(0.01-c)+0.1*c", "k*s*(0.01-c)-(0.1+w)*c", "w*c"], dict(k=(10, 1e4), w=(.1, 100)), [(.5, 2), (0, 1e-12), (0, 1e-12)],
               (1, 100), True),
    "chemostat": (["x", "s"], ["x*(m*s/(0.1+s)-D)", "D*(1-s)-2*x*m*s/(0.1+s)"], dict(m=(.3, 2), D=(.1, 1)), [(1e-4, .1), (.5, 1)], (10, 100), False),
    "repressor": (["a", "b", "c"], ["k/(1+c^n)-a", "k/(1+a^n)-b", "k/(1+b^n)-c"], dict(k=(2, 50), n=(1.5, 4)), [(.1, 3), (.1, 3), (.1, 3)], (5, 60), False),
    "bistable_spring": (["x", "y"], ["y", "-2*x*(1-1/sqrt(x^2+a^2))-0.1*y+g*cos(w*t)"], dict(a=(.2, .8), g=(.01, .3), w=(.5, 2)), [(-1, 1), (0, 1e-9)],
                        (5, 40), False),
    "rossler": (["x", "y", "z"], ["-y-z", "x+0.2*y", "0.2+z*(x-c)"], dict(c=(2, 6)), [(-3, 3), (-3, 3), (0, 1)], (5, 30), False),
}


@family
def rate_equations(r):
    """Textbook systems as integrals, at odd scales of time and of each state."""
    name = one_of(r, *SYSTEMS)
    states, rates, ranges, starts, length, stiff = SYSTEMS[name]
    draw = lambda a, b: U(r, a, b) if a > 0 and b / a > 8 else flat(r, a, b)
    values, start, stop = {k: draw(*v) for k, v in ranges.items()}, [draw(*v) for v in starts], draw(*length)
    tau, scale = one_of(r, 1.0, 1.0, 1e-9, 1e6), [one_of(r, 1.0, 1.0, 1e-8, 1e7) for _ in states]
    s = Scene(stop * tau, 61).parameters(tau=tau, **values).only_signals()
    for state, rate, unit, x in zip(states, rates, scale, start):
        text = re.sub(r"\bt\b", "(t/tau)", rate)
        for other, its in zip(states, scale):
            text = re.sub(rf"\b{other}\b", f"({other}_/{its!r})", text)
        s.signals(**{state + "_": {"integral": f"{unit!r}*({text})/tau", "initial": unit * x}}).outputs(**{state: state + "_"})
    code = [compile(rate.replace("^", "**"), name, "eval") for rate in rates]
    known = {"sin": sin, "cos": cos, "exp": exp, "sqrt": sqrt, **values}

    def answer():
        from integrated import solution
        y = solution(lambda t, y: [eval(c, known, {"t": t, **dict(zip(states, y))}) for c in code], start, [t / tau for t in s.times],  # noqa: S307
                     stiff=stiff, absolute=1e-16, relative=1e-10 if stiff else None, longest=stop if name == "robertson" else None)
        return y * np.array(scale)
    s.model["about"] = name
    s.answer = answer
    return s


@family
def harvest(r):
    """A stock that grows logistically and is harvested above a level only."""
    g, level, h, start = U(r, .3, 3), flat(r, .3, .8), flat(r, .05, .2), flat(r, .05, .95)
    s = Scene(flat(r, 5, 30), 61).parameters(g=g, level=level, h=h).only_signals().outputs(x="x")
    s.signals(open_={"set": "x > level + 0.05", "reset": "x < level - 0.05", "initial": False},
              x={"integral": "g*x*(1 - x) - if(open_, h + g/4, 0)", "initial": start})
    on = {"now": start > level + .05}

    def switch(value):
        def act(t, y):
            on["now"] = value
        return act
    return s.solved(lambda t, y: [g * y[0] * (1 - y[0]) - (h + g / 4 if on["now"] else 0)], [start], borders=[
        (lambda t, y: -1 if on["now"] else y[0] - level - .05, switch(True)), (lambda t, y: level - .05 - y[0] if on["now"] else -1, switch(False))])


@family
def doses(r):
    """A drug taken at intervals: events add doses to the gut, which feeds the blood."""
    ka, ke, T, dose = U(r, .3, 5), U(r, .05, 1), flat(r, .5, 4), U(r, 1e-3, 1e3)
    s = Scene(flat(r, 3, 12) * T, 101).parameters(ka=ka, ke=ke, T=T, dose=dose).only_signals()
    s.signals(gut={"integral": "-ka*gut", "initial": "dose"}, blood={"integral": "ka*gut - ke*blood"}).outputs(gut="gut", blood="blood")
    s.event("take", "mod(t, T) < 0.5*T and t > 0.9*T", gut="gut + dose")

    def row(t):
        times = [t - n * T for n in range(int(t / T * (1 + 1e-12)) + 1)]
        return [dose * sum(exp(-ka * d) for d in times), dose * ka / (ka - ke) * sum(exp(-ke * d) - exp(-ka * d) for d in times)]
    return s.known(row)


@family
def battery(r):
    """An open-circuit voltage from a table over the charge, under pulses of current."""
    x = np.sort(np.concatenate([[0, 1], r.uniform(.05, .95, 4)])).round(3)
    e = np.sort(r.uniform(3, 4.2, 6)).round(4)
    R, T, I = flat(r, .01, .2), flat(r, .01, .05), flat(r, .1, .9)
    s = Scene(flat(r, .1, .2), 81).parameters(R=R, T=T, I=I).junctions("n", "j")
    s.files["cell.csv"] = "q,e\n" + "".join(f"{a},{b}\n" for a, b in zip(x, e))
    s.element("cell", "C", law="e = table('cell.csv', 'e', q)", initial={"q": .5}).element("r", "R", resistance="R").element("rl", "R", resistance="2")
    s.element("load", "MSf", flow="I*if(mod(t, T) < T/2, 1, -0.6)").bonds("load>n n>j j>r j>cell n>rl")
    ocv = lambda q: float(np.interp(q, x, e))
    volts = lambda t, q: (I * (1 if t % T < T / 2 else -.6) * R + ocv(q)) / (1 + R / 2)
    return s.outputs(q="cell.q", v="n.e").solved(
        lambda t, y: [(volts(t, y[0]) - ocv(y[0])) / R], [.5], lambda t, y: [y[0], volts(t, y[0])], breaks=[n * T / 2 for n in range(1, 41)],
        borders=[lambda t, y, at=at: y[0] - at for at in x[1:-1]])


@family
def submodels(r):
    """Repeated submodels whose parameters depend on their number."""
    n, a = int(r.integers(2, 7)), flat(r, .1, 1)
    s = Scene(flat(r, 2, 20)).parameters(g=a).element("u", "Se", effort="sin(t)").element("cell", "cell", repeat=n, parameters={"R": "1+g*i", "C": "1/(i+g)"})
    s.files["cell.json"] = json.dumps({"bgsim": 1, "name": "cell", "parameters": {"R": 1, "C": 1}, "ports": {"a": "n1", "b": "n2"}, "elements": {
        "n1": {"kind": "0"}, "n2": {"kind": "0"}, "j": {"kind": "1"}, "r": {"kind": "R", "resistance": "R"}, "c": {"kind": "C", "capacitance": "C"}},
        "bonds": [{"from": "n1", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "n2"}, {"from": "n2", "to": "c"}]})
    s.model["types"] = {"cell": "cell.json"}
    R, C = np.array([1 + a * i for i in range(1, n + 1)]), np.array([1 / (i + a) for i in range(1, n + 1)])

    def rates(t, y):
        flow = -np.diff(np.concatenate([[sin(t)], y])) / R
        return (flow - np.append(flow[1:], 0)) / C
    return s.bonds("u>cell[1].a cell[i].b>cell[i+1].a").outputs(v=f"cell[{n}].c.e").solved(rates, [0] * n, lambda t, y: [y[-1]])


@family
def action_potential(r):
    """Hodgkin and Huxley's nerve with a current: its rates are 0/0 at two voltages."""
    I = flat(r, 3, 20)
    s = Scene(flat(r, 20, 60), 121).parameters(I=I).only_signals().outputs(v="v", n="n")
    s.signals(an="0.01*(v + 55)/(1 - exp(-(v + 55)/10))", bn="0.125*exp(-(v + 65)/80)", am="0.1*(v + 40)/(1 - exp(-(v + 40)/10))", bm="4*exp(-(v + 65)/18)",
              ah="0.07*exp(-(v + 65)/20)", bh="1/(1 + exp(-(v + 35)/10))", n={"integral": "an*(1 - n) - bn*n", "initial": .3177},
              m={"integral": "am*(1 - m) - bm*m", "initial": .0529}, h={"integral": "ah*(1 - h) - bh*h", "initial": .5961},
              v={"integral": "I - 120*m^3*h*(v - 50) - 36*n^4*(v + 77) - 0.3*(v + 54.387)", "initial": -65})

    def rates(t, y):
        n, m, h, v = y
        part = lambda x: 1.0 if abs(x) < 1e-9 else x / (1 - exp(-x))
        return [.1 * part((v + 55) / 10) * (1 - n) - .125 * exp(-(v + 65) / 80) * n,
                part((v + 40) / 10) * (1 - m) - 4 * exp(-(v + 65) / 18) * m, .07 * exp(-(v + 65) / 20) * (1 - h) - h / (1 + exp(-(v + 35) / 10)),
                I - 120 * m**3 * h * (v - 50) - 36 * n**4 * (v + 77) - .3 * (v + 54.387)]
    return s.solved(rates, [.3177, .0529, .5961, -65], lambda t, y: [y[3], y[0]])


@family
def photosynthesis(r):
    """HIRES: eight reactions, stiff."""
    light = flat(r, .0005, .002)
    s = Scene(flat(r, 50, 321.8122), 61).parameters(light=light).only_signals().outputs(y1="y1", y7="y7", y8="y8")
    texts = ["-1.71*y1 + 0.43*y2 + 8.32*y3 + light", "1.71*y1 - 8.75*y2", "-10.03*y3 + 0.43*y4 + 0.035*y5", "8.32*y2 + 1.71*y3 - 1.12*y4",
             "-1.745*y5 + 0.43*y6 + 0.43*y7", "-280*y6*y8 + 0.69*y4 + 1.71*y5 - 0.43*y6 + 0.69*y7", "280*y6*y8 - 1.81*y7", "-280*y6*y8 + 1.81*y7"]
    start = [1, 0, 0, 0, 0, 0, 0, .0057]
    s.signals(**{f"y{k + 1}": {"integral": text, "initial": start[k]} for k, text in enumerate(texts)})
    code = [compile(text, "hires", "eval") for text in texts]
    rates = lambda t, y: [eval(c, {"light": light, **{f"y{k + 1}": x for k, x in enumerate(y)}}) for c in code]  # noqa: S307
    return s.solved(rates, start, lambda t, y: [y[0], y[6], y[7]], stiff=True, absolute=1e-15)
