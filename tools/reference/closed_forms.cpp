/// References of the gallery from closed forms, evaluated in 50 digits, and from one integral. Writes NAME.SCENE.csv
/// into the folder given.
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "digits.hpp"

namespace {

using namespace reference;

/// Modes of a chain of n equal bodies with free ends: cos(pi k (j - 1/2)/n), rate (4 G/C) sin^2(pi k/(2 n)).
void thermal_chain(const std::string& folder) {
  const int n = 4;
  const Number cold = given(273.15), rise = given(373.15) - cold, rate = Number(4) * 10 / 15;
  write(folder, "thermal_chain.cooling", {"t", "T1", "T2", "T3", "T4"}, 10, 101, [&](const Number& t) {
    std::vector<Number> row;
    for (int j = 1; j <= n; ++j) {
      Number sum = Number(1) / n;
      for (int k = 1; k < n; ++k) {
        const Number s = sin(kPi * k / (2 * n));
        sum += Number(2) / n * cos(kPi * k * (Number(j) - 0.5) / n) * cos(kPi * k / (2 * n)) * exp(-rate * s * s * t);
      }
      row.push_back(cold + rise * sum);
    }
    return row;
  });
}

/// Modes of a chain of n equal bodies, the first joined to what is held, the last one free: sin(k theta) with
/// theta = (2m - 1) pi/(2n + 1), rate (4 G/C) sin^2(theta/2); from equal bodies with the amplitudes
/// 2 cot(theta/2)/(2n + 1).
void heat_rod(const std::string& folder) {
  const int n = 12;
  const Number hot = given(373.15), fall = hot - given(273.15), conductance = 5, rate = 4 * conductance / 2;
  const auto temperature = [&](int k, const Number& t) {
    Number sum = 0;
    for (int m = 1; m <= n; ++m) {
      const Number theta = (2 * m - 1) * kPi / (2 * n + 1), s = sin(theta / 2);
      sum += 2 * cos(theta / 2) / s / (2 * n + 1) * sin(k * theta) * exp(-rate * s * s * t);
    }
    return Number(hot - fall * sum);
  };
  write(folder, "heat_rod.heating", {"t", "T1", "T4", "T8", "T12", "heat"}, 100, 201, [&](const Number& t) {
    const Number first = temperature(1, t);
    return std::vector<Number>{first, temperature(4, t), temperature(8, t), temperature(12, t),
                               conductance * (hot - first)};
  });
}

void gas_cylinder(const std::string& folder) {
  const Number gamma = given(1.4), speed = given(-0.8);
  write(folder, "gas_cylinder.compression", {"t", "V", "T", "P"}, 1, 101, [&](const Number& t) {
    const Number v = 1 + speed * t;
    return std::vector<Number>{v, 300 * pow(v, 1 - gamma), 100000 * pow(v, -gamma)};
  });
}

/// L i' = -R i + V: eigenvalues of L^-1 R, both real.
void coupled_coils(const std::string& folder) {
  const Number v = 10, r1 = 2, r2 = 50, l1 = given(0.1), l2 = given(0.4), m = given(0.15), d = l1 * l2 - m * m;
  const Number trace = (l2 * r1 + l1 * r2) / d, root = sqrt(trace * trace - 4 * r1 * r2 / d);
  const Number a = (trace + root) / 2, b = (trace - root) / 2;
  // i1 = V/r1 + k_a exp(-a t) + k_b exp(-b t) with i(0) = 0 and i1'(0) = l2 V/d, i2'(0) = -m V/d
  const Number first = l2 * v / d, ka = (v * b / r1 - first) / (a - b), kb = -v / r1 - ka, g = -m * v / d / (a - b);
  write(folder, "coupled_coils.switch_on", {"t", "i1", "i2"}, 0.1, 201, [&](const Number& t) {
    const Number ea = exp(-a * t), eb = exp(-b * t);
    return std::vector<Number>{v / r1 + ka * ea + kb * eb, g * (eb - ea)};
  });
}

void varying_capacitor(const std::string& folder) {
  const Number c = given(1e-6), r = 10000, eps = given(0.8), w = 500, q0 = given(1e-5);
  write(folder, "varying_capacitor.discharge", {"t", "q", "v", "i"}, 0.05, 201, [&](const Number& t) {
    const Number q = q0 * exp(-(t + eps * sin(w * t) / w) / (r * c)), u = q * (1 + eps * cos(w * t)) / c;
    return std::vector<Number>{q, u, u / r};
  });
}

void skater(const std::string& folder) {
  const Number j0 = 4, c = 3, b = given(0.3);
  write(folder, "skater.draw_in", {"t", "L", "omega"}, 1, 101, [&](const Number& t) {
    const Number j = j0 - c * t, momentum = 20 * pow(j / j0, b / c);
    return std::vector<Number>{momentum, momentum / j};
  });
}

/// Flow of a rough pipe by Colebrook's equation, which is explicit in the flow, at a drop of pressure above 0.
struct Pipe {
  long double diameter, length, roughness;
  [[nodiscard]] long double flow(long double drop) const {
    const long double rho = 998.2, nu = 1.004e-6, pi = boost::math::constants::pi<long double>();
    const long double w = std::sqrt(2 * diameter * drop / (rho * length));
    const long double smooth = 251 * nu / (100 * diameter * w);
    return pi / 4 * diameter * diameter * w * -2 * std::log10(10 * roughness / (37 * diameter) + smooth);
  }
};

/// The pressure at the fork by bisection, the tank's by the classical Runge-Kutta method in steps so short (a tenth of
/// a second, of some 1000 s) that its error is below 1e-16.
void water_main(const std::string& folder) {
  const Pipe main{0.1, 200, 1.5e-4}, left{0.08, 120, 4.5e-5}, right{0.06, 150, 2.6e-4};
  const long double weight = 998.2 * 9.81L, top = weight * 20, area = 1.5;
  const auto fork = [&](long double bottom) {
    long double low = bottom, high = top;
    for (int i = 0; i < 100; ++i) {
      const long double p = (low + high) / 2;
      (main.flow(top - p) > left.flow(p - bottom) + right.flow(p - bottom) ? low : high) = p;
    }
    return (low + high) / 2;
  };
  const auto rate = [&](long double volume) { return main.flow(top - fork(weight * volume / area)); };
  constexpr int kSteps = 100;  // between two records
  reference::Table table{{"t", "level", "Q", "Q_left", "Q_right", "p_fork"}, {}};
  long double volume = 0, before = 0;
  for (const long double t : reference::times_of({0, 1200, 121})) {
    const long double h = (t - before) / kSteps;
    for (int i = 0; i < kSteps && t > 0; ++i) {
      const long double a = rate(volume), b = rate(volume + h / 2 * a), c = rate(volume + h / 2 * b),
                        d = rate(volume + h * c);
      volume += h / 6 * (a + 2 * b + 2 * c + d);
    }
    before = t;
    const long double bottom = weight * volume / area, p = fork(bottom);
    table.rows.push_back({t, volume / area, main.flow(top - p), left.flow(p - bottom), right.flow(p - bottom), p});
  }
  reference::write_csv(folder + "/water_main.fill.csv", table);
}

/// y' = a y + b of two states over a time h: the series of the matrix exponential, in 50 digits.
struct Affine {
  Number a[2][2], b[2];
  [[nodiscard]] std::vector<Number> after(const std::vector<Number>& y, const Number& h) const {
    std::vector<Number> sum = y, term{a[0][0] * y[0] + a[0][1] * y[1] + b[0], a[1][0] * y[0] + a[1][1] * y[1] + b[1]};
    Number factor = h;
    for (int k = 2; k < 80; ++k) {
      for (int i = 0; i < 2; ++i) sum[static_cast<std::size_t>(i)] += factor * term[static_cast<std::size_t>(i)];
      term = {a[0][0] * term[0] + a[0][1] * term[1], a[1][0] * term[0] + a[1][1] * term[1]};
      factor *= h / k;
    }
    return sum;
  }
};

/// Current of a coil and voltage of a capacitor behind it: a part of each period with the switch closed, then the
/// diode, until the current ends; then the capacitor alone.
void converter(const std::string& folder, const std::string& name, double stop, std::size_t samples, const Number& duty,
               const Affine& closed, const Affine& free, const Affine& none) {
  const Number period = given(2e-5);
  Number now = 0;
  std::vector<Number> y{0, 0};
  const auto advance = [&](const Number& until, bool is_closed) {
    const Number h = until - now;
    now = until;
    if (is_closed) return void(y = closed.after(y, h));
    if (!(y[0] > 0)) return void(y = none.after({0, y[1]}, h));
    const std::vector<Number> end = free.after(y, h);
    if (end[0] > 0) return void(y = end);
    Number low = 0, high = h;
    for (int i = 0; i < 170; ++i) {
      const Number middle = (low + high) / 2;
      (free.after(y, middle)[0] > 0 ? low : high) = middle;
    }
    y = free.after(y, low);
    y = none.after({0, y[1]}, h - low);
  };
  long next = 0;  // edges passed: even ones close the switch
  write(folder, name, {"t", "i", "u"}, stop, samples, [&](const Number& t) {
    while (true) {
      const Number edge = period * (next / 2) + (next % 2 == 0 ? Number(0) : duty * period);
      if (edge > t) break;
      advance(edge, next % 2 == 1);
      ++next;
    }
    advance(t, next % 2 == 1);
    return y;
  });
}

void converters(const std::string& folder) {
  const Number coil = given(1e-4), capacitor = given(1e-4);
  const auto leak = [&](double load) { return -1 / (capacitor * given(load)); };
  const Affine buck_closed{{{0, -1 / coil}, {1 / capacitor, leak(5)}}, {24 / coil, 0}};
  const Affine buck_free{{{0, -1 / coil}, {1 / capacitor, leak(5)}}, {0, 0}};
  converter(folder, "buck.start_up", 0.002, 1001, Number(0.5), buck_closed, buck_free,
            {{{0, 0}, {0, leak(5)}}, {0, 0}});
  const Affine light_closed{{{0, -1 / coil}, {1 / capacitor, leak(200)}}, {24 / coil, 0}};
  const Affine light_free{{{0, -1 / coil}, {1 / capacitor, leak(200)}}, {0, 0}};
  converter(folder, "buck.light_load", 0.002, 1001, Number(0.5), light_closed, light_free,
            {{{0, 0}, {0, leak(200)}}, {0, 0}});
  const Affine boost_closed{{{0, 0}, {0, leak(20)}}, {12 / coil, 0}};
  const Affine boost_free{{{0, -1 / coil}, {1 / capacitor, leak(20)}}, {12 / coil, 0}};
  converter(folder, "boost.start_up", 0.004, 2001, Number(0.5), boost_closed, boost_free,
            {{{0, 0}, {0, leak(20)}}, {0, 0}});
}

/// i' + i = sin t from a current of 0 at the beginning of each period until it comes to 0 again.
void half_wave(const std::string& folder) {
  const auto current = [](const Number& t) { return Number((sin(t) - cos(t) + exp(-t)) / 2); };
  Number low = 3, high = 5;
  for (int i = 0; i < 170; ++i) {
    const Number middle = (low + high) / 2;
    (current(middle) > 0 ? low : high) = middle;
  }
  write(folder, "half_wave.three_periods", {"t", "i", "u"}, 18, 181, [&](const Number& t) {
    const Number phase = t - 2 * kPi * floor(t / (2 * kPi));
    const bool conducts = phase < low;
    return std::vector<Number>{conducts ? current(phase) : Number(0), conducts ? Number(sin(t)) : Number(0)};
  });
}

/// The largest less the smallest of three phases, on a resistor and a coil: over each sixth of a period
/// u = sqrt(3) cos(t - s) about its middle s.
void rectifier_b6(const std::string& folder) {
  const Number top = sqrt(Number(3)), sixth = kPi / 3;
  // i' + i = u has the particular solution sqrt(3) (cos(t - s) + sin(t - s))/2.
  const auto particular = [&](const Number& from_middle) {
    return Number(top * (cos(from_middle) + sin(from_middle)) / 2);
  };
  Number begin = 0, current = 0;
  long piece = 0;  // with its middle at pi/6 + piece pi/3: from phase 0 against phase 1 on
  write(folder, "rectifier_b6.start_up", {"t", "i", "u"}, 6, 121, [&](const Number& t) {
    while (sixth * (piece + 1) <= t) {
      const Number end = sixth * (piece + 1), middle = sixth * piece + sixth / 2;
      current = particular(end - middle) + (current - particular(begin - middle)) * exp(begin - end);
      begin = end;
      ++piece;
    }
    const Number middle = sixth * piece + sixth / 2;
    return std::vector<Number>{particular(t - middle) + (current - particular(begin - middle)) * exp(begin - t),
                               top * cos(t - middle)};
  });
}

void bouncing_ball(const std::string& folder) {
  const Number g = given(9.81), e = given(0.7), h = 1;
  Number begin = -sqrt(2 * h / g), speed = sqrt(2 * g * h), before = -h;  // way before the flight
  write(folder, "bouncing_ball.bounces", {"t", "height", "v", "path"}, 2.5, 501, [&](const Number& t) {
    while (begin + 2 * speed / g <= t) {
      begin += 2 * speed / g;
      before += speed * speed / g;
      speed *= e;
    }
    const Number s = t - begin, rise = speed * speed / (2 * g), height = s * (speed - g * s / 2);
    return std::vector<Number>{height, speed - g * s, before + (g * s < speed ? height : Number(2 * rise - height))};
  });
}

/// The same ball on a contact, at rest from the limit on.
void ball_contact(const std::string& folder) {
  const Number g = given(9.81), e = given(0.7), h = 1, m = given(0.2);
  const Number first = sqrt(2 * h / g), limit = first * (1 + e) / (1 - e);
  Number begin = -first, speed = sqrt(2 * g * h);
  write(folder, "ball_contact.drop", {"t", "height", "v", "force"}, 3, 2501, [&](const Number& t) {
    if (t >= limit) return std::vector<Number>{0, 0, m * g};
    while (begin + 2 * speed / g <= t) {
      begin += 2 * speed / g;
      speed *= e;
    }
    const Number s = t - begin;
    return std::vector<Number>{s * (speed - g * s / 2), speed - g * s, 0};
  });
}

/// Triangular waves: as many balls leave the row at its end as come in.
void cradle(const std::string& folder) {
  const Number a = given(0.2), v = given(0.5);
  for (const int in : {1, 2})
    write(folder, in == 1 ? "cradle.one" : "cradle.two", {"t", "x1", "x2", "x3", "x4", "x5"}, 4, 201,
          [&](const Number& t) {
            Number s = t * v / a;  // ways
            while (s >= 4) s -= 4;
            const Number before = s < 1 ? Number(s - 1) : s < 3 ? Number(0) : Number(3 - s);
            const Number behind = s < 1 || s >= 3 ? Number(0) : s < 2 ? Number(s - 1) : Number(3 - s);
            std::vector<Number> row(5, Number(0));
            for (int i = 0; i < in; ++i) {
              row[static_cast<std::size_t>(i)] = a * before;
              row[static_cast<std::size_t>(4 - i)] = a * behind;
            }
            return row;
          });
  // Moreau's impulses: all contacts part at the speed of the impact or not at all, with the momentum kept.
  write(folder, "cradle.at_once", {"t", "x1", "x2", "x3", "x4", "x5"}, 1, 51, [&](const Number& t) {
    const Number way = v * t - a;
    if (way < 0) return std::vector<Number>{way, 0, 0, 0, 0};
    std::vector<Number> row(5, Number(2 * way / 5));
    row[0] = -3 * way / 5;
    return row;
  });
}

/// x' = c - a x + b x(t - T): the n-th round of the water adds c b^n times the response of 1/(s (s + a)^(n + 1)).
void heated_loop(const std::string& folder) {
  const Number capacity = given(2e5), k = given(400), r = given(0.6), delay = given(120) / given(0.2),
               power = given(1e4), around = given(290);
  const Number a = k / capacity, b = r * k / capacity, c = power / capacity;
  const auto excess = [&](const Number& t) {
    Number sum = 0, factor = c / a;
    for (int n = 0; n * delay <= t; ++n, factor *= b / a) {
      const Number u = a * (t - n * delay);
      Number term = 1, series = 0;
      for (int i = 0; i <= n; ++i, term *= u / i) series += term;
      sum += factor * (1 - exp(-u) * series);
    }
    return sum;
  };
  write(folder, "heated_loop.warm_up", {"t", "T", "T_back"}, 7200, 241, [&](const Number& t) {
    const Number before = t - delay;
    return std::vector<Number>{around + excess(t), around + (before > 0 ? Number(r * excess(before)) : Number(0))};
  });
}

/// It sticks over 2 (Fs - Fd)/(k v0), and slips on a sine about Fd/k.
void stick_slip(const std::string& folder) {
  const Number v = given(0.1), most = given(1), least = given(0.5);
  const Number sticks = 2 * (most - least) / v,
               slips = 2 * (boost::math::constants::pi<Number>() - atan((most - least) / v));
  write(folder, "stick_slip.squeal", {"t", "x", "v", "sticks"}, 40, 401, [&](Number t) {
    while (t >= sticks + slips) t -= sticks + slips;
    const Number begin = 2 * least - most, s = t - sticks;
    if (s < 0) return std::vector<Number>{begin + v * t, v, 1};
    return std::vector<Number>{least + (most - least) * cos(s) + v * sin(s), v * cos(s) - (most - least) * sin(s), 0};
  });
}

/// A line up to the pressure at which the valve opens, an exponential down to that at which it shuts.
void relief_valve(const std::string& folder) {
  const Number flow = given(1e-4), capacity = given(1e-10), resistance = given(4e9), high = given(2e6),
               low = given(1.2e6);
  const Number rest = flow * resistance, lag = resistance * capacity;
  const Number falls = lag * log((high - rest) / (low - rest)), first = high * capacity / flow,
               period = falls + (high - low) * capacity / flow;
  write(folder, "relief_valve.pumping", {"t", "p", "outflow"}, 10, 1001, [&](Number t) {
    if (t < first) return std::vector<Number>{flow / capacity * t, 0};
    t -= first;
    while (t >= period) t -= period;
    if (t >= falls) return std::vector<Number>{low + flow / capacity * (t - falls), 0};
    const Number p = rest + (high - rest) * exp(-t / lag);
    return std::vector<Number>{p, p / resistance};
  });
}

/// Parabolas between impacts on a table that moves as a sine; the next impact by bisection in the first of many small
/// pieces at whose end the ball is below the table.
void shaken_ball(const std::string& folder) {
  const Number g = given(9.81), e = given(0.6), amplitude = given(0.01), w = 40, piece = given(1e-4);
  Number begin = 0, x = given(0.3), v = 0;
  const auto above = [&](const Number& t) {
    const Number s = t - begin;
    return Number(x + s * (v - g * s / 2) - amplitude * sin(w * t));
  };
  const auto next_impact = [&] {
    Number high = begin + piece;
    while (above(high) > 0) high += piece;
    Number low = high - piece;
    for (int i = 0; i < 150; ++i) {
      const Number middle = (low + high) / 2;
      (above(middle) > 0 ? low : high) = middle;
    }
    return high;
  };
  Number impact = next_impact();
  write(folder, "shaken_ball.shaken", {"t", "height", "v", "table"}, 1.5, 501, [&](const Number& t) {
    while (impact <= t) {
      const Number table = amplitude * w * cos(w * impact);
      v = (1 + e) * table - e * (v - g * (impact - begin));
      x = amplitude * sin(w * impact);
      begin = impact;
      impact = next_impact();
    }
    const Number s = t - begin;
    return std::vector<Number>{x + s * (v - g * s / 2), v - g * s, amplitude * sin(w * t)};
  });
}

/// Exponentials between the two levels at which the heater is switched.
void thermostat(const std::string& folder) {
  const Number tau = given(1e5) * given(0.01), up = given(2500) * given(0.01), low = 19, high = 21, cold = 15;
  const Number first = tau * log((up - cold) / (up - high)), cool = tau * log(high / low),
               heat = tau * log((up - low) / (up - high));
  write(folder, "thermostat.evening", {"t", "T", "power"}, 6000, 601, [&](const Number& t) {
    if (t < first) return std::vector<Number>{up - (up - cold) * exp(-t / tau), 2500};
    Number into = t - first;
    while (into >= cool + heat) into -= cool + heat;
    if (into < cool) return std::vector<Number>{high * exp(-into / tau), 0};
    return std::vector<Number>{up - (up - low) * exp(-(into - cool) / tau), 2500};
  });
}

/// The controller's recursion; between its samples the torque is constant.
void sampled_servo(const std::string& folder) {
  const Number inertia = given(0.05), friction = given(0.1), every = given(0.015625), kp = 4, ki = 3, kd = given(0.5);
  Number begin = 0, angle = 0, speed = 0, read = 0, sum = 0, torque = 0;
  const auto sample = [&] {
    const Number error = 1 - angle, wanted = kp * error + sum - kd * (angle - read) / every;
    read = angle;
    if (abs(wanted) < 1) sum += ki * every * error;
    torque = wanted > 1 ? Number(1) : wanted < -1 ? Number(-1) : wanted;
  };
  const auto after = [&](const Number& s) {
    const Number end = torque / friction, decay = exp(-friction / inertia * s);
    return std::vector<Number>{angle + end * s + (speed - end) * inertia / friction * (1 - decay),
                               end + (speed - end) * decay, torque};
  };
  sample();
  write(folder, "sampled_servo.turn", {"t", "angle", "speed", "torque"}, 4, 1025, [&](const Number& t) {
    while (begin + every <= t) {
      const std::vector<Number> next = after(every);
      angle = next[0];
      speed = next[1];
      begin += every;
      sample();
    }
    return after(t - begin);
  });
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : "models/reference";
  try {
    thermal_chain(folder);
    heat_rod(folder);
    gas_cylinder(folder);
    coupled_coils(folder);
    varying_capacitor(folder);
    skater(folder);
    water_main(folder);
    converters(folder);
    half_wave(folder);
    rectifier_b6(folder);
    bouncing_ball(folder);
    shaken_ball(folder);
    ball_contact(folder);
    cradle(folder);
    heated_loop(folder);
    stick_slip(folder);
    relief_valve(folder);
    thermostat(folder);
    sampled_servo(folder);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
