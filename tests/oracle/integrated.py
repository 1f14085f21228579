"""Reference solutions by SciPy's integrators at tight tolerances, which stop at every border that is named."""
import numpy as np
from scipy.integrate import solve_ivp

STEPS = 300  # at least so many: what happens in a step is seen at its ends
MANY = 5000  # borders met


def solution(rates, start, times, borders=(), breaks=(), stiff=False, relative=None, absolute=1e-13, longest=None):
    """Array of times by states.

    borders  functions of (t, y), or pairs of one with what happens where it comes to 0 on its way up: the state after it, or None. The
             integration stops and goes on there, so that `rates` may have a kink or a jump
    breaks   times of the same kind
    """
    both = [b if isinstance(b, tuple) else (b, None) for b in borders]
    watched = []
    for value, act in both:
        def watch(t, y, value=value):
            return value(t, y)
        watch.terminal, watch.direction = True, 1 if act else 0
        watched.append(watch)
    times = np.asarray(times, float)
    found = np.full((len(times), len(start)), np.nan)
    t, y, end = times[0], np.array(start, float), times[-1]
    tiny = 1e-13 * max(abs(t), abs(end), end - t)
    keys = {"method": "Radau" if stiff else "DOP853", "rtol": relative or (1e-11 if stiff else 1e-12), "atol": absolute,
            "max_step": longest or (end - t) / STEPS, "dense_output": True}
    ends = sorted(b for b in breaks if t + tiny < b < end - tiny) + [end]
    met, clear = 0, t - tiny  # up to `clear`, borders that change nothing are not looked at: one that has just been met is still near
    for stop in ends:
        while stop - t > tiny:
            to = min(clear, stop) if clear > t + tiny else stop
            events = [w for w, (_, act) in zip(watched, both) if act or to == stop]
            # within a piece, rates are never asked for beyond it
            done = solve_ivp(lambda s, x, a=t, b=stop: rates(min(max(s, a + tiny / 9), b - tiny / 9), x), (t, to), y, events=events or None, **keys)
            if done.status < 0:
                raise ArithmeticError(done.message)
            here = (times >= t - tiny) & (times <= done.t[-1] + tiny)
            if here.any():
                found[here] = done.sol(np.clip(times[here], t, done.t[-1])).T
            t, y = done.t[-1], done.y[:, -1].copy()
            for watch, at in zip(events, done.t_events or ()):
                act = both[watched.index(watch)][1]
                after = act(t, y) if act and len(at) else None
                if after is not None:
                    y = np.array(after, float)
                    found[abs(times - t) <= tiny] = y
            if done.status == 1:
                met, clear = met + 1, t + 1e-8 * (end - times[0])
            if met > MANY:
                raise ArithmeticError(f"{MANY} borders up to t = {t:g}")
        t = stop
    return found
