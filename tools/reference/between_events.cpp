/// References of models that go from event to event: closed forms and series in 50 digits, and two integrations that
/// each find their own events. Writes NAME.SCENE.csv into the folder given.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "digits.hpp"
#include "integrate.hpp"

namespace {

using namespace reference;

/// i' + i = sign sin t in each half period from its firing on; the current of the half before is taken over.
void thyristor_bridge(const std::string& folder, const std::string& scene, double angle) {
  const Number alpha = given(angle);
  Number begin = alpha, start = 0, sign = 1;
  const auto forced = [](const Number& t) { return Number((sin(t) - cos(t)) / 2); };
  const auto current = [&](const Number& t) {
    const Number i = sign * forced(t) + (start - sign * forced(begin)) * exp(begin - t);
    // From half a radian on it can only come down to zero, where it stays.
    return t > begin + Number(0.5) && i < 0 ? Number(0) : i;
  };
  write(folder, "thyristor_bridge." + scene, {"t", "i", "u"}, 18, 181, [&](const Number& t) {
    if (t < alpha) return std::vector<Number>{0, 0};
    while (t >= begin + kPi) {
      start = current(begin + kPi);
      begin += kPi;
      sign = -sign;
    }
    const Number i = current(t);
    return std::vector<Number>{i, i > 0 || t == begin ? Number(sign * sin(t)) : Number(0)};
  });
}

/// y' = a y + b over a time h, by the series of the exponential.
struct Linear {
  std::vector<std::vector<Number>> a;
  std::vector<Number> b;
  [[nodiscard]] std::vector<Number> after(const std::vector<Number>& y, const Number& h) const {
    const auto times_a = [&](const std::vector<Number>& x) {
      std::vector<Number> product(x.size(), 0);
      for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t j = 0; j < x.size(); ++j)
          if (a[i][j] != 0) product[i] += a[i][j] * x[j];
      return product;
    };
    std::vector<Number> sum = y, term = times_a(y);
    for (std::size_t i = 0; i < y.size(); ++i) term[i] += b[i];
    Number factor = h;
    for (int k = 2; k < 70; ++k) {
      for (std::size_t i = 0; i < y.size(); ++i) sum[i] += factor * term[i];
      term = times_a(term);
      factor *= h / k;
    }
    return sum;
  }
};

/// Flow and volume of each of four sections of the pipe. The check valve is looked at every hundredth of a record, and
/// the instant at which it goes to its other side found by bisection.
void water_hammer(const std::string& folder) {
  const int n = 4;
  const Number p0 = given(4e5), inertance = given(2e6), compliance = given(5e-10), friction = given(2e6),
               consumer = given(3.2e7);
  const auto system = [&](bool conducts, bool open) {
    Linear s{std::vector<std::vector<Number>>(2 * n, std::vector<Number>(2 * n, 0)), std::vector<Number>(2 * n, 0)};
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t flow = 2 * k, volume = 2 * k + 1;
      if (k > 0 || conducts) {
        s.a[flow][flow] = -friction / inertance;
        s.a[flow][volume] = -1 / (compliance * inertance);
        if (k > 0) s.a[flow][volume - 2] = 1 / (compliance * inertance);
        if (k == 0) s.b[flow] = p0 / inertance;
      }
      s.a[volume][flow] = 1;
      if (k + 1 < n) s.a[volume][flow + 2] = -1;
      if (k + 1 == n && open) s.a[volume][volume] = -1 / (compliance * consumer);
    }
    return s;
  };
  std::vector<Number> y(2 * n, 0);
  Number now = 0;
  bool conducts = true;
  const auto open = [&] { return now < given(1.5) || now >= given(2.5); };
  const auto beyond = [&](const std::vector<Number>& at) { return conducts ? at[0] < 0 : at[1] / compliance < p0; };
  const auto advance = [&](const Number& until) {
    while (now < until) {
      const Linear s = system(conducts, open());
      const Number h = std::min<Number>(until - now, given(5e-5));
      std::vector<Number> end = s.after(y, h);
      if (!beyond(end)) {
        y = end;
        now += h;
        continue;
      }
      Number low = 0, high = h;
      for (int i = 0; i < 170; ++i) {
        const Number middle = (low + high) / 2;
        (beyond(s.after(y, middle)) ? high : low) = middle;
      }
      y = s.after(y, high);
      now += high;
      conducts = !conducts;
      y[0] = 0;
    }
  };
  write(folder, "water_hammer.closure", {"t", "p_in", "p_out", "Q_in", "Q_out"}, 4, 801, [&](const Number& t) {
    for (const Number& edge : {given(1.5), given(2.5)})
      if (now < edge && edge <= t) {
        advance(edge);
        now = edge;
      }
    advance(t);
    now = t;
    const Number out = y[2 * n - 1] / compliance;
    return std::vector<Number>{y[1] / compliance, out, y[0], open() ? Number(out / consumer) : Number(0)};
  });
}

/// Lines: constant torques between the changes.
void gear_shift(const std::string& folder) {
  const Number te = 100, tb = -30, load = 80, tc = 250, je = given(0.2), js = given(0.05), jv = 20, n1 = 6, n2 = 3;
  Number now = 0, engine = 150, shaft = 0, wheels = 0;
  bool locked = false, shifted = false;
  const auto advance = [&](const Number& until) {
    while (now < until) {
      const bool grips = now < 3 || now >= given(3.3), first = now < given(3.1), second = now >= given(3.2);
      const Number n = first ? n1 : n2;
      if (second && !shifted) {
        wheels = (jv * wheels + n2 * js * shaft) / (jv + n2 * n2 * js);
        shaft = n2 * wheels;
        shifted = true;
      }
      locked = locked && grips;
      const Number torque = grips ? te : tb;
      Number h = until - now;
      if (!first && !second) {
        engine += torque / je * h;
        wheels -= load / jv * h;
      } else if (locked) {
        wheels += (n * torque - load) / (jv + n * n * (js + je)) * h;
        engine = shaft = n * wheels;
      } else {
        const Number carried = grips ? tc : Number(0);  // the engine is the faster one
        const Number engine_rate = (torque - carried) / je, rate = (n * carried - load) / (jv + n * n * js);
        const Number meets = grips ? Number((engine - shaft) / (n * rate - engine_rate)) : h;
        if (grips && meets <= h) {
          h = meets;
          locked = true;
        }
        engine += engine_rate * h;
        wheels += rate * h;
        shaft = n * wheels;
        if (locked) engine = shaft;
      }
      now += h;
    }
  };
  write(folder, "gear_shift.drive", {"t", "engine", "shaft", "wheels"}, 6, 601, [&](const Number& t) {
    for (const Number& edge : {Number(3), given(3.1), given(3.2), given(3.3)})
      if (now < edge && edge < t) advance(edge);
    advance(t);
    // A record at the time of the second gear shows the speeds after it.
    if (now >= given(3.2) && !shifted) {
      wheels = (jv * wheels + n2 * js * shaft) / (jv + n2 * n2 * js);
      shaft = n2 * wheels;
      shifted = true;
    }
    return std::vector<Number>{engine, shaft, wheels};
  });
}

/// angle'' = (g/l) sin(angle) by Taylor series, whose coefficients come one from the other; the next strike by
/// bisection.
void rimless_wheel(const std::string& folder) {
  const Number rate = given(9.81), alpha = given(0.3), slope = given(0.08);
  Number now = 0, angle = slope - alpha, speed = given(1.2), steps = 0;
  const auto after = [&](const Number& h, Number& x, Number& v) {
    constexpr std::size_t kTerms = 40;
    std::vector<Number> a(kTerms + 2, 0), w(kTerms + 2, 0), s(kTerms + 2, 0), c(kTerms + 2, 0);
    a[0] = angle;
    w[0] = speed;
    s[0] = sin(angle);
    c[0] = cos(angle);
    for (std::size_t k = 0; k < kTerms; ++k) {
      const Number next = Number(k + 1);
      a[k + 1] = w[k] / next;
      w[k + 1] = rate * s[k] / next;
      for (std::size_t j = 0; j <= k; ++j) {
        s[k + 1] += c[j] * w[k - j] / next;
        c[k + 1] -= s[j] * w[k - j] / next;
      }
    }
    x = v = 0;
    for (std::size_t k = kTerms + 1; k-- > 0;) {
      x = x * h + a[k];
      v = v * h + w[k];
    }
  };
  const auto advance = [&](const Number& until) {
    while (now < until) {
      const Number h = std::min<Number>(until - now, given(0.01));
      Number x, v;
      after(h, x, v);
      if (x < slope + alpha) {
        angle = x;
        speed = v;
        now += h;
        continue;
      }
      Number low = 0, high = h;
      for (int i = 0; i < 170; ++i) {
        const Number middle = (low + high) / 2;
        after(middle, x, v);
        (x < slope + alpha ? low : high) = middle;
      }
      after(high, x, v);
      angle = x - 2 * alpha;
      speed = cos(2 * alpha) * v;
      steps += 1;
      now += high;
    }
  };
  write(folder, "rimless_wheel.walk", {"t", "angle", "w", "torque", "steps"}, 6, 1201, [&](const Number& t) {
    advance(t);
    return std::vector<Number>{angle, speed, rate * sin(angle), steps};
  });
}

/// A stretch of a solution: it ends at `until`, or earlier where `guard` goes below 0; then `jump` sets the states.
template <std::size_t N>
struct Stretch {
  Rates<N> rates;
  Real until;
  std::function<Real(const Vector<N>&)> guard = {};
  std::function<void(Vector<N>&)> jump = {};
};

/// Stretch after stretch. The end of one is found by bisection, each time integrated anew from its beginning.
template <std::size_t N, class Method>
std::vector<Vector<N>> follow(const Method& method, const std::vector<Stretch<N>>& stretches, Vector<N> y,
                              const std::vector<Real>& times) {
  std::vector<Vector<N>> result{y};
  Real now = times.front();
  std::size_t next = 1;
  for (const Stretch<N>& stretch : stretches) {
    Real end = stretch.until;
    if (stretch.guard) {
      Real low = now, high = stretch.until;
      Vector<N> from = y;
      for (int i = 0; i < 90 && high - low > 1e-18L * high; ++i) {
        const Real middle = (low + high) / 2;
        const Vector<N> there = method(stretch.rates, from, {low, middle}).back();
        if (stretch.guard(there) < 0) {
          high = middle;
        } else {
          low = middle;
          from = there;
        }
      }
      end = high;
    }
    std::vector<Real> at{now};
    while (next < times.size() && times[next] < end) at.push_back(times[next++]);
    at.push_back(end);
    const std::vector<Vector<N>> found = method(stretch.rates, y, at);
    for (std::size_t i = 1; i + 1 < found.size(); ++i) result.push_back(found[i]);
    y = found.back();
    if (stretch.jump) stretch.jump(y);
    now = end;
    if (next < times.size() && times[next] == end) {
      result.push_back(y);
      ++next;
    }
  }
  return result;
}

/// Follows the stretches by both integrations, and writes the table of the first where all columns of both agree to
/// 1e-9.
/// @param table  a table of the states at @p times.
template <std::size_t N, class MakeTable>
void write_where_they_agree(const std::string& folder, const std::string& name,
                            const std::vector<Stretch<N>>& stretches, const Vector<N>& scale,
                            const std::vector<Real>& times, const MakeTable& table) {
  const Table radau = table(follow<N>([&](const Rates<N>& r, const Vector<N>& y,
                                          const std::vector<Real>& at) { return by_radau<N>(r, y, scale, at, 1e-15L); },
                                      stretches, {}, times));
  const Table second =
      table(follow<N>([&](const Rates<N>& r, const Vector<N>& y,
                          const std::vector<Real>& at) { return by_extrapolation<N>(r, y, scale, at, 1e-16L); },
                      stretches, {}, times));
  std::printf("%-28s", name.c_str());
  Real worst = 0;
  for (std::size_t c = 1; c < radau.names.size(); ++c) {
    const Real difference = scaled_difference(radau, second, c);
    worst = std::max(worst, difference);
    std::printf(" %s %.1Le", radau.names[c].c_str(), difference);
  }
  std::printf("\n");
  if (!(worst < 1e-9L)) throw std::runtime_error(name + ": the two methods disagree");
  write_csv(folder + "/" + name + ".csv", radau);
}

/// Air, extension, speed. It is filled until the wall meets the object, fills on, holds, and lets the air out until the
/// wall leaves the object.
void gripper(const std::string& folder) {
  const auto plain = [](double value) { return Real(value); };
  const Real m = plain(0.015), area = plain(0.0096), k = 350, damping = plain(0.4), valve = plain(5e-5), delta = 10,
             c2 = plain(2.7e-8), supply = plain(2e4), grip = plain(0.1);
  // ssqrt(e, d): sign(e) sqrt(|e|), made smooth about 0: e/(e^2 + d^2)^(1/4)
  const auto flow = [=](Real e) { return valve * e / std::sqrt(std::sqrt(e * e + delta * delta)); };
  const auto pressure = [=](const Vector<3>& y) { return (y[0] - area * y[1]) / c2; };
  const auto rates = [=](bool fill, bool vent, bool held) -> Rates<3> {
    return [=](const Vector<3>& y, Vector<3>& dydt, Real /*t*/) {
      const Real p = pressure(y);
      dydt[0] = (fill ? flow(supply - p) : 0) - (vent ? flow(p) : 0);
      dydt[1] = held ? 0 : y[2];
      dydt[2] = held ? 0 : (area * p - k * y[1] - damping * y[2]) / m;
    };
  };
  const std::vector<Stretch<3>> stretches{
      {rates(false, false, false), plain(0.1)},
      {rates(true, false, false), plain(0.4), [=](const Vector<3>& y) { return grip - y[1]; },
       [=](Vector<3>& y) {
         y[1] = grip;
         y[2] = 0;
       }},
      {rates(true, false, true), plain(0.4)},
      {rates(false, false, true), plain(0.7)},
      {rates(false, true, true), plain(1.2), [=](const Vector<3>& y) { return area * pressure(y) - k * y[1]; }},
      {rates(false, true, false), plain(1.2)}};
  const std::vector<std::string> columns{"t", "x", "P", "Q_in", "Q_out", "force"};
  const std::vector<Real> times = times_of({0, plain(1.2), 2401});
  const Vector<3> scale{1e-3L, 0.1L, 1};
  const auto table = [&](const std::vector<Vector<3>>& states) {
    Table result{columns, {}};
    for (std::size_t i = 0; i < times.size(); ++i) {
      const Real t = times[i], p = pressure(states[i]);
      const Real force = area * p - k * states[i][1];
      const bool held = std::fabs(states[i][1] - grip) < 1e-15L && force > 0;  // to roundings of the integrators
      result.rows.push_back({t, states[i][1], p, t >= plain(0.1) && t < plain(0.4) ? flow(supply - p) : 0,
                             t >= plain(0.7) ? flow(p) : 0, held ? force : 0});
    }
    return result;
  };
  write_where_they_agree<3>(folder, "gripper.cycle", stretches, scale, times, table);
}

/// Air and extension of both packets, speed of the body's centre, its angular speed. The left wall strikes the object
/// and is held there until the object would have to pull.
void actuator_object(const std::string& folder) {
  const auto plain = [](double value) { return Real(value); };
  const Real pi = std::acos(Real(-1));
  const Real body = plain(0.05), arm = plain(0.4), inertia = body * arm * arm / 3, reach = plain(0.15),
             area = plain(0.0096), k = 350, damping = plain(0.4), unit = 2000, kp = 40, kd = 10, delta = 10,
             amplitude = plain(0.3);
  const Real valve = plain(0.8) * pi * plain(0.008) * plain(0.008) / 4 * std::sqrt(2 / plain(1.225)),
             c2 = area * amplitude / (plain(1.225) * 287 * 300);
  const Real phase = plain(3.141592653589793);  // the pi of doubles
  const auto flow = [=](Real e) { return valve * e / std::sqrt(std::sqrt(e * e + delta * delta)); };
  const auto pressure = [=](const Vector<6>& y, int side) { return (y[2 * side] - area * y[2 * side + 1]) / c2; };
  const auto speed = [=](const Vector<6>& y, int side) { return y[4] + (side == 0 ? arm : -arm) * y[5]; };
  const auto packet_force = [=](const Vector<6>& y, int side) {
    return area * pressure(y, side) - k * y[2 * side + 1] - damping * speed(y, side);
  };
  // By how much a unit of force at the left wall speeds that wall up.
  const Real mobility = 1 / body + arm * arm / inertia;
  const auto object_force = [=](const Vector<6>& y) {
    const Real left = packet_force(y, 0), right = packet_force(y, 1);
    return ((left + right) / body + arm * arm * (left - right) / inertia) / mobility;
  };
  const auto rates = [=](bool held) -> Rates<6> {
    return [=](const Vector<6>& y, Vector<6>& dydt, Real t) {
      for (const int side : {0, 1}) {
        const Real angle = t + (side == 0 ? 0 : phase), v = speed(y, side);
        const Real pump =
            unit * (kp * (amplitude * std::sin(angle) - y[2 * side + 1]) + kd * (amplitude * std::cos(angle) - v));
        dydt[2 * side] = flow(pump - pressure(y, side));
        dydt[2 * side + 1] = held && side == 0 ? 0 : v;
      }
      const Real left = packet_force(y, 0) - (held ? object_force(y) : 0), right = packet_force(y, 1);
      dydt[4] = (left + right) / body;
      dydt[5] = arm * (left - right) / inertia;
    };
  };
  const auto room = [=](const Vector<6>& y) { return reach - y[1]; };
  const auto strike = [=](Vector<6>& y) {
    const Real impulse = speed(y, 0) / mobility;
    y[1] = reach;
    y[4] -= impulse / body;
    y[5] -= arm * impulse / inertia;
  };
  const std::vector<Stretch<6>> stretches{
      {rates(false), 2, room, strike}, {rates(true), 4, object_force}, {rates(false), 4}};
  const std::vector<std::string> columns{"t", "x_L", "x_R", "force", "P2_L", "P2_R", "v_R"};
  const std::vector<Real> times = times_of({0, 4, 4001});
  const Vector<6> scale{1e-3L, 0.1L, 1e-3L, 0.1L, 0.1L, 0.1L};
  const auto table = [&](const std::vector<Vector<6>>& states) {
    Table result{columns, {}};
    for (std::size_t i = 0; i < times.size(); ++i) {
      const Vector<6>& y = states[i];
      const bool held = std::fabs(y[1] - reach) < 1e-15L && object_force(y) > 0;
      result.rows.push_back(
          {times[i], y[1], y[3], held ? object_force(y) : 0, pressure(y, 0), pressure(y, 1), speed(y, 1)});
    }
    return result;
  };
  write_where_they_agree<6>(folder, "actuator_object.press", stretches, scale, times, table);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : "models/reference";
  try {
    thyristor_bridge(folder, "late", 1.0471975511965976);
    thyristor_bridge(folder, "early", 0.5235987755982988);
    water_hammer(folder);
    gear_shift(folder);
    rimless_wheel(folder);
    gripper(folder);
    actuator_object(folder);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
