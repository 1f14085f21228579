"""Machines, friction, stops and fields of bodies that move."""
from math import copysign, cos, exp, floor, pi, sin, sqrt, tanh

from scenes import Scene, between as U, family, flat, one_of


@family
def crank(r):
    """A rotor drives a spring and damper through a crank."""
    J, a, k, d, M, w = U(r, .1, 3), U(r, .1, 1), U(r, .5, 50), U(r, .05, 2), flat(r, -.5, .5), flat(r, -6, 6)
    s = Scene(flat(r, 2, 10), 71).parameters(J=J, a=a, k=k, d=d, M=M, w=w).signals(angle={"integral": "rotor.f", "initial": 0})
    s.junctions(ones="shaft rod").element("rotor", "I", inertance="J", initial={"f": "w"}).element("m", "Se", effort="M")
    s.element("tf", "MTF", modulus="a*sin(angle)").element("c", "C", capacitance="1/k").element("damp", "R", resistance="d")

    def rates(t, y):
        n = a * sin(y[0])
        return [y[1], (M - n * (k * y[2] + d * n * y[1])) / J, n * y[1]]
    return s.bonds("m>shaft shaft>rotor shaft>tf tf>rod rod>c rod>damp").outputs(angle="angle", w="rotor.f", x="c.q").solved(rates, [0, w, 0])


@family
def slider_crank(r):
    """The same with a mass: a dependent store whose modulus passes zero."""
    J, a, m, M, w, b = U(r, .1, 3), U(r, .1, 1), U(r, .1, 5), flat(r, -.5, .5), flat(r, 1, 6), flat(r, .001, .3)
    s = Scene(flat(r, 2, 10), 71).parameters(J=J, a=a, m=m, M=M, w=w, b=b).signals(angle={"integral": "rotor.f", "initial": 0.2})
    s.junctions(ones="shaft rod").element("rotor", "I", inertance="J", initial={"f": "w"}, priority=1).element("mass", "I", inertance="m")
    s.element("u", "Se", effort="M").element("tf", "MTF", modulus="a*sin(angle)").element("bearing", "R", resistance="b")

    def rates(t, y):
        n = a * sin(y[0])
        return [y[1], (M - b * y[1] - n * a * cos(y[0]) * m * y[1]**2) / (J + n * n * m)]
    return s.bonds("u>shaft shaft>rotor shaft>bearing shaft>tf tf>rod rod>mass").outputs(angle="angle", w="rotor.f", v="mass.f").solved(
        rates, [.2, w], lambda t, y: [y[0], y[1], a * sin(y[0]) * y[1]])


def oscillator(law, **parameters):
    """A unit mass on a spring with a driven force F sin(w t) and a friction."""
    s = Scene(parameters.pop("stop"), 81).parameters(**parameters).junctions(ones="j").element("i", "I", inertance=1, initial={"f": parameters.get("v0", 0)})
    s.element("c", "C", capacitance="1/k").element("u", "Se", effort="F*sin(w*t)").element("friction", "R", law=law)
    return s.bonds("u>j j>i j>c j>friction").outputs(x="c.q", v="i.f")


@family
def smooth_friction(r):
    width, F, w, k, mu = one_of(r, 1e-2, 1e-4, 1e-6), flat(r, .5, 3), flat(r, .5, 3), flat(r, .5, 4), flat(r, .2, 1)
    s = oscillator("e = mu*tanh(f/width)", stop=flat(r, 3, 15), F=F, w=w, k=k, mu=mu, width=width)
    return s.solved(lambda t, y: [y[1], F * sin(w * t) - k * y[0] - mu * tanh(y[1] / width)], [0, 0], stiff=True, relative=1e-10)


@family
def dry_friction(r):
    """Slides, sticks and breaks loose: the side of the friction is followed as a state of the reference."""
    F, w, k, mu, v0 = flat(r, .5, 3), flat(r, .5, 3), flat(r, .5, 4), flat(r, .2, 1.5), one_of(r, 0, 0, 1, -2)
    s = oscillator("e = mu*sign(f)", stop=flat(r, 3, 15), F=F, w=w, k=k, mu=mu, v0=v0)
    net = lambda t, x: F * sin(w * t) - k * x
    side = {"now": copysign(1, v0) if v0 else 0}  # 0 where it sticks

    def stop(t, y):
        side["now"] = 0 if abs(net(t, y[0])) <= mu else copysign(1, net(t, y[0]))
        return [y[0], 0.0]

    def loose(direction):
        def act(t, y):
            side["now"] = direction
            return [y[0], direction * 1e-15]
        return act
    stuck = lambda y: side["now"] == 0
    return s.solved(lambda t, y: [0, 0] if stuck(y) else [y[1], net(t, y[0]) - mu * side["now"]], [0, v0], borders=[
        (lambda t, y: -1 if stuck(y) else -side["now"] * y[1], stop),
        (lambda t, y: net(t, y[0]) - mu if stuck(y) else -1, loose(1)), (lambda t, y: -net(t, y[0]) - mu if stuck(y) else -1, loose(-1))])


@family
def dry_clutch(r):
    """Two rotors that a dry torque brings to one speed; it holds as long as the load allows."""
    J1, J2, T, drive, w1, w2 = U(r, .1, 5), U(r, .1, 5), flat(r, .5, 3), flat(r, -.3, .3), flat(r, -5, 5), flat(r, -5, 5)
    s = Scene(flat(r, 2, 10), 81).parameters(J1=J1, J2=J2, T=T, drive=drive).junctions("z", "a b slip").element("u", "Se", effort="drive")
    s.element("i1", "I", inertance="J1", initial={"f": w1}).element("i2", "I", inertance="J2", initial={"f": w2})
    s.element("plates", "R", law="e = T*sign(f)").bonds("u>a a>i1 a>z z>slip slip>plates z>b b>i2").outputs(w1="i1.f", w2="i2.f")
    way = copysign(1, w1 - w2)
    locked = (w1 - w2) / -((drive - T * way) / J1 - T * way / J2)
    held = drive / (J1 + J2)

    def row(t):
        u = min(t, locked)
        return [w1 + (drive - T * way) / J1 * u + held * (t - u), w2 + T * way / J2 * u + held * (t - u)]
    return s.known(row)


@family
def dead_zone(r):
    """Backlash between two rotors."""
    d, k, J1, J2, T, w, b = flat(r, .05, .5), U(r, 5, 500), flat(r, .1, 2), flat(r, .1, 2), flat(r, .5, 3), flat(r, 1, 6), flat(r, 0, .5)
    s = Scene(flat(r, 5, 15), 101).parameters(d=d, k=k, J1=J1, J2=J2, T=T, w=w, b=b).junctions("z", "a b_").element("u", "Se", effort="T*sin(w*t)")
    s.element("i1", "I", inertance="J1").element("i2", "I", inertance="J2").element("r", "R", resistance="b")
    s.element("gear", "C", law="e = if(abs(q) > d, k*(q - sign(q)*d), 0)").bonds("u>a a>i1 a>z z>gear z>b_ b_>i2 b_>r")
    e = lambda q: k * (q - copysign(d, q)) if abs(q) > d else 0.0
    return s.outputs(w1="i1.f", w2="i2.f", q="gear.q").solved(
        lambda t, y: [(T * sin(w * t) - e(y[2])) / J1, (e(y[2]) - b * y[1]) / J2, y[0] - y[1]], [0, 0, 0],
        borders=[lambda t, y: y[2] - d, lambda t, y: y[2] + d])


@family
def bump_stop(r):
    """A quarter car over a ramp: a damper with two slopes and a stop beside the spring."""
    M, m, k, c, kt, gap = flat(r, 200, 400), flat(r, 30, 60), flat(r, 1e4, 3e4), flat(r, 500, 2000), flat(r, 1e5, 3e5), flat(r, .01, .05)
    kb, h = U(r, 1e5, 1e6), flat(r, .02, .1)
    s = Scene(flat(r, .5, 3), 101).parameters(M=M, m=m, k=k, c=c, kt=kt, gap=gap, kb=kb, h=h).junctions("ground z", "wheel x body")
    s.element("road", "Sf", flow="if(t < 0.05, h/0.05, 0)").element("tyre", "C", capacitance="1/kt").element("im", "I", inertance="m")
    s.element("spring", "C", law="e = k*q + if(q > gap, kb*(q - gap)^2, 0)").element("damper", "R", law="e = if(f > 0, c, 2*c)*f")
    s.element("iM", "I", inertance="M").bonds("road>ground ground>tyre ground>wheel wheel>im wheel>z z>x x>spring x>damper z>body body>iM")

    def rates(t, y):
        tyre, u, q, v = y
        force = k * q + (kb * (q - gap)**2 if q > gap else 0) + (c if u > v else 2 * c) * (u - v)
        return [(h / .05 if t < .05 else 0) - u, (kt * tyre - force) / m, u - v, force / M]
    return s.outputs(v="iM.f", x="spring.q", tyre="tyre.e").solved(
        rates, [0, 0, 0, 0], lambda t, y: [y[3], y[2], kt * y[0]], breaks=[.05], borders=[lambda t, y: y[1] - y[3], lambda t, y: y[2] - gap])


@family
def vehicle(r):
    """Constant power, drag and rolling resistance on a slope."""
    M, c, roll, P, slope = flat(r, 800, 2000), flat(r, .3, .8), flat(r, .01, .02), U(r, 1e4, 1e5), flat(r, -.1, .1)
    s = Scene(flat(r, 10, 100), 101).parameters(M=M, c=c, roll=roll, P=P, slope=slope).junctions(ones="j").element("m", "I", inertance="M", initial={"f": 1})
    s.element("drag", "R", law="e = c*f*abs(f)").element("engine", "MSe", effort="P/max(m.f, 3)")
    s.element("road", "MSe", effort="-roll*M*9.81*tanh(10*m.f) - M*9.81*slope").bonds("engine>j road>j j>m j>drag").outputs(v="m.f")
    return s.solved(lambda t, y: [(P / max(y[0], 3) - c * y[0] * abs(y[0]) - M * 9.81 * (roll * tanh(10 * y[0]) + slope)) / M], [1],
                    borders=[lambda t, y: y[0] - 3])


@family
def parametric(r):
    """Mathieu's equation, also where it is unstable."""
    k, h, w, c = flat(r, .25, 4), flat(r, 0, .9), flat(r, .5, 4), flat(r, 0, .2)
    s = Scene(flat(r, 10, 60), 121).parameters(k=k, h=h, w=w, c=c).junctions(ones="j").element("i", "I", inertance=1).element("d", "R", resistance="c")
    s.element("spring", "C", law="e = k*(1 + h*cos(w*t))*q", initial={"q": 1}).bonds("j>i j>spring j>d").outputs(x="spring.q", v="i.f")
    return s.solved(lambda t, y: [y[1], -k * (1 + h * cos(w * t)) * y[0] - c * y[1]], [1, 0])


@family
def coupled_springs(r):
    """A two-port field whose energy has a product of fourth order."""
    a, b, c, d, m, n = flat(r, 1, 5), flat(r, 1, 5), flat(r, -.9, .9), flat(r, 0, 2), U(r, .2, 5), U(r, .2, 5)
    s = Scene(flat(r, 2, 15), 71).parameters(a=a, b=b, c=c, d=d, m=m, n=n).junctions(ones="x y").element("i", "I", inertance="m", initial={"f": 1})
    s.element("k", "I", inertance="n").element("field", "CC", ports=["u", "v"], initial={"u.q": .3, "v.q": -.5},
                                               energy="a*u.q^2/2 + b*v.q^2/2 + c*u.q*v.q + d*u.q^2*v.q^2/2")
    s.bonds("x>i x>field.u y>k y>field.v").outputs(u="field.u.q", v="field.v.q", e="field.u.e")
    e = lambda u, v: a * u + c * v + d * u * v * v
    return s.solved(lambda t, y: [y[2], y[3], -e(y[0], y[1]) / m, -(b * y[1] + c * y[0] + d * y[1] * y[0]**2) / n], [.3, -.5, 1, 0],
                    lambda t, y: [y[0], y[1], e(y[0], y[1])])


@family
def levitated(r):
    """A ball below a magnet: a mixed field of flux and distance, held by a controller."""
    m, L, a, R, x0 = flat(r, .05, .5), flat(r, .05, .2), flat(r, .005, .02), flat(r, 1, 5), flat(r, .008, .015)
    kp, kd = flat(r, 300, 800), flat(r, 10, 30)
    i0 = sqrt(2 * m * 9.81 * a / L) * (1 + x0 / a)
    flux = L / (1 + x0 / a) * i0
    s = Scene(flat(r, .05, .2), 81).parameters(m=m, L=L, a=a, R=R, x0=x0, kp=kp, kd=kd, i0=i0).junctions(ones="coil fall")
    s.element("magnet", "IC", ports={"l": "p", "x": "q"}, energy="l.p^2*(1 + x.q/a)/(2*L)", initial={"l.p": flux, "x.q": 1.02 * x0})
    s.element("u", "MSe", effort="R*(i0 + kp*(magnet.x.q - x0) + kd*ball.f)").element("r", "R", resistance="R").element("ball", "I", inertance="m")
    s.element("weight", "Se", effort="m*9.81").bonds("u>coil coil>r coil>magnet.l weight>fall fall>ball fall>magnet.x").outputs(x="magnet.x.q", p="magnet.l.p")

    def rates(t, y):
        p, x, v = y
        return [R * (i0 + kp * (x - x0) + kd * v - p * (1 + x / a) / L), v, 9.81 - p * p / (2 * L * a * m)]
    return s.solved(rates, [flux, 1.02 * x0, 0], lambda t, y: [y[1], y[0]])


@family
def hertz(r):
    """A ball on a floor with a stiffness of power 1.5 and a damping of Hunt and Crossley; some bounces."""
    K, c, h, g = U(r, 1e2, 1e5), flat(r, 0, .4), flat(r, .1, 1), 9.81
    s = Scene(flat(r, .8, 2), 101).parameters(K=K, c=c, h=h).signals(y={"integral": "-ball.f", "initial": "h"}).junctions(ones="j")
    s.element("ball", "I", inertance=1).element("weight", "Se", effort=g)
    s.element("floor_", "MSe", effort="-if(y < 0, K*(-y)^1.5*max(1 + c*ball.f, 0), 0)").bonds("weight>j floor_>j j>ball").outputs(y="y", v="ball.f")
    push = lambda y, v: K * (-y)**1.5 * max(1 + c * v, 0) if y < 0 else 0.0
    return s.solved(lambda t, y: [-y[1], g - push(*y)], [h, 0], borders=[lambda t, y: y[0], lambda t, y: 1 + c * y[1]])


@family
def bungee(r):
    """A rope that only pulls, and the drag of air."""
    k, L, m, d = flat(r, 40, 200), flat(r, 5, 20), flat(r, 50, 100), flat(r, .1, 1)
    s = Scene(flat(r, 5, 25), 101).parameters(k=k, L=L, m=m, d=d).junctions(ones="j").element("body", "I", inertance="m").element("weight", "Se", effort="m*9.81")
    s.element("rope", "C", law="e = k*max(q - L, 0)").element("drag", "R", law="e = d*f*abs(f)").bonds("weight>j j>body j>rope j>drag").outputs(x="rope.q", v="body.f")
    return s.solved(lambda t, y: [y[1], 9.81 - (k * max(y[0] - L, 0) + d * y[1] * abs(y[1])) / m], [0, 0],
                    borders=[lambda t, y: y[0] - L, lambda t, y: y[1]])


@family
def encoder_servo(r):
    """A sampled controller that sees the angle in ticks."""
    Ts, tick, J, b, kp, kd, goal = U(r, .002, .02), U(r, 1e-3, .05), U(r, .05, .5), U(r, .05, .5), flat(r, 1, 6), flat(r, .05, .4), flat(r, .5, 3)
    s = Scene(flat(r, .5, 2), 101).parameters(Ts=Ts, tick=tick, J=J, b=b, kp=kp, kd=kd, goal=goal)
    s.signals(angle={"integral": "rotor.f"}, seen={"value": "tick*round(angle/tick)", "every": "Ts"},
              u={"value": "min(max(kp*(goal - seen) - kd*(seen - previous(seen))/Ts, -3), 3)", "every": "Ts"})
    s.junctions(ones="shaft").element("m", "MSe", effort="u").element("rotor", "I", inertance="J").element("r", "R", resistance="b")
    s.bonds("m>shaft shaft>rotor shaft>r").outputs(angle="angle", w="rotor.f")

    def answer():
        angle = w = u = seen = 0.0
        t, n, rows = 0.0, 0, []
        ahead = lambda d: (angle + u / b * d + (w - u / b) * J / b * (1 - exp(-b / J * d)), u / b + (w - u / b) * exp(-b / J * d))
        for at in s.times:
            while n * Ts <= at * (1 + 1e-13):
                angle, w = ahead(n * Ts - t)
                t, last, n = n * Ts, seen, n + 1
                seen = tick * copysign(floor(abs(angle / tick) + .5), angle)
                u = min(max(kp * (goal - seen) - kd * (seen - last) / Ts, -3), 3)
            rows.append(ahead(at - t))
        return rows
    return s.computed(answer)


@family
def stepper(r):
    """A motor that follows steps of its command; damped, so that it does not lose any."""
    J, K, rate = U(r, 1e-4, 1e-3), flat(r, .1, 1), flat(r, 1, 20)
    b, T = sqrt(50 * K * J) * flat(r, .2, 1), flat(r, 0, .05)
    s = Scene(flat(r, .3, 1), 101).parameters(J=J, K=K, b=b, T=T, rate=rate).junctions(ones="j").element("rotor", "I", inertance="J")
    s.signals(angle={"integral": "rotor.f"}, command="floor(rate*t)*pi/100").element("r", "R", resistance="b").element("load", "Se", effort="-T")
    s.element("m", "MSe", effort="-K*sin(50*(angle - command))").bonds("load>j m>j j>rotor j>r").outputs(angle="angle", w="rotor.f")
    return s.solved(lambda t, y: [y[1], (-K * sin(50 * (y[0] - floor(rate * t) * pi / 100)) - b * y[1] - T) / J], [0, 0],
                    breaks=[n / rate for n in range(1, 30)])


@family
def elastic_pendulum(r):
    """A mixed field of length, angle and their momenta."""
    m, k, L, g, r0, a0 = flat(r, .5, 3), flat(r, 20, 300), flat(r, .5, 2), 9.81, flat(r, .9, 1.3), flat(r, -2, 2)
    s = Scene(flat(r, 2, 8), 81).parameters(m=m, k=k, L=L).junctions(ones="radial turn")
    s.element("body", "IC", ports={"r": "q", "pr": "p", "a": "q", "pa": "p"}, initial={"r.q": r0 * L, "a.q": a0},
              energy="pr.p^2/(2*m) + pa.p^2/(2*m*r.q^2) + k*(r.q - L)^2/2 - 9.81*m*r.q*cos(a.q)")
    s.bonds("radial>body.r radial>body.pr turn>body.a turn>body.pa").outputs(r="body.r.q", a="body.a.q", w="turn.f")

    def rates(t, y):
        x, pr, a, pa = y
        return [pr / m, pa * pa / (m * x**3) - k * (x - L) + m * g * cos(a), pa / (m * x * x), -m * g * x * sin(a)]
    return s.solved(rates, [r0 * L, 0, a0, 0], lambda t, y: [y[0], y[2], y[3] / (m * y[0]**2)])


@family
def kepler(r):
    """An orbit, by Kepler's equation, to an eccentricity of 0.95."""
    e, turns = flat(r, 0, .95), flat(r, .5, 5)
    s = Scene(turns * 2 * pi, 121).parameters(e=e).only_signals().outputs(x="x", y="y", u="u")
    s.signals(d="hypot(x, y)", x={"integral": "u", "initial": "1 - e"}, y={"integral": "v", "initial": 0}, u={"integral": "-x/d^3", "initial": 0},
              v={"integral": "-y/d^3", "initial": "sqrt((1 + e)/(1 - e))"})

    def row(t):
        E = pi
        low, high = t - 1.0, t + 1.0
        for _ in range(200):
            E = (low + high) / 2
            low, high = (E, high) if E - e * sin(E) < t else (low, E)
        speed = 1 / (1 - e * cos(E))
        return [cos(E) - e, sqrt(1 - e * e) * sin(E), -sin(E) * speed]
    return s.known(row)


@family
def rocket(r):
    """A mass that shrinks while it burns; its momentum is that of what is left. Drag of the square."""
    m0, rate, burn, thrust, c = flat(r, 10, 50), flat(r, .2, 1), flat(r, 5, 20), flat(r, 300, 900), flat(r, .001, .05)
    s = Scene(flat(r, 10, 40), 101).parameters(m0=m0, rate=rate, burn=burn, thrust=thrust, c=c).junctions(ones="j")
    s.signals(m="m0 - rate*min(t, burn)", v={"integral": "(if(t < burn, thrust, 0) - c*v*abs(v))/m - 9.81"}, h={"integral": "v"})
    s.element("u", "MSe", effort="v").element("r", "R", resistance=1).bonds("u>j j>r").outputs(v="v", h="h", power="u.f")
    m = lambda t: m0 - rate * min(t, burn)
    return s.solved(lambda t, y: [((thrust if t < burn else 0) - c * y[0] * abs(y[0])) / m(t) - 9.81, y[0]], [0, 0],
                    lambda t, y: [y[0], y[1], y[0]], breaks=[burn], borders=[lambda t, y: y[0]])


@family
def fluid_coupling(r):
    """An engine with a torque from a table drives a load through a torque of the square of the slip."""
    J1, J2, k, load = flat(r, .05, .5), U(r, .5, 10), U(r, .002, .05), U(r, .001, .05)
    s = Scene(flat(r, 5, 40), 101).parameters(J1=J1, J2=J2, k=k, load=load).junctions("z", "a b slip")
    speeds, torques = [-10, 0, 50, 150, 300, 500], [120, 120, 150, 180, 120, 0]
    s.files["engine.csv"] = "w,T\n" + "".join(f"{a},{b}\n" for a, b in zip(speeds, torques))
    s.element("engine", "MSe", effort="table('engine.csv', 'T', i1.f)").element("i1", "I", inertance="J1", initial={"f": 20}).element("i2", "I", inertance="J2")
    s.element("oil", "R", law="e = k*f*abs(f)").element("fan", "R", law="e = load*f*abs(f)").bonds("engine>a a>i1 a>z z>slip slip>oil z>b b>i2 b>fan")

    def torque(w):
        n = next(n for n in range(1, 6) if w <= speeds[n] or n == 5)
        return torques[n - 1] + (torques[n] - torques[n - 1]) * (w - speeds[n - 1]) / (speeds[n] - speeds[n - 1])

    def rates(t, y):
        oil = k * (y[0] - y[1]) * abs(y[0] - y[1])
        return [(torque(y[0]) - oil) / J1, (oil - load * y[1] * abs(y[1])) / J2]
    return s.outputs(w1="i1.f", w2="i2.f").solved(rates, [20, 0], borders=[lambda t, y, at=at: y[0] - at for at in speeds[1:-1]])


@family
def stribeck(r):
    """A block on a belt: friction that falls with the speed of slip, and holds."""
    k, v, Fs, Fc, vs, d = flat(r, 1, 10), flat(r, .05, .5), flat(r, 1.2, 2), flat(r, .5, 1), flat(r, .1, .5), flat(r, 0, .1)
    s = Scene(flat(r, 10, 40), 101).parameters(k=k, v=v, Fs=Fs, Fc=Fc, vs=vs, d=d).junctions("z", "body slip").element("belt", "Sf", flow="v")
    s.element("m", "I", inertance=1).element("c", "C", capacitance="1/k").element("damp", "R", resistance="d")
    s.element("friction", "R", law="e = sign(f)*(Fc + (Fs - Fc)*exp(-abs(f)/vs))").bonds("belt>z z>slip slip>friction z>body body>m body>c body>damp")
    side = {"now": 0}
    pull = lambda t, y: k * y[0] + d * y[1]

    def slips(direction):
        def act(t, y):
            side["now"] = direction
            return [y[0], y[1] - 1e-14 * direction]
        return act

    def stops(t, y):
        side["now"] = 0 if abs(k * y[0] + d * v) <= Fs else -side["now"]
        return [y[0], v]

    def rates(t, y):
        if side["now"] == 0:
            return [v, 0.0]
        return [y[1], side["now"] * (Fc + (Fs - Fc) * exp(-abs(v - y[1]) / vs)) - pull(t, y)]
    # it starts at rest: the belt slips past it
    side["now"] = 1
    return s.outputs(x="c.q", v="m.f").solved(rates, [0, 0], borders=[
        (lambda t, y: -side["now"] * (v - y[1]) if side["now"] else -1, stops), (lambda t, y: pull(t, y) - Fs if side["now"] == 0 else -1, slips(1)),
        (lambda t, y: -pull(t, y) - Fs if side["now"] == 0 else -1, slips(-1))])
