"""Circuits of ideal diodes and switches against the equations of their nodes."""
import math

from network import Network, sine, steady
from scenes import between as U, family


def of(network, stop, outputs, steps=400, breaks=(), sides_at=None, **keys):
    scene = network.scene(stop, outputs, **keys)
    scene.answer = lambda: network.answer(scene.times, outputs, steps, breaks, sides_at)
    return scene


@family
def half_wave_rc(r):
    R, RL, w, V = U(r, .1, 10), U(r, 5, 500), U(r, .1, 1e4), U(r, .1, 1e3)
    C = U(r, .05, 20) / (w * RL)
    n = Network().add("V", "v", 1, 0, sine(V, w, r.uniform(0, 6))).add("R", "rs", 1, 2, R).add("D", "d", 2, 3)
    return of(n.add("C", "c", 3, 0, C).add("R", "rl", 3, 0, RL), 30 / w, ["c"], 800)


@family
def half_wave_rl(r):
    R, w, V = U(r, .1, 10), U(r, .1, 1e4), U(r, .1, 1e3)
    n = Network().add("V", "v", 1, 0, sine(V, w, r.uniform(0, 6), V * r.uniform(-.5, .5))).add("D", "d", 1, 2)
    return of(n.add("R", "r", 2, 3, R).add("L", "l", 3, 0, U(r, .1, 10) * R / w), 40 / w, ["l"])


@family
def half_wave_rlc(r):
    w, V, RL = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 1, 100)
    C, L, R = U(r, .1, 10) / (w * RL), U(r, .01, 1) * RL / w, RL * U(r, .01, .3)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("R", "r", 1, 2, R).add("L", "l", 2, 3, L).add("D", "d", 3, 4)
    return of(n.add("C", "c", 4, 0, C).add("R", "rl", 4, 0, RL), 40 / w, ["c", "l"], 800)


@family
def peak_rectifier(r):
    """Without resistance: the capacitor is tied to the source while the diode conducts."""
    w, V, RL = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 1, 100)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("D", "d", 1, 2).add("C", "c", 2, 0, U(r, .3, 30) / (w * RL))
    return of(n.add("R", "rl", 2, 0, RL), 25 / w, ["c"])


@family
def freewheel(r):
    w, V, R = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 1, 100)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("D", "d", 1, 2).add("D", "free", 0, 2)
    return of(n.add("R", "r", 2, 3, R).add("L", "l", 3, 0, U(r, .1, 30) * R / w), 30 / w, ["l"])


@family
def doubler(r):
    w, V, RL = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 10, 1000)
    R, C1, C2 = RL * U(r, .001, .05), U(r, 1, 30) / (w * RL), U(r, 1, 30) / (w * RL)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("R", "rs", 1, 2, R).add("C", "c1", 2, 3, C1).add("D", "d1", 0, 3)
    return of(n.add("D", "d2", 3, 4).add("C", "c2", 4, 0, C2).add("R", "rl", 4, 0, RL), 60 / w, ["c1", "c2"], 1600)


@family
def doubler_ideal(r):
    w, V, RL = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 10, 1000)
    C1, C2 = U(r, 1, 30) / (w * RL), U(r, 1, 30) / (w * RL)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("C", "c1", 1, 3, C1).add("D", "d1", 0, 3)
    return of(n.add("D", "d2", 3, 4).add("C", "c2", 4, 0, C2).add("R", "rl", 4, 0, RL), 40 / w, ["c1", "c2"])


@family
def multiplier(r):
    w, V, RL = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 100, 1000)
    C = U(r, 10, 100) / (w * RL)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("R", "rs", 1, 2, RL * U(r, 1e-3, 1e-2))
    stages = int(r.integers(2, 4))
    top, bottom = 2, 0
    at = 3
    for k in range(stages):
        n.add("C", f"a{k}", top, at, C).add("D", f"d{k}", bottom, at).add("D", f"e{k}", at, at + 1)
        n.add("C", f"b{k}", at + 1, bottom, C)
        top, bottom = at, at + 1
        at += 2
    return of(n.add("R", "rl", bottom, 0, RL), 40 / w, ["a0", f"b{stages - 1}"], 1600)


@family
def bridge_c(r):
    w, V, RL = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 10, 1000)
    n = Network().add("V", "v", 1, 4, sine(V, w)).add("R", "rs", 1, 2, RL * U(r, .001, .2))
    n.add("D", "d1", 2, 3).add("D", "d2", 4, 3).add("D", "d3", 0, 2).add("D", "d4", 0, 4)
    return of(n.add("C", "c", 3, 0, U(r, .3, 30) / (w * RL)).add("R", "rl", 3, 0, RL), 30 / w, ["c"], 800)


@family
def bridge_rl(r):
    w, V, R = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 1, 100)
    n = Network().add("V", "v", 1, 4, sine(V, w))
    n.add("D", "d1", 1, 3).add("D", "d2", 4, 3).add("D", "d3", 0, 1).add("D", "d4", 0, 4)
    return of(n.add("R", "r", 3, 5, R).add("L", "l", 5, 0, U(r, .1, 10) * R / w), 30 / w, ["l"])


@family
def bridge_line_coil(r):
    w, V, RL = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 10, 1000)
    n = Network().add("V", "v", 1, 4, sine(V, w)).add("L", "ls", 1, 6, RL * U(r, .01, .5) / w).add("R", "rs", 6, 2, RL * U(r, .01, .1))
    n.add("D", "d1", 2, 3).add("D", "d2", 4, 3).add("D", "d3", 0, 2).add("D", "d4", 0, 4)
    return of(n.add("C", "c", 3, 0, U(r, .3, 30) / (w * RL)).add("R", "rl", 3, 0, RL), 30 / w, ["c", "ls"], 800)


def b6(r, coils, load):
    w, V, R = U(r, 1, 1e3), U(r, 1, 1e3), U(r, 1, 100)
    n = Network()
    for k in range(3):
        n.add("V", f"v{k}", 1 + k, 0, sine(V, w, -2 * math.pi / 3 * k + .1))
        if coils:
            n.add("L", f"l{k}", 1 + k, 4 + k, R * coils / w)
        n.add("D", f"u{k}", (4 if coils else 1) + k, 7).add("D", f"d{k}", 8, (4 if coils else 1) + k)
    n.add("R", "leak", 8, 0, 300 * R)
    if load == "rl":
        n.add("R", "r", 7, 9, R).add("L", "l", 9, 8, R * U(r, .1, 5) / w)
        out = ["l"]
    else:
        n.add("R", "r", 7, 8, R).add("C", "c", 7, 8, U(r, .1, 10) / R / w)
        out = ["c"]
    return of(n, 20 / w, out + (["l0"] if coils else []), 400)


@family
def b6_rl(r):
    return b6(r, 0, "rl")


@family
def b6_coils_rl(r):
    return b6(r, U(r, .02, .3), "rl")


@family
def b6_coils_rc(r):
    return b6(r, U(r, .05, .3), "rc")


@family
def half_three_phase(r):
    w, V, R = U(r, 1, 1e3), U(r, 1, 1e3), U(r, 1, 100)
    n, x = Network(), U(r, .02, .5)
    for k in range(3):
        n.add("V", f"v{k}", 1 + k, 0, sine(V, w, -2 * math.pi / 3 * k + .3)).add("R", f"r{k}", 1 + k, 4 + k, R * x)
        n.add("D", f"u{k}", 4 + k, 7)
    return of(n.add("R", "r", 7, 0, R).add("C", "c", 7, 0, U(r, .1, 10) / R / w), 20 / w, ["c"])


@family
def clamp(r):
    """Limits a sine between two thresholds behind a resistance, with a capacitor."""
    w, V, R = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 1, 100)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("R", "r", 1, 2, R).add("C", "c", 2, 0, U(r, .1, 3) / w / R)
    n.add("R", "ra", 2, 3, R * .01).add("D", "a", 3, 0, V * .4).add("R", "rb", 2, 4, R * .02).add("D", "b", 0, 4, V * .3)
    return of(n, 25 / w, ["c"], 800)


@family
def clamp_hard(r):
    """The same without resistances: the capacitor is held at the threshold."""
    w, V, R = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 1, 100)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("R", "r", 1, 2, R).add("C", "c", 2, 0, U(r, .1, 3) / w / R)
    return of(n.add("D", "a", 2, 0, V * .4).add("D", "b", 0, 2, V * .3), 25 / w, ["c"])


def modulated(r, boost):
    V, T, R = U(r, 1, 400), U(r, 1e-6, 1e-3), U(r, 1, 100)
    duty = round(r.uniform(.2, .7), 3)
    L, C = R * T * U(r, .05, 3), T * U(r, 2, 50) / R
    periods = 25
    n = Network().add("V", "v", 1, 0, steady(V))
    closed = (f"t/{T!r} - floor(t/{T!r}) < {duty!r}",)
    if boost:
        n.add("L", "l", 1, 2, L).add("S", "s", 2, 0, closed).add("D", "d", 2, 3)
    else:
        n.add("S", "s", 1, 2, closed).add("D", "d", 0, 2).add("L", "l", 2, 3, L)
    n.add("C", "c", 3, 0, C).add("R", "r", 3, 0, R)
    breaks = [k * T for k in range(1, periods)] + [(k + duty) * T for k in range(periods)]
    return of(n, periods * T, ["l", "c"], 500, breaks, lambda t: ((t / T) % 1 < duty,))


@family
def buck(r):
    return modulated(r, False)


@family
def boost(r):
    return modulated(r, True)


@family
def check_valves(r):
    """A piston pump between two check valves, with accumulators: flows through orifices that are linear."""
    w, P, R = U(r, 1, 50), U(r, 1e5, 1e7), U(r, 1e8, 1e11)
    n = Network().add("V", "suck", 1, 0, steady(P * .1)).add("R", "r1", 1, 2, R * .1).add("D", "in", 2, 3)
    n.add("V", "drive", 6, 0, sine(P, w)).add("C", "piston", 6, 3, U(r, .3, 3) / w / R, P * .05)
    n.add("D", "out", 3, 4).add("R", "r2", 4, 5, R * .1).add("C", "acc", 5, 0, U(r, 1, 30) / w / R).add("R", "load", 5, 0, R)
    return of(n, 30 / w, ["acc", "piston"], 800)


@family
def leaky_diode(r):
    """A leak of 1e9 to 1e18 times the load beside the diode."""
    w, V, R = U(r, 1, 1e4), U(r, 1, 1e3), U(r, 1, 100)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("R", "rs", 1, 2, R * .1).add("D", "d", 2, 3).add("R", "leak", 2, 3, R * U(r, 1e9, 1e18))
    return of(n.add("C", "c", 3, 0, U(r, .3, 30) / w / R).add("R", "rl", 3, 0, R), 30 / w, ["c"], 800)


@family
def one_way_charge(r):
    """Two capacitors of other charge that a diode joins through a coil: half of an oscillation."""
    C1, C2, L = U(r, 1e-6, 1), U(r, 1e-6, 1), U(r, 1e-6, 1)
    w = math.sqrt((1 / C1 + 1 / C2) / L)
    n = Network().add("C", "c1", 1, 0, C1, 5.0).add("L", "l", 1, 2, L).add("D", "d", 2, 3).add("C", "c2", 3, 0, C2, 1.0)
    return of(n, 6 / w, ["c1", "c2", "l"])


class Square:
    """A square wave, which is what it is in the middle of the present half period up to its end."""

    def __init__(self, high, low, period):
        self.high, self.low, self.period, self.now = high, low, period, high
        self.text = f"if(mod(t, {period!r}) < {period / 2!r}, {high!r}, {low!r})"

    def hold(self, middle):
        self.now = self.high if (middle / self.period) % 1 < .5 else self.low
        return ()

    def __call__(self, t):
        return self.now


@family
def jump_through_diode(r):
    """A square wave behind a resistance into a diode and a capacitor."""
    T, V, R = U(r, 1e-4, 10), U(r, 1, 1e3), U(r, 1, 100)
    wave = Square(V, -V, T)
    n = Network().add("V", "v", 1, 0, (wave.text, wave)).add("R", "rs", 1, 2, R).add("D", "d", 2, 3)
    n.add("C", "c", 3, 0, U(r, .1, 10) * T / R).add("R", "rl", 3, 0, R * U(r, 1, 30))
    return of(n, 5.25 * T, ["c"], 300, [k * T / 2 for k in range(1, 11)], wave.hold)


@family
def random_network(r):
    """A tree of nodes, each with a store or resistance to the ground; diodes form no circle."""
    w, V, R = U(r, 1, 1e3), U(r, 1, 100), U(r, 1, 100)
    n = Network().add("V", "v", 1, 0, sine(V, w, r.uniform(0, 6), V * r.uniform(-.3, .3)))
    size = int(r.integers(2, 6))
    out = []
    linked = set()
    for k in range(2, 2 + size):
        to = int(r.integers(1, k))
        a, b = (to, k) if r.random() < .6 else (k, to)
        kind = r.choice(["D", "D", "R", "L", "RD"])
        if kind == "D" and to != 1:
            n.add("D", f"d{k}", a, b)
        elif kind == "R":
            n.add("R", f"r{k}", a, b, R * U(r, .1, 10))
        elif kind == "L":
            n.add("L", f"l{k}", a, b, R * U(r, .1, 10) / w)
            out.append(f"l{k}")
        else:
            n.add("R", f"r{k}", to, 100 + k, R * U(r, .1, 1)).add("D", f"d{k}", 100 + k if a == to else k, k if a == to else 100 + k)
        if r.random() < .6:
            n.add("C", f"c{k}", k, 0, U(r, .2, 5) / w / R, V * r.uniform(-1, 1))
            out.append(f"c{k}")
        if r.random() < .5 or f"c{k}" not in out:
            n.add("R", f"g{k}", k, 0, R * U(r, 1, 30))
    if not any(o[0] == "c" for o in out):
        n.add("C", "cx", 1 + size, 0, U(r, .2, 5) / w / R)
        out.append("cx")
    return of(n, 15 / w, out, 400)


@family
def two_sources(r):
    """The larger of two sources feeds a load with a coil."""
    w, V, R = U(r, 1, 1e3), U(r, 1, 100), U(r, 1, 100)
    n = Network().add("V", "v1", 1, 0, sine(V, w)).add("V", "v2", 2, 0, sine(V * .8, 1.37 * w, 1)).add("D", "d1", 1, 3).add("D", "d2", 2, 3)
    n.add("D", "free", 0, 3)
    return of(n.add("R", "r", 3, 4, R).add("L", "l", 4, 0, U(r, .1, 10) * R / w), 20 / w, ["l"])


@family
def snubber(r):
    """A coil that a diode cuts off rings with a capacitor across the diode."""
    w, V, R = U(r, 1, 1e3), U(r, 1, 100), U(r, 1, 100)
    L = R * U(r, .1, 1) / w
    C = 1 / (L * (w * U(r, 5, 30)) ** 2)
    n = Network().add("V", "v", 1, 0, sine(V, w)).add("L", "l", 1, 2, L).add("D", "d", 2, 3).add("R", "r", 3, 0, R)
    return of(n.add("R", "rd", 2, 4, math.sqrt(L / C)).add("C", "c", 4, 3, C), 15 / w, ["l", "c"], 1600)
