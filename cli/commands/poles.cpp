// bgsim poles and bgsim zeros.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "linear_options.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace {

/// "mass 97 %, spring 3 %": the largest, up to three.
std::string shares_text(const std::vector<PoleShare>& shares) {
  std::string text;
  for (std::size_t i = 0; i < shares.size() && i < 3; ++i) {
    if (i > 0 && shares[i].share < 0.005) break;
    text +=
        (text.empty() ? "" : ", ") + short_name(shares[i].name) + " " + number_text(100.0 * shares[i].share, 3) + " %";
  }
  return text;
}

std::vector<std::string> columns_of(const Pole& pole) {
  const double real = pole.s.real();
  std::string time = real == 0.0 ? "" : number_text(1.0 / std::abs(real), 5);
  if (real > 0.0) time = "grows, " + time;
  return {complex_text(pole.s), pole.pair ? number_text(pole.damping() + 0.0, 5) : "",
          pole.pair ? number_text(pole.frequency(), 6) : "",
          pole.pair ? number_text(pole.frequency() / (2.0 * std::numbers::pi), 6) : "", time};
}

/// How far gain, zeros and poles, multiplied out, are from the response itself, which is computed from the matrices:
/// the largest relative difference at frequencies among them.
double mismatch(const LinearSystem& system, const TransferZeros& found) {
  std::vector<double> omega;
  for (const std::vector<Pole>* list : {&found.zeros, &found.poles})
    for (const Pole& one : *list)
      if (one.s != 0.0) omega.push_back(one.frequency() * 1.37);  // beside it
  if (omega.empty()) omega.push_back(1.0);
  std::sort(omega.begin(), omega.end());
  const std::vector<double> some{omega.front(), omega[omega.size() / 2], omega.back()};
  const FrequencyResponse direct = frequency_response(system, 0, 0, some);
  double largest = 0.0;
  for (std::size_t i = 0; i < some.size(); ++i) {
    const std::complex<double> s(0.0, some[i]);
    std::complex<double> logarithm =
        std::log(std::complex<double>(found.gain));  // factors may leave the range of numbers
    const auto add = [&](const Pole& one, double sign) {
      logarithm += sign * std::log(s - one.s);
      if (one.pair) logarithm += sign * std::log(s - std::conj(one.s));
    };
    for (const Pole& zero : found.zeros) add(zero, 1.0);
    for (const Pole& pole : found.poles) add(pole, -1.0);
    const std::complex<double> ratio = std::exp(logarithm - std::log(direct.value[i]));
    if (std::isfinite(std::abs(direct.value[i])) && std::abs(direct.value[i]) > 0.0)
      largest = std::max(largest, std::abs(ratio - 1.0));
  }
  return largest;
}

}  // namespace

Exit poles_command(const Arguments& arguments) {
  LinearArguments options;
  CLI::App app("Poles of a model at a point: damping, frequency, time constant, and the stores that each belongs to.",
               "bgsim poles");
  app.footer("Example: bgsim poles models/quarter_car.json --at steady");
  add_linear_options(app, options, "");
  std::optional<std::size_t> count;
  std::optional<double> near;
  app.add_option("--count", count, "only so many poles: those nearest to 0, or to --near; of systems of any size")
      ->type_name("N")
      ->check(CLI::Range(std::size_t{1}, std::size_t{200}));
  app.add_option("--near", near, "only the poles nearest to this real number, ten if --count does not say")
      ->type_name("S")
      ->check([](const std::string& text) {
        double value = 0.0;
        return CLI::detail::lexical_cast(text, value) && std::isfinite(value) ? "" : "is to be a finite number";
      });
  parse_arguments(app, arguments);
  const LinearStudy linear = linearized(options, {}, false);
  std::optional<PolesNear> some;
  if (count || near) some = PolesNear{near.value_or(0.0), count.value_or(PolesNear{}.count)};
  const std::vector<Pole> all = poles(linear.system, some);
  std::cout << visible_line(linear.system.model) << ' ' << linear.where;
  if (some && all.size() == some->count)
    std::cout << ", the " << all.size() << " nearest to " << number_text(some->near, 6);
  std::cout << ":\n";
  if (all.empty()) {
    std::cout << "the model has no states, and no poles\n";
    return Exit::done;
  }
  TextTable table({"pole in 1/s", "damping", "rad/s", "Hz", "time constant in s", "energy", "states", ""});
  for (const Pole& pole : all) {
    std::vector<std::string> row = columns_of(pole);
    row.insert(row.end(), {shares_text(pole.energy), shares_text(pole.participation), pole_remark(pole)});
    table.add(std::move(row));
  }
  std::cout << table.text();
  std::size_t unstable = 0;
  for (const Pole& pole : all)
    if (pole.s.real() > 0.0) unstable += pole.pair ? 2U : 1U;
  if (unstable > 0) std::cout << unstable << (unstable == 1 ? " pole grows" : " poles grow") << ": unstable\n";
  const std::vector<std::string> free = free_states(all);
  if (!free.empty()) {
    std::cout << "free (poles at 0):";
    for (std::size_t i = 0; i < free.size() && i < 12; ++i) std::cout << (i > 0 ? ", " : " ") << short_name(free[i]);
    std::cout << (free.size() > 12 ? ", ..." : "") << '\n';
  }
  return Exit::done;
}

Exit zeros_command(const Arguments& arguments) {
  LinearArguments options;
  CLI::App app("Zeros, poles and gain from an input to an output at a point.", "bgsim zeros");
  app.footer("Example: bgsim zeros models/quarter_car.json --in road --out zs --at steady");
  add_linear_options(app, options, "");
  add_path_options(app, options, false);
  parse_arguments(app, arguments);
  const std::vector<std::string> inputs = split_names(options.inputs);
  require_one(inputs, "--in", "pump.e");
  require_one(options.outputs, "--out", "x");
  take_outputs(options);
  if (options.reading.record.size() != 1) require_one(options.reading.record, "--out", "x");
  const LinearStudy linear = linearized(options, inputs);
  const TransferZeros found = transfer_zeros(linear.system, 0, 0);
  std::cout << visible_line(linear.system.model) << ' ' << linear.where << ", from "
            << short_name(linear.system.inputs[0].name) << " to " << short_name(linear.system.outputs[0].name) << ":\n";
  TextTable table({"", "in 1/s", "damping", "rad/s", "Hz", "time constant in s", ""});
  const auto add = [&](const char* what, const std::vector<Pole>& list) {
    for (const Pole& one : list) {
      std::vector<std::string> row = columns_of(one);
      row.insert(row.begin(), what);
      row.push_back(one.s == 0.0 && one.multiple == 1 ? "" : pole_remark(one));
      table.add(std::move(row));
    }
  };
  add("zero", found.zeros);
  add("pole", found.poles);
  std::cout << table.text();
  if (found.zeros.empty()) std::cout << "no finite zeros\n";
  std::cout << "gain " << number_text(found.gain, 6) << " of (s - z1).../((s - p1)...), static gain "
            << (std::isnan(found.static_gain)   ? "not known"
                : std::isinf(found.static_gain) ? "without bound"
                                                : number_text(found.static_gain, 6))
            << '\n';
  if (found.cancelled > 0)
    std::cout << "cancelled, and not listed: a pole and a zero at 0"
              << (found.cancelled > 1 ? ", " + std::to_string(found.cancelled) + " times" : "") << '\n';
  if (const double off = mismatch(linear.system, found); !(off <= 1e-6))
    std::cout << "zeros, poles and gain multiplied out differ from the response by a part of " << number_text(off, 2)
              << ": they are known to few digits (multiple, or of very different sizes)\n";
  if (!found.hidden.empty()) {
    std::cout << "not between input and output:";
    for (std::size_t i = 0; i < found.hidden.size() && i < 12; ++i)
      std::cout << (i > 0 ? ", " : " ") << short_name(found.hidden[i]);
    std::cout << (found.hidden.size() > 12 ? ", ..." : "") << '\n';
  }
  return Exit::done;
}

}  // namespace bgsim::cli
