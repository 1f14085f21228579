"""Circuits with saturation, semiconductors and machines, without ideal diodes (diodes.py)."""
import math
from math import cos, exp, pi, sin, sinh, sqrt

import numpy as np

from scenes import Scene, between as U, family, flat, one_of


@family
def rc_ladder(r):
    """Up to 13 repeated sections behind a sine; by eigenvalues."""
    n, R, tau, a, V = int(r.integers(2, 14)), U(r, 1e-3, 1e6), one_of(r, 1, 1, 1e-9, 1e5), flat(r, 0, 1), U(r, 1e-6, 1e6)
    t0, w = one_of(r, 0, 0, -1, 2.5) * tau, flat(r, .2, 5) / tau
    s = Scene(t0 + tau * U(r, .3, 30), 61, t0).parameters(R=R, C=tau / R, a=a, w=w, V=V, t0=t0)
    s.element("source", "Se", effort="V*sin(w*(t-t0))+V").element("joint", "1", repeat=n).element("node", "0", repeat=n)
    s.element("r", "R", repeat=n, resistance="R*(1+a*i/10)")
    s.element("c", "C", repeat=n, capacitance="C/(1+a*(i-1))", initial={"e": "V*i/10"})
    s.bonds("source>joint[1] joint[i]>r[i] joint[i]>node[i] node[i]>c[i] node[i]>joint[i+1]").outputs(v=f"c[{n}].e", i="r[1].f")
    G = [1 / (R * (1 + a * i / 10)) for i in range(1, n + 1)]
    A, C = np.zeros((n, n)), [tau / R / (1 + a * i) for i in range(n)]
    for i in range(n):
        A[i, i] -= G[i] / C[i]
        if i > 0:
            A[i, i - 1] = G[i] / C[i]
        if i < n - 1:
            A[i, i + 1], A[i, i] = G[i + 1] / C[i], A[i, i] - G[i + 1] / C[i]
    b = np.zeros(n)
    b[0] = V * G[0] / C[0]
    poles, modes = np.linalg.eig(A)
    swing, rest = np.linalg.solve(1j * w * np.eye(n) - A, b), np.linalg.solve(-A, b)
    shares = np.linalg.solve(modes, np.array([V * i / 10 for i in range(1, n + 1)]) - swing.imag - rest)

    def row(t):
        x = (modes @ (np.exp(poles * (t - t0)) * shares)).real + (swing * np.exp(1j * w * (t - t0))).imag + rest
        return [x[-1], (V * sin(w * (t - t0)) + V - x[0]) * G[0]]
    return s.known(row)


@family
def square_wave_rlc(r):
    R, L, C, T = U(r, .05, 5), 1.0, 1.0, U(r, .5, 20)
    stop = 8 * T
    s = Scene(stop, 101).parameters(R=R, T=T).junctions(ones="j").element("u", "Se", effort="if(mod(t, T) < T/2, 1, -1)")
    s.element("r", "R", resistance="R").element("l", "I", inertance=L).element("c", "C", capacitance=C).bonds("u>j j>r j>l j>c")
    return s.outputs(i="l.f", v="c.e").solved(lambda t, y: [(1 if t % T < T / 2 else -1) - R * y[0] - y[1], y[0]], [0, 0],
                                              breaks=[k * T / 2 for k in range(1, 17)])


@family
def saturating_coil(r):
    """Inrush: the flux passes its knee in the first half wave."""
    L, a, R, V, phase = U(r, .01, .1), U(r, 1, 100), flat(r, .5, 5), flat(r, 50, 300), flat(r, 0, 6)
    s = Scene(flat(r, .02, .2), 121).parameters(L=L, a=a, R=R, V=V, phase=phase).junctions(ones="j")
    s.element("u", "Se", effort="V*sin(100*pi*t + phase)").element("r", "R", resistance="R").element("l", "I", law="f = p/L + a*p^7")
    i = lambda p: p / L + a * p**7
    return s.bonds("u>j j>r j>l").outputs(i="l.f", p="l.p").solved(
        lambda t, y: [V * sin(100 * pi * t + phase) - R * i(y[0])], [0], lambda t, y: [i(y[0]), y[0]], stiff=True)


@family
def transformer(r):
    """A magnetizing current like sinh between the windings' resistances; the load is a coil."""
    R1, R2, L2, n, c, V = U(r, .1, 3), U(r, 1, 30), U(r, .01, 1), flat(r, .2, 3), U(r, 1, 8), flat(r, 50, 300)
    s = Scene(flat(r, .04, .2), 101).parameters(R1=R1, R2=R2, L2=L2, n=n, c=c, V=V).junctions("core", "first second")
    s.element("u", "Se", effort="V*sin(100*pi*t)").element("r1", "R", resistance="R1").element("m", "I", law="f = 0.1*sinh(c*p)")
    s.element("tf", "TF", modulus="n").element("r2", "R", resistance="R2").element("l2", "I", inertance="L2")
    s.bonds("u>first first>r1 first>core core>m core>tf tf>second second>r2 second>l2").outputs(i1="r1.f", i2="l2.f", p="m.p")

    def rates(t, y):
        e = V * sin(100 * pi * t) - R1 * (.1 * sinh(c * y[0]) + y[1] / n)
        return [e, (e / n - R2 * y[1]) / L2]
    return s.solved(rates, [0, 0], lambda t, y: [.1 * sinh(c * y[0]) + y[1] / n, y[1], y[0]], stiff=True)


@family
def tunnel_diode(r):
    Vs, R, L, C = flat(r, .2, .6), flat(r, 5, 30), U(r, 1e-9, 1e-7), U(r, 1e-12, 1e-11)
    s = Scene(flat(r, 5, 40) * sqrt(L * C), 101).parameters(Vs=Vs, R=R, L=L, C=C).junctions("n", "j")
    s.element("u", "Se", effort="Vs").element("r", "R", resistance="R").element("l", "I", inertance="L").element("c", "C", capacitance="C")
    s.element("d", "R", law="f = 1e-3*(17.76*e - 103.79*e^2 + 229.62*e^3 - 226.31*e^4 + 83.72*e^5)")
    i = lambda e: 1e-3 * (17.76 * e - 103.79 * e**2 + 229.62 * e**3 - 226.31 * e**4 + 83.72 * e**5)
    return s.bonds("u>j j>r j>l j>n n>c n>d").outputs(i="l.f", v="c.e").solved(
        lambda t, y: [(Vs - R * y[0] - y[1]) / L, (y[0] - i(y[1])) / C], [0, 0], stiff=True, absolute=1e-15)


@family
def chua(r):
    """Chua's circuit over the time in which no error has grown by more than a few orders."""
    a, b, m0, m1 = flat(r, 8, 16), flat(r, 14, 33), -1.143, -.714
    s = Scene(flat(r, 2, 8), 101).parameters(a=a, b=b, m0=m0, m1=m1).junctions("n1 n2", "j")
    s.element("c1", "C", capacitance="1/a", initial={"e": .1}).element("c2", "C", capacitance=1).element("l", "I", inertance="1/b")
    s.element("r", "R", resistance=1).element("d", "R", law="f = m1*e + 0.5*(m0 - m1)*(abs(e + 1) - abs(e - 1))")
    s.bonds("n1>c1 n1>d n2>j j>r j>n1 n2>c2 n2>l").outputs(x="c1.e", y="c2.e", z="l.f")
    i = lambda e: m1 * e + .5 * (m0 - m1) * (abs(e + 1) - abs(e - 1))
    return s.solved(lambda t, y: [a * (y[1] - y[0] - i(y[0])), y[0] - y[1] - y[2], b * y[1]], [.1, 0, 0],
                    borders=[lambda t, y: y[0] - 1, lambda t, y: y[0] + 1])


@family
def josephson(r):
    C, R, I0 = U(r, .1, 5), U(r, .3, 3), flat(r, .5, 1.6)
    s = Scene(flat(r, 5, 30), 101).parameters(C=C, R=R, I0=I0).junctions("n").element("b", "Sf", flow="I0")
    s.element("c", "C", capacitance="C").element("r", "R", resistance="R").element("j", "I", law="f = sin(2*pi*p)").bonds("b>n n>c n>r n>j")
    return s.outputs(v="c.e", p="j.p").solved(lambda t, y: [(I0 - y[0] / R - sin(2 * pi * y[1])) / C, y[0]], [0, 0])


@family
def clipper(r):
    """Two exponential diodes limit what a resistance lets through."""
    R, C, V, w = U(r, 100, 1e4), U(r, 1e-8, 1e-6), flat(r, 1, 20), U(r, 10, 1e4)
    s = Scene(12 / w, 101).parameters(R=R, C=C, V=V, w=w).junctions("n", "j").element("u", "Se", effort="V*sin(w*t)")
    s.element("r", "R", resistance="R").element("c", "C", capacitance="C")
    s.element("d1", "R", law="f = 1e-14*(exp(e/0.02585) - 1)").element("d2", "R", law="f = 1e-14*(1 - exp(-e/0.02585))")
    i = lambda e: 1e-14 * (exp(min(e / .02585, 300)) - exp(min(-e / .02585, 300)))
    return s.bonds("u>j j>r j>n n>c n>d1 n>d2").outputs(v="c.e", i="r.f").solved(
        lambda t, y: [((V * sin(w * t) - y[0]) / R - i(y[0])) / C], [0], lambda t, y: [y[0], (V * sin(w * t) - y[0]) / R], stiff=True,
        relative=1e-10)


@family
def varactor(r):
    """A resonance whose capacitor stiffens."""
    a, R, V, w = U(r, .1, 10), U(r, .02, .5), flat(r, .5, 3), flat(r, .5, 4)
    s = Scene(flat(r, 10, 40), 121).parameters(a=a, R=R, V=V, w=w).junctions(ones="j").element("u", "Se", effort="V*cos(w*t)")
    s.element("r", "R", resistance="R").element("l", "I", inertance=1).element("c", "C", law="e = q + a*q^3").bonds("u>j j>r j>l j>c")
    return s.outputs(i="l.f", q="c.q").solved(lambda t, y: [V * cos(w * t) - R * y[0] - y[1] - a * y[1]**3, y[0]], [0, 0])


@family
def neon_lamp(r):
    """Relaxation: lights above one voltage and goes out below another one (a latch)."""
    low, high, R, tau, V = flat(r, .3, .5), flat(r, .55, .9), U(r, 1e-3, .2), one_of(r, 1, 1e-6, 1e4), U(r, 1e-3, 1e3)
    s = Scene(tau * flat(r, 3, 20), 91).parameters(tau=tau, V=V, low=low, high=high, R=R).junctions("n", "j")
    s.signals(lit={"set": "c.e > high*V", "reset": "c.e < low*V"}).element("u", "Se", effort="V").element("r", "R", resistance="tau")
    s.element("c", "C", capacitance=1).element("lamp", "MR", law="f = if(lit, e/(R*tau), 0)").bonds("u>j j>r j>n n>c n>lamp").outputs(v="c.e")
    rest, fast = R / (1 + R), 1 + 1 / R  # where it would come to while lit, and how fast
    if rest >= low:  # never goes out: one step only
        first = -math.log(1 - high)
        return s.known(lambda t: [V * (1 - exp(-t / tau) if t < first * tau else rest + (high - rest) * exp(-fast * (t / tau - first)))])
    first, lit, dark = -math.log(1 - high), math.log((high - rest) / (low - rest)) / fast, math.log((1 - low) / (1 - high))

    def row(t):
        t /= tau
        if t < first:
            return [V * (1 - exp(-t))]
        t = (t - first) % (lit + dark)
        return [V * (rest + (high - rest) * exp(-fast * t) if t < lit else 1 - (1 - low) * exp(lit - t))]
    return s.known(row)


@family
def synchronous_motor(r):
    """Permanent magnets, in rotor coordinates, at fixed voltages."""
    R, Ld, psi, P, J = flat(r, .2, 1), U(r, 1e-3, 1e-2), flat(r, .05, .3), int(r.integers(2, 5)), U(r, 1e-3, 1e-2)
    Lq, b, ud, uq, T = Ld * flat(r, 1, 2), U(r, 1e-4, 1e-2), flat(r, -5, 5), flat(r, 5, 30), flat(r, 0, 1)
    s = Scene(flat(r, .05, .5), 101).parameters(R=R, Ld=Ld, Lq=Lq, psi=psi, P=P, J=J, b=b, ud=ud, uq=uq, T=T).junctions(ones="jd jq shaft")
    s.element("sd", "Se", effort="ud").element("ld", "I", inertance="Ld").element("rd", "R", resistance="R")
    s.element("sq", "Se", effort="uq").element("lq", "I", inertance="Lq").element("rq", "R", resistance="R")
    s.element("gd", "MGY", modulus="P*lq.p").element("gq", "MGY", modulus="P*(ld.p + psi)")
    s.element("rotor", "I", inertance="J").element("bearing", "R", resistance="b").element("torque", "Se", effort="-T")
    s.bonds("sd>jd jd>ld jd>rd sq>jq jq>lq jq>rq jq>gq gq>shaft shaft>gd gd>jd torque>shaft shaft>rotor shaft>bearing")

    def rates(t, y):
        d, q, w = y
        return [ud - R * d / Ld + P * q * w, uq - R * q / Lq - P * (d + psi) * w, (P * (d + psi) * q / Lq - P * q * d / Ld - T - b * w) / J]
    return s.outputs(d="ld.f", q="lq.f", w="rotor.f").solved(rates, [0, 0, 0], lambda t, y: [y[0] / Ld, y[1] / Lq, y[2]])


@family
def induction_motor(r):
    """Starts at the line, in coordinates of the stator: two fields of two coils each, and a fan."""
    Rs, Rr, L, M, J, fan = U(r, .2, 2), U(r, .2, 2), flat(r, .1, .3), 0, U(r, .02, .3), U(r, 1e-4, 1e-3)
    M, P, V = L * flat(r, .9, .97), 2, 310.0
    s = Scene(flat(r, .1, .5), 101).parameters(Rs=Rs, Rr=Rr, L=L, M=M, J=J, fan=fan, P=P, V=V)
    s.junctions(ones="sa sb ra rb shaft").element("rotor", "I", inertance="J").element("load", "R", law="e = fan*f*abs(f)")
    for axis, wave in (("a", "cos"), ("b", "sin")):
        s.element("u" + axis, "Se", effort=f"V*{wave}(100*pi*t)").element("rs" + axis, "R", resistance="Rs").element("rr" + axis, "R", resistance="Rr")
        s.element("f" + axis, "II", ports=["s", "r"], energy="(L*s.p^2 - 2*M*s.p*r.p + L*r.p^2)/(2*(L^2 - M^2))")
        s.bonds(f"u{axis}>s{axis} s{axis}>rs{axis} s{axis}>f{axis}.s r{axis}>rr{axis} r{axis}>f{axis}.r")
    # the rotor's voltages: e_a = -P w flux_b, e_b = P w flux_a
    s.element("ga", "MGY", modulus="P*fb.r.p").element("gb", "MGY", modulus="P*fa.r.p").bonds("ra>ga ga>shaft shaft>gb gb>rb shaft>rotor shaft>load")
    D = L * L - M * M

    def rates(t, y):
        sa, ra, sb, rb, w = y
        ia, ib, ja, jb = (L * sa - M * ra) / D, (L * sb - M * rb) / D, (L * ra - M * sa) / D, (L * rb - M * sb) / D
        return [V * cos(100 * pi * t) - Rs * ia, -Rr * ja - P * rb * w, V * sin(100 * pi * t) - Rs * ib, -Rr * jb + P * ra * w,
                (P * (rb * ja - ra * jb) - fan * w * abs(w)) / J]
    return s.outputs(i="rsa.f", w="rotor.f").solved(rates, [0] * 5, lambda t, y: [(L * y[0] - M * y[1]) / D, y[4]])


@family
def chopped_motor(r):
    """A DC motor at a pulsed voltage with a fan."""
    T, duty, L, R, k, J, fan = U(r, 1e-3, .1), flat(r, .1, .9), U(r, 1e-3, 1e-1), U(r, .2, 5), flat(r, .05, 1), U(r, 1e-3, 1), U(r, 1e-5, 1e-2)
    s = Scene(flat(r, 10, 40) * T, 101).parameters(T=T, duty=duty, L=L, R=R, k=k, J=J, fan=fan).junctions(ones="coil shaft")
    s.element("u", "Se", effort="if(mod(t, T) < duty*T, 24, 0)").element("r", "R", resistance="R").element("l", "I", inertance="L")
    s.element("gy", "GY", modulus="k").element("rotor", "I", inertance="J").element("fan_", "R", law="e = fan*f*abs(f)")
    s.bonds("u>coil coil>r coil>l coil>gy gy>shaft shaft>rotor shaft>fan_").outputs(i="l.f", w="rotor.f")
    return s.solved(lambda t, y: [((24 if t % T < duty * T else 0) - R * y[0] - k * y[1]) / L, (k * y[0] - fan * y[1] * abs(y[1])) / J], [0, 0],
                    breaks=[(n + x) * T for n in range(41) for x in (0, duty)])


@family
def microphone(r):
    """A plate capacitor with a moving plate, biased through a resistance, in a sound field."""
    bias, R, k, m, b, w = flat(r, 1, 10), U(r, .01, 10), flat(r, 5, 50), U(r, .1, 3), U(r, .05, 2), flat(r, .5, 6)
    s = Scene(flat(r, 5, 20), 101).parameters(bias=bias, R=R, k=k, m=m, b=b, w=w).junctions(ones="wire plate")
    s.element("u", "Se", effort="bias").element("r", "R", resistance="R").element("mass", "I", inertance="m").element("damp", "R", resistance="b")
    s.element("air", "CC", ports=["el", "gap"], energy="el.q^2*(1 + 0.1*gap.q)/2 + k*gap.q^2/2", initial={"el.q": "bias"})
    s.element("sound", "Se", effort="sin(w*t)").bonds("u>wire wire>r wire>air.el sound>plate plate>mass plate>damp plate>air.gap")

    def rates(t, y):
        q, x, v = y
        return [(bias - q * (1 + .1 * x)) / R, v, (sin(w * t) - .05 * q * q - k * x - b * v) / m]
    return s.outputs(i="r.f", x="air.gap.q").solved(rates, [bias, 0, 0], lambda t, y: [(bias - y[0] * (1 + .1 * y[1])) / R, y[1]])


@family
def line(r):
    """A loss-free line between a matched source and a resistance: wave variables a = e + Z f that arrive late."""
    T, Z, load, w = U(r, .05, 2), U(r, 10, 1e3), U(r, .05, 20), flat(r, 1, 8)
    s = Scene(flat(r, 3, 12) * T, 121).parameters(T=T, Z=Z, load=load, w=w).junctions(ones="near far")
    # each end is a source of the arriving wave behind Z; near.f*2*Z counts what leaves
    s.signals(there={"delay": "back + 2*Z*near.f", "by": "T"}, back={"delay": "there - 2*Z*far.f", "by": "T"})
    s.element("u", "Se", effort="if(t < 0.7*T, sin(w*t), 0)").element("rs", "R", resistance="Z").element("zn", "R", resistance="Z")
    s.element("wn", "MSe", effort="-back").element("wf", "MSe", effort="there").element("zf", "R", resistance="Z").element("rl", "R", resistance="load*Z")
    s.bonds("u>near wn>near near>rs near>zn wf>far far>zf far>rl").outputs(i="near.f", v="rl.e")
    wave = lambda t: sin(w * t) if 0 <= t < .7 * T else 0.0
    bounce = (load - 1) / (load + 1)
    return s.known(lambda t: [(wave(t) - bounce * wave(t - 2 * T)) / (2 * Z), wave(t - T) * load / (1 + load)])


@family
def thermistor(r):
    """A resistance that its own heat changes: runs away, or is limited."""
    R0, B, C, G, V = flat(r, 5, 50), flat(r, 500, 4000), flat(r, .1, 5), flat(r, .005, .1), flat(r, 2, 15)
    s = Scene(C / G * flat(r, 1, 10), 101).parameters(R0=R0, B=B, C=C, G=G, V=V, Rs=R0 / 5).junctions("hot", "wire cool")
    s.signals(R="R0*exp(B*(1/T.e - 1/300))").element("u", "Se", effort="V").element("rs", "R", resistance="Rs").element("ntc", "MR", resistance="R")
    s.element("heat", "MSf", flow="ntc.e*ntc.f").element("T", "C", capacitance="C", initial={"e": 300}).element("air", "Se", effort=300)
    s.element("loss", "R", resistance="1/G").bonds("u>wire wire>rs wire>ntc heat>hot hot>T hot>cool cool>loss cool>air")
    R = lambda T: R0 * exp(B * (1 / T - 1 / 300))
    i = lambda T: V / (R0 / 5 + R(T))
    return s.outputs(T="T.e", i="ntc.f").solved(lambda t, y: [(R(y[0]) * i(y[0])**2 - G * (y[0] - 300)) / C], [300], lambda t, y: [y[0], i(y[0])],
                                                stiff=True, absolute=1e-9)


@family
def diode_with_resistance(r):
    """A rectifier whose diode is an implicit law with its own resistance."""
    Is, Vt, Rd, C, RL, V, w = 1e-12, .026, U(r, .1, 10), U(r, 1e-5, 1e-3), U(r, 100, 1e4), flat(r, 2, 20), U(r, 50, 500)
    s = Scene(20 / w, 101).parameters(Is=Is, Vt=Vt, Rd=Rd, C=C, RL=RL, V=V, w=w).junctions("n", "j").element("u", "Se", effort="V*sin(w*t)")
    s.element("d", "R", law="0 = f - Is*(exp((e - Rd*f)/Vt) - 1)").element("c", "C", capacitance="C").element("load", "R", resistance="RL")

    def current(e):
        """By bisection over the voltage of the junction."""
        low, high = (-1.0, min(e, 1.5)) if e > 0 else (e, 0.0)
        if e < -1:
            return -Is
        for _ in range(80):
            x = (low + high) / 2
            low, high = (x, high) if x + Rd * Is * (exp(x / Vt) - 1) < e else (low, x)
        return Is * (exp(low / Vt) - 1)
    return s.bonds("u>j j>d j>n n>c n>load").outputs(v="c.e", i="d.f").solved(
        lambda t, y: [(current(V * sin(w * t) - y[0]) - y[0] / RL) / C], [0], lambda t, y: [y[0], current(V * sin(w * t) - y[0])], stiff=True,
        relative=1e-10)


@family
def swing_equation(r):
    """A generator on a line that is short-circuited for a while: it keeps step, or loses it."""
    M, D, P, K, cleared = flat(r, .05, .3), flat(r, 0, .1), flat(r, .3, .9), flat(r, 1, 2), flat(r, .05, .6)
    s = Scene(flat(r, 2, 8), 101).parameters(M=M, D=D, P=P, K=K, cleared=cleared).junctions(ones="j").element("m", "I", inertance="M")
    start = math.asin(P / K)
    s.signals(angle={"integral": "m.f", "initial": start}).element("damp", "R", resistance="D").element("drive", "Se", effort="P")
    s.element("line", "MSe", effort="-if(t > 0.1 and t < 0.1 + cleared, 0, K*sin(angle))").bonds("drive>j line>j j>m j>damp").outputs(a="angle", w="m.f")
    return s.solved(lambda t, y: [y[1], (P - (0 if .1 < t < .1 + cleared else K * sin(y[0])) - D * y[1]) / M], [start, 0], breaks=[.1, .1 + cleared])
