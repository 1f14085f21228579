// bgsim bode and bgsim step: responses from one input to one output.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <iostream>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>

#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"
#include "bgsim/unit.hpp"
#include "command.hpp"
#include "files.hpp"
#include "gnuplot.hpp"
#include "linear_options.hpp"
#include "output_file.hpp"
#include "plot_picture.hpp"
#include "programs.hpp"

namespace bgsim::cli {

namespace {

constexpr double kPi = std::numbers::pi;

/// The files of -o, .csv and .svg.
void check_files(const std::vector<std::string>& files, const Model& model) {
  std::vector<NamedFile> outputs;
  for (const std::string& file : files) outputs.push_back({file, "-o"});
  check_outputs(outputs, files_of(model));
}

void check_endings(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    const std::string ending = std::filesystem::path(file).extension().string();
    if (file != "-" && ending != ".csv" && ending != ".svg")
      throw UsageError("-o " + short_path(file) + ": the file is to end in .csv or .svg");
    if (ending == ".svg") require_program(kGnuplot, "-o FILE.csv writes the table instead");
  }
}

void write_files(const std::vector<std::string>& files, const std::string& table, const Plot& plot) {
  if (files.empty()) std::cout << table;
  for (const std::string& name : files) {
    OutputFile file(name);
    file.stream() << (name.ends_with(".svg") ? plot_svg(plot) : table);
    commit_all({&file});
  }
}

/// In degrees; none of what is 0 or without bound.
double phase_of(const std::complex<double>& value) {
  const bool any = std::isfinite(std::abs(value)) && std::abs(value) > 0.0;
  return any ? std::arg(value) * 180.0 / kPi : std::numeric_limits<double>::quiet_NaN();
}

/// From -180 to 180.
double turned(double from, double to) { return std::remainder(to - from, 360.0); }

/// Phases in degrees, without jumps by whole turns. Where the phase turns far between two frequencies, or by its slope
/// at one of them would, frequencies between them show the way. A pole or zero on the imaginary axis, or within 1e-9 of
/// a frequency beside it, is gone round on the right, as if there were a little damping: down at a pole, up at a zero.
/// @param seeds    frequencies that are looked at as well: of poles, at which a resonance may be narrower than a step
/// @param respond  respond(frequencies, right): the response there, so far beside the axis
/// @param whole    false if that took too many frequencies
template <class Respond>
std::vector<double> phases(const std::vector<double>& omega, const std::vector<double>& seeds, const Respond& respond,
                           bool& whole) {
  constexpr double kSmall = 60.0, kNarrow = 1e-9, kPart = 0.382, kBeside = 1e-7;
  constexpr int kRounds = 60;
  const std::size_t most =
      20 * (omega.size() + seeds.size());  // where rounding is all that is left, phases turn at random
  struct Point {
    double phase, slope;  ///< in degrees; by the frequency
  };
  std::map<double, Point> at;  // by frequency
  const auto look = [&](const std::vector<double>& frequencies) {
    std::vector<double> pairs;
    for (const double w : frequencies) pairs.insert(pairs.end(), {w, w * (1.0 + kBeside)});
    if (pairs.empty()) return;
    const std::vector<std::complex<double>> response = respond(pairs, 0.0);
    for (std::size_t i = 0; i < frequencies.size(); ++i) {
      const double phase = phase_of(response[2 * i]), next = phase_of(response[2 * i + 1]);
      if (std::isnan(phase)) continue;
      at[frequencies[i]] = {phase, std::isnan(next) ? 0.0 : turned(phase, next) / (kBeside * frequencies[i])};
    }
  };
  look(seeds);
  look(omega);
  whole = false;
  for (int round = 0; round < kRounds && at.size() < most && !whole; ++round) {
    std::vector<double> more;
    for (auto one = at.begin(), next = one; one != at.end() && ++next != at.end(); one = next) {
      const double wide = next->first - one->first;
      const double steep = wide * std::max(std::abs(one->second.slope), std::abs(next->second.slope));
      const bool far = std::abs(turned(one->second.phase, next->second.phase)) > kSmall || steep > kSmall;
      if (far && wide > kNarrow * next->first) more.push_back(one->first + kPart * wide);
    }
    whole = more.empty();
    look(more);
  }
  const auto turn_between = [&](double w1, double phase1, double w2, double phase2) {
    const double turn = turned(phase1, phase2);
    if (std::abs(turn) <= kSmall) return turn;
    double way = 0.0, last = phase1;
    for (const std::complex<double>& value : respond({w1, 0.5 * (w1 + w2), w2}, w2 - w1)) {
      way += turned(last, phase_of(value));
      last = phase_of(value);
    }
    way += turned(last, phase2);
    return std::isnan(way) ? turn : way;
  };
  std::map<double, double> continuous;
  double sum = 0.0;
  for (auto one = at.begin(); one != at.end(); ++one) {
    sum = one == at.begin()
              ? one->second.phase
              : sum + turn_between(std::prev(one)->first, std::prev(one)->second.phase, one->first, one->second.phase);
    continuous[one->first] = sum;
  }
  std::vector<double> result;
  for (const double w : omega) {
    const auto found = continuous.find(w);
    result.push_back(found == continuous.end() ? std::numeric_limits<double>::quiet_NaN() : found->second);
  }
  return result;
}

struct BodeArguments {
  LinearArguments linear;
  std::vector<std::string> files;
  std::string impedance;
  std::optional<double> from, to;
  std::size_t points = 400;
  bool hertz = false;
};

BodeArguments parse_bode(const Arguments& arguments) {
  BodeArguments options;
  CLI::App app("Frequency response from an input to an output, or the impedance at a bond: magnitude and phase.",
               "bgsim bode");
  app.footer(
      "Examples:\n  bgsim bode models/quarter_car.json --in road --out zs -o car.svg\n  bgsim bode models/rlc.json "
      "--impedance battery --hz -o impedance.svg");
  add_linear_options(app, options.linear, "");
  add_path_options(app, options.linear, false);
  app.add_option(
         "--impedance", options.impedance,
         "e/f at a bond or element, in the motion that the input makes (default: the source there, or the only one)")
      ->type_name("NAME");
  app.add_option("--from", options.from, "lowest frequency in rad/s (default: a tenth of the slowest pole)")
      ->type_name("W");
  app.add_option("--to", options.to, "highest frequency in rad/s (default: ten times the fastest pole)")
      ->type_name("W");
  app.add_option("--points", options.points, "number of frequencies, evenly spaced by their logarithms (default: 400)")
      ->type_name("N");
  app.add_flag("--hz", options.hertz, "--from, --to and the picture in Hz");
  app.add_option("-o", options.files,
                 "a table (.csv) or a picture (.svg); may be repeated (default: table on standard output)")
      ->type_name("FILE")
      ->allow_extra_args(false);
  parse_arguments(app, arguments);
  if (options.points < 2 || options.points > 10'000'000)
    throw UsageError("--points " + std::to_string(options.points) +
                     ": a response takes from 2 to 10,000,000 frequencies");
  for (const auto& [value, name] : {std::pair(options.from, "--from"), std::pair(options.to, "--to")})
    if (value && !(std::isfinite(*value) && *value > 0.0))
      throw UsageError(std::string(name) + " is to be above zero: frequencies are spaced by their logarithms");
  if (options.from && options.to && !(*options.from < *options.to))
    throw UsageError("--from " + number_text(*options.from) + " is not below --to " + number_text(*options.to) +
                     ": the range is empty");
  check_endings(options.files);
  return options;
}

/// Frequencies over all poles that are not zero.
std::vector<double> frequencies(const BodeArguments& options, const LinearSystem& system) {
  const double unit = options.hertz ? 2.0 * kPi : 1.0;
  double low = options.from.value_or(0.0) * unit, high = options.to.value_or(0.0) * unit;
  if (!options.from || !options.to) {
    double slowest = std::numeric_limits<double>::infinity(), fastest = 0.0;
    for (const Pole& pole : poles(system)) {
      if (pole.frequency() == 0.0) continue;
      slowest = std::min(slowest, pole.frequency());
      fastest = std::max(fastest, pole.frequency());
    }
    if (fastest == 0.0) slowest = fastest = 1.0;
    if (!options.from) low = std::min(0.1 * slowest, options.to ? 1e-3 * high : 0.1 * slowest);
    if (!options.to) high = std::max(10.0 * fastest, options.from ? 1e3 * low : 10.0 * fastest);
  }
  std::vector<double> omega;
  for (std::size_t i = 0; i < options.points; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(options.points - 1);
    omega.push_back(i == 0 ? low : i + 1 == options.points ? high : low * std::pow(high / low, share));
  }
  return omega;
}

/// The frequencies of weakly damped poles within a range, which a step between two frequencies may pass over; none of
/// systems whose poles take seconds.
std::optional<std::vector<double>> resonances(const LinearSystem& system, const std::vector<double>& omega) {
  constexpr std::size_t kMostStates = 200;
  constexpr double kWeak = 0.1;
  if (system.states.size() > kMostStates) return std::nullopt;
  std::vector<double> result;
  for (const Pole& pole : poles(system)) {
    const double w = std::abs(pole.s.imag());
    if (w > omega.front() && w < omega.back() && std::abs(pole.s.real()) < kWeak * w) result.push_back(w);
  }
  return result;
}

/// The source by which an impedance is measured.
std::string source_for(const Model& model, const std::string& name) {
  const std::vector<std::string> sources = all_sources(model);
  const auto touches = [&](const Element& element) {
    if (element.name == name) return true;
    return std::any_of(model.bonds.begin(), model.bonds.end(), [&](const ModelBond& bond) {
      return bond.name == name && (model.elements[bond.from.element.index()].name == element.name ||
                                   model.elements[bond.to.element.index()].name == element.name);
    });
  };
  for (const std::string& source : sources)
    for (const Element& element : model.elements)
      if (source.substr(0, source.rfind('.')) == element.name && touches(element)) return source;
  if (sources.size() == 1) return sources[0];
  throw UsageError(sources.empty()
                       ? "an impedance is measured by a source, and the model has none\n--in names a parameter instead"
                       : "an impedance is measured by one source, and the model has " + std::to_string(sources.size()) +
                             ": name one with --in");
}

std::string table_text(const std::vector<double>& omega, const std::vector<std::complex<double>>& values,
                       const std::vector<double>& phase) {
  std::string text = "omega,frequency,magnitude,decibel,phase,real,imaginary\r\n";
  const auto number = [](double value) {
    return std::isfinite(value) ? number_text(value, 15)
                                : std::string(std::isnan(value) ? ""
                                              : value > 0.0     ? "inf"
                                                                : "-inf");
  };
  for (std::size_t i = 0; i < omega.size(); ++i) {
    const double size = std::abs(values[i]);
    text += number(omega[i]) + "," + number(omega[i] / (2.0 * kPi)) + "," + number(size) + "," +
            number(20.0 * std::log10(size)) + "," + number(phase[i]) + "," + number(values[i].real()) + "," +
            number(values[i].imag()) + "\r\n";
  }
  return text;
}

/// Without what has no finite value.
PlotCurve curve_of(const std::string& name, const std::vector<double>& x, const std::vector<double>& y, bool positive) {
  PlotCurve curve;
  curve.name = name;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::isfinite(y[i]) && (!positive || y[i] > 0.0)) {
      curve.x.push_back(x[i]);
      curve.y.push_back(y[i]);
    }
  return curve;
}

/// The unit of one quantity over another; "" if it is not known.
std::string quotient(const std::string& over, const std::string& under) {
  if (over.empty() || under.empty()) return {};
  const ParsedUnit a = parse_unit(over), b = parse_unit(under);
  if (!a.unit || !b.unit) return {};
  return same_unit(*a.unit, *b.unit) ? over + "/" + under : unit_text(*a.unit / *b.unit);
}

/// "an impulse of weight 2 and its derivative of weight 3"; empty if there is none.
std::string singular_terms(const std::vector<double>& weights) {
  std::string text;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] == 0.0) continue;
    const std::string order = k == 1 ? "" : k == 2 ? "second " : k == 3 ? "third " : std::to_string(k) + "th ";
    text += std::string(text.empty() ? "" : " and ") +
            (k == 0         ? "an impulse"
             : text.empty() ? "the " + order + "derivative of an impulse"
                            : "its " + order + "derivative") +
            " of weight " + number_text(weights[k], 6);
  }
  return text;
}

}  // namespace

Exit bode_command(const Arguments& arguments) {
  BodeArguments options = parse_bode(arguments);
  LinearArguments& linear_options = options.linear;
  std::vector<std::string> inputs = split_names(linear_options.inputs);
  const bool impedance = !options.impedance.empty();
  if (impedance) {
    if (!linear_options.outputs.empty()) throw UsageError("--impedance and --out exclude each other");
    linear_options.outputs = {options.impedance + ".e", options.impedance + ".f"};
    take_outputs(linear_options);
    if (inputs.empty()) inputs = {source_for(linear_study(linear_options).model(), options.impedance)};
  } else {
    require_one(linear_options.outputs, "--out", "x");
    take_outputs(linear_options);
    if (linear_options.reading.record.size() != 1) require_one(linear_options.reading.record, "--out", "x");
  }
  require_one(inputs, "--in", "pump.e");
  const LinearStudy linear = linearized(linear_options, inputs);
  check_files(options.files, linear.study.model());
  const LinearSystem& system = linear.system;
  const std::vector<double> omega = frequencies(options, system);
  // The impedance is the response of the effort by that of the flow.
  const auto respond = [&](const std::vector<double>& at, double right) {
    FrequencyResponse result = frequency_response(system, 0, 0, at, right);
    if (!impedance) return result;
    const FrequencyResponse flow = frequency_response(system, 0, 1, at, right);
    for (std::size_t i = 0; i < at.size(); ++i) result.value[i] /= flow.value[i];
    result.error += flow.error;
    return result;
  };
  const FrequencyResponse response = respond(omega, 0.0);
  std::string name = system.outputs[0].name + " / " + system.inputs[0].name;
  const std::string unit = quotient(system.outputs[0].unit, (impedance ? system.outputs[1] : system.inputs[0]).unit);
  if (impedance) name = "e/f of " + options.impedance;
  if (response.error > 1e-6)
    std::cerr << "note: the response is known to a part of " << number_text(response.error, 2)
              << " at some frequencies: terms cancel there, or a pole is near\n";
  const std::optional<std::vector<double>> seeds = resonances(system, omega);
  bool whole = true;
  const std::vector<double> phase = phases(
      omega, seeds.value_or(std::vector<double>{}),
      [&](const std::vector<double>& at, double right) { return respond(at, right).value; }, whole);
  if (!whole)
    std::cerr << "note: the phase turns faster than could be followed: it may be off by whole turns behind that\n";
  else if (!seeds)
    std::cerr
        << "note: behind resonances that are narrow beside the step of the frequencies the phase may be off by whole "
           "turns; more --points show it\n";
  std::vector<double> x = omega, size;
  if (options.hertz)
    for (double& w : x) w /= 2.0 * kPi;
  for (const std::complex<double>& value : response.value) size.push_back(std::abs(value));
  Plot plot;
  plot.title = system.model + " " + linear.where;
  plot.x_label = options.hertz ? "frequency in Hz" : "angular frequency in rad/s";
  plot.log_x = true;
  plot.panels.push_back({unit.empty() ? "magnitude" : unit, {curve_of(name, x, size, true)}, false, {}, true});
  plot.panels.push_back({"deg", {curve_of("phase", x, phase, false)}, false, {}, false});
  if (plot.panels[0].curves[0].x.empty())
    throw UsageError("the response is zero or without bound at all frequencies: there is nothing to draw");
  write_files(options.files, table_text(omega, response.value, phase), plot);
  return Exit::done;
}

Exit step_command(const Arguments& arguments) {
  LinearArguments options;
  std::vector<std::string> files;
  double stop = 0.0;
  std::size_t points = 501;
  bool impulse = false;
  CLI::App app("Response of an output to a unit step, or impulse, of an input of the linearized model.", "bgsim step");
  app.footer("Example: bgsim step models/dc_motor.json --in V --out omega --stop 0.1 -o motor.svg");
  add_linear_options(app, options, "");
  add_path_options(app, options, false);
  app.add_option("--stop", stop, "the time up to which (default: seven time constants of the slowest pole)")
      ->type_name("T");
  app.add_option("--points", points, "number of times (default: 501)")->type_name("N");
  app.add_flag("--impulse", impulse, "a unit impulse instead of a step");
  app.add_option("-o", files, "a table (.csv) or a picture (.svg); may be repeated (default: table on standard output)")
      ->type_name("FILE")
      ->allow_extra_args(false);
  parse_arguments(app, arguments);
  if (points < 2 || points > 10'000'000)
    throw UsageError("--points " + std::to_string(points) + ": a response takes from 2 to 10,000,000 times");
  if (app.count("--stop") > 0 && !(std::isfinite(stop) && stop > 0.0)) throw UsageError("--stop is to be above zero");
  check_endings(files);
  const std::vector<std::string> inputs = split_names(options.inputs);
  require_one(inputs, "--in", "pump.e");
  require_one(options.outputs, "--out", "x");
  take_outputs(options);
  if (options.reading.record.size() != 1) require_one(options.reading.record, "--out", "x");
  const LinearStudy linear = linearized(options, inputs);
  check_files(files, linear.study.model());
  const LinearSystem& system = linear.system;
  if (app.count("--stop") == 0) {
    double slowest = std::numeric_limits<double>::infinity();
    for (const Pole& pole : transfer_zeros(system, 0, 0).poles)
      if (pole.s != 0.0)
        slowest = std::min(slowest, pole.s.real() != 0.0 ? std::abs(pole.s.real()) : 0.3 * pole.frequency());
    stop = std::isfinite(slowest) ? 7.0 / slowest : 1.0;
  }
  const TimeResponse response =
      time_response(system, 0, 0, impulse ? Excitation::impulse : Excitation::step, stop, points);
  if (const std::string terms = singular_terms(response.singular); !terms.empty())
    std::cerr << "note: at 0 the response contains " << terms << " besides\n";
  const std::string& name = system.outputs[0].name;
  std::string table = "t," + csv_field(name) + "\r\n";
  for (std::size_t i = 0; i < response.times.size(); ++i)
    table += number_text(response.times[i], 15) + "," + number_text(response.value[i], 15) + "\r\n";
  Plot plot;
  plot.title =
      system.model + " " + linear.where + ": unit " + (impulse ? "impulse" : "step") + " of " + system.inputs[0].name;
  plot.x_label = "t in s";
  plot.panels.push_back(
      {system.outputs[0].unit, {curve_of(name, response.times, response.value, false)}, false, {}, false});
  if (plot.panels[0].curves[0].x.empty())
    throw UsageError("the response has no finite value: there is nothing to draw");
  write_files(files, table, plot);
  return Exit::done;
}

}  // namespace bgsim::cli
