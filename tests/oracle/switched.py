"""Contacts with rebounds, clutches and switches with closed forms from instant to instant."""
from math import cos, exp, log, pi, sin, sqrt

import numpy as np

from scenes import Scene, between as U, family, flat, one_of


@family
def bouncing_ball(r):
    """At any scale of length and time, also to rest."""
    tau, H, e, m, v0 = one_of(r, 1.0, 1e-3, 1e5), U(r, 1e-6, 1e6), flat(r, .3, 1), U(r, 1e-3, 1e3), flat(r, -1, 1)
    t0 = one_of(r, 0, -1, 2.5) * tau
    lands = -v0 + sqrt(v0 * v0 + 2)
    first = (lands + v0) * e
    rest = lands + 2 * first / (1 - e) if e < 1 else 1e9
    s = Scene(t0 + tau * min(rest * flat(r, .5, 1.3), 30), 83, t0).parameters(H=H, g=H / tau**2, m=m, v0=v0 * H / tau).junctions(ones="ball")
    s.element("i", "I", inertance="m", initial={"f": "v0"}).element("w", "Se", effort="m*g").element("c", "contact", gap=0, initial={"q": "-H"}, restitution=e)

    def row(t):
        t = (t - t0) / tau
        if t < lands:
            return [H * (-1 + v0 * t + t * t / 2)]
        if t >= rest:
            return [0]
        t, v = t - lands, first
        while t > 2 * v and v > 1e-15:
            t, v = t - 2 * v, v * e
        return [H * (-v * t + t * t / 2)]
    return s.bonds("ball>i w>ball ball>c").outputs(q="c.q").known(row)


@family
def oscillator_at_a_stop(r):
    """A driven mass on a spring hits a stop and rebounds."""
    e, k, c, w, F, gap = flat(r, .2, .95), flat(r, 5, 40), flat(r, .1, 2), flat(r, 1, 8), flat(r, 3, 20), flat(r, .05, .3)
    s = Scene(flat(r, 2, 5), 67).parameters(k=k, c=c, w=w, F=F, gap=gap).junctions(ones="j").element("i", "I", inertance=1).element("k1", "C", capacitance="1/k")
    s.element("d", "R", resistance="c").element("u", "Se", effort="F*cos(w*t)").element("stop", "contact", gap="gap", restitution=e).bonds("u>j j>i j>k1 j>d j>stop")

    def hit(t, y):
        if y[1] < 1e-3:
            raise ArithmeticError("it comes to rest at the stop, which this reference does not know")
        return [gap - 1e-15, -e * y[1]]
    return s.outputs(x="stop.q").solved(lambda t, y: [y[1], F * cos(w * t) - k * y[0] - c * y[1]], [0, 0], lambda t, y: y[:1], borders=[(lambda t, y: y[0] - gap, hit)],
                                        longest=.01)


@family
def balls_on_a_line(r):
    """Up to four balls of other masses between two walls, until the first two impacts that coincide."""
    n = int(r.integers(2, 5))
    mass, e, x, v = [U(r, .2, 5) for _ in range(n)], [flat(r, .5, 1) for _ in range(n + 1)], sorted(flat(r, .05, 1) for _ in range(n)), [flat(r, -1, 1) for _ in range(n)]
    s = Scene(flat(r, 1, 6), 61, impacts="sequential")
    for i in range(n):
        s.junctions(ones=f"b{i}").element(f"m{i}", "I", inertance=mass[i], initial={"f": v[i]}).bonds(f"b{i}>m{i}")
        s.signals(**{f"x{i}": {"integral": f"m{i}.f", "initial": x[i]}}).outputs(**{f"x{i}": f"x{i}"})
    for i in range(n - 1):
        s.junctions(f"z{i}").element(f"c{i}", "contact", gap=x[i + 1] - x[i], restitution=e[i + 1]).bonds(f"b{i}>z{i} z{i}>b{i + 1} z{i}>c{i}")
    s.junctions(ones="left").element("turn", "TF", modulus=-1).element("wall", "contact", gap=x[0], restitution=e[0]).bonds("b0>turn turn>left left>wall")
    s.element("end", "contact", gap=1.2 - x[-1], restitution=e[n]).bonds(f"b{n - 1}>end")

    def answer():
        X, V, t, k, rows, times = np.array(x), np.array(v), 0.0, 0, [], s.times
        while k < len(times):
            due = [(max(X[i + 1] - X[i], 0) / (V[i] - V[i + 1]), i) for i in range(n - 1) if V[i] - V[i + 1] > 1e-14]
            due += [(X[0] / -V[0], -1)] * (V[0] < -1e-14) + [((1.2 - X[-1]) / V[-1], n - 1)] * (V[-1] > 1e-14)
            wait, i = min(due, default=(1e9, None))
            while k < len(times) and times[k] <= t + wait:
                rows.append(X + (times[k] - t) * V)
                k += 1
            if k == len(times):
                break
            if len(due) > 1 and sorted(due)[1][0] - wait < 1e-7 or len(rows) > 1 and wait < 1e-7:
                raise ArithmeticError("two impacts at one instant")
            X, t = X + wait * V, t + wait
            if i == -1:
                V[0] *= -e[0]
            elif i == n - 1:
                V[-1] *= -e[n]
            else:
                p = mass[i] * mass[i + 1] / (mass[i] + mass[i + 1]) * (1 + e[i + 1]) * (V[i] - V[i + 1])
                V[i], V[i + 1] = V[i] - p / mass[i], V[i + 1] + p / mass[i + 1]
        return rows
    return s.computed(answer)


@family
def locked_clutch(r):
    """Two rotors that a switch locks for a while: momentum is kept, energy is lost at once."""
    J1, J2, w1, w2, b1, b2, on, out = U(r, .1, 10), U(r, .1, 10), flat(r, -10, 10), flat(r, -10, 10), U(r, .01, 1), U(r, .01, 1), flat(r, .1, 1), flat(r, 1.2, 3)
    s = Scene(4.0, 101).parameters(J1=J1, J2=J2, b1=b1, b2=b2, on=on, out=out).junctions("z", "a c slip").element("i1", "I", inertance="J1", initial={"f": w1})
    s.element("i2", "I", inertance="J2", initial={"f": w2}).element("r1", "R", resistance="b1").element("r2", "R", resistance="b2")
    s.element("clutch", "Sw", locked="t >= on and t < out").bonds("a>i1 a>r1 a>z z>slip slip>clutch z>c c>i2 c>r2").outputs(w1="a.f", w2="c.f")
    together = (J1 * w1 * exp(-b1 / J1 * on) + J2 * w2 * exp(-b2 / J2 * on)) / (J1 + J2)

    def row(t):
        if t < on:
            return [w1 * exp(-b1 / J1 * t), w2 * exp(-b2 / J2 * t)]
        w = together * exp(-(b1 + b2) / (J1 + J2) * (min(t, out) - on))
        d = max(t - out, 0)
        return [w * exp(-b1 / J1 * d), w * exp(-b2 / J2 * d)]
    return s.known(row)


@family
def resonant_charge(r):
    """A coil and a diode charge a capacitor to twice the source's voltage, from when a switch closes."""
    tau, A, v0, on = one_of(r, 1.0, 1e-9, 1e5), U(r, 1e-6, 1e6), flat(r, -1, .9), flat(r, .01, 2)
    t0 = one_of(r, 0, -1, 2.5) * tau
    s = Scene(t0 + flat(r, 3, 12) * tau, 67, t0).parameters(V=A, L=A * tau, C=tau / A, on=t0 + on * tau, v0=v0 * A).junctions(ones="j").element("u", "Se", effort="V")
    s.element("d", "D").element("sw", "Sw", closed="t >= on").element("l", "I", inertance="L").element("c", "C", capacitance="C", initial={"e": "v0"})

    def row(t):
        u = min(max((t - t0) / tau - on, 0), pi)
        return [A * (1 - (1 - v0) * cos(u)), (1 - v0) * sin(u)]
    return s.bonds("u>j j>d j>sw j>l j>c").outputs(v="c.e", i="j.f").known(row)


@family
def hysteresis_control(r):
    """A coil's current between two levels by a switch, with a diode that takes it over."""
    low, high, A, tau = flat(r, .2, .4), flat(r, .45, .8), U(r, 1e-6, 1e6), one_of(r, 1.0, 1e-9, 1e5)
    s = Scene(flat(r, 2, 15) * tau, 77).parameters(V=A, R=A, L=A * tau, low=low, high=high).junctions("n", "j coil").element("u", "Se", effort="V")
    s.element("sw", "Sw", close="l.f < low", open="l.f > high", initial="closed").element("free", "D", passes="out").element("l", "I", inertance="L")
    s.element("r", "R", resistance="R").bonds("u>j j>sw j>n n>free n>coil coil>l coil>r").outputs(i="l.f")
    first, down, up = -log(1 - high), log(high / low), log((1 - low) / (1 - high))

    def row(t):
        t /= tau
        if t < first:
            return [1 - exp(-t)]
        t = (t - first) % (down + up)
        return [high * exp(-t) if t < down else 1 - (1 - low) * exp(down - t)]
    return s.known(row)


@family
def heart(r):
    """A ventricle whose stiffness is a function of time between two valves, and the arteries."""
    low, high, T, Rv, Rm, C, R, p = flat(r, .03, .08), flat(r, 1.5, 3), flat(r, .6, 1), flat(r, .005, .02), flat(r, .005, .02), flat(r, 1, 2), flat(r, .8, 1.4), flat(r, 5, 12)
    s = Scene(flat(r, 1, 3) * T, 121).parameters(low=low, high=high, T=T, Rv=Rv, Rm=Rm, C=C, R=R, p=p).junctions("lv ao", "jm ja jr")
    s.signals(E="low + (high - low)*sin(pi*t/T)^6").element("atrium", "Se", effort="p").element("mitral", "D").element("rm", "R", resistance="Rm")
    s.element("heart", "C", law="e = E*q", initial={"q": 100}).element("aortic", "D").element("rv", "R", resistance="Rv").element("c", "C", capacitance="C", initial={"e": 80})
    s.element("r", "R", resistance="R").element("back", "Se", effort="p")
    s.bonds("atrium>jm jm>mitral jm>rm jm>lv lv>heart lv>ja ja>aortic ja>rv ja>ao ao>c ao>jr jr>r jr>back").outputs(lv="heart.e", ao="c.e", q="heart.q")
    E = lambda t: low + (high - low) * sin(pi * t / T)**6

    def rates(t, y):
        lv, ao = E(t) * y[0], y[1] / C
        out = max(lv - ao, 0) / Rv
        return [max(p - lv, 0) / Rm - out, out - (ao - p) / R]
    return s.solved(rates, [100, 80 * C], lambda t, y: [E(t) * y[0], y[1] / C, y[0]], stiff=True, absolute=1e-10,
                    borders=[lambda t, y: E(t) * y[0] - p, lambda t, y: E(t) * y[0] - y[1] / C])
