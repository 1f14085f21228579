"""One case of bench/compare.cpp by scipy.integrate.solve_ivp, with the Jacobian: compare_scipy.py CASE METHOD RELATIVE STOP TIMES
prints the processor time of the integration, its steps, then each output at all times in a line."""
import math
import sys
import time

import numpy
from scipy.integrate import solve_ivp
from scipy.sparse import diags

case, method = sys.argv[1], sys.argv[2]
relative, stop, count = float(sys.argv[3]), float(sys.argv[4]), int(sys.argv[5])
times = numpy.linspace(0.0, stop, count)
extra = {}

if case.startswith("bellow"):
    area, stiffness, damping, kp, kd, amplitude, mass, delta = 0.0096, 350.0, 0.4, 40.0, 10.0, 0.3, 0.015, 1e-3
    orifice, compliance = 0.8 * 0.008, 0.0096 * 0.3 / (1.225 * 8.31451 * 300.0)
    unit, supply = (0.0, 10937.5) if case == "bellow step" else (1e5, 0.0)

    def pump(t, x, v):
        return supply + unit * (kp * (amplitude * math.sin(t) - x) + kd * (amplitude * math.cos(t) - v))

    def flow(drop):
        return orifice * drop / math.sqrt(math.hypot(drop, delta))

    def rates(t, y):
        q, x, p = y
        v, pressure = p / mass, (q - area * x) / compliance
        return [flow(pump(t, x, v) - pressure), v, area * pressure - stiffness * x - damping * v]

    def jacobian(t, y):
        q, x, p = y
        drop = pump(t, x, p / mass) - (q - area * x) / compliance
        size = math.hypot(drop, delta)
        slope = orifice * (0.5 * drop * drop + delta * delta) / (size * size * math.sqrt(size))
        return numpy.array([
            [-slope / compliance, slope * (area / compliance - unit * kp), -slope * unit * kd / mass],
            [0.0, 0.0, 1.0 / mass],
            [area / compliance, -area * area / compliance - stiffness, -damping / mass]])

    def outputs(t, y):
        q, x, p = y
        first, second = pump(t, x, p / mass), (q - area * x) / compliance
        return [x, amplitude * math.sin(t), first, second, flow(first - second)]

    start, scale = numpy.zeros(3), numpy.array([3e-3, 0.3, 5e-3])
    extra["jac"] = jacobian
elif case.startswith("ladder"):
    n = int(case.split()[1])
    g = float(n) * n
    start, scale = numpy.zeros(n), numpy.ones(n)

    def rates(t, y):
        f = -2.0 * y
        f[1:] += y[:-1]
        f[:-1] += y[1:]
        f[0] += 1.0
        f[-1] += y[-1]
        return g * f

    middle = numpy.full(n, -2.0 * g)
    middle[-1] = -g
    if method == "LSODA":
        packed = numpy.zeros((4, n))  # with as many rows of zeros below as there are bands there
        packed[0, 1:], packed[1], packed[2, :-1] = g, middle, g
        extra.update(jac=lambda t, y: packed, lband=1, uband=1)
    else:
        extra["jac"] = diags([numpy.full(n - 1, g), middle, numpy.full(n - 1, g)], [-1, 0, 1], format="csc")

    def outputs(t, y):
        return [y[k * n // 10 - 1] for k in range(1, 11)]
else:
    sys.exit(f"no case {case}")

begin = time.process_time()
solution = solve_ivp(rates, (0.0, stop), start, method=method, t_eval=times, rtol=relative, atol=relative * scale, **extra)
seconds = time.process_time() - begin
if not solution.success:
    sys.exit(solution.message)
print(seconds, solution.nfev)
for row in zip(*(outputs(t, y) for t, y in zip(solution.t, solution.y.T))):
    print(*(repr(float(value)) for value in row))
