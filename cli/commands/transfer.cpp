// bgsim transfer: the transfer function in symbols, and the causal paths and loops that make it.
#include "bgsim/transfer.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "linear_options.hpp"
#include "stages.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace {

std::string power_text(int power) { return power == 0 ? "" : power == 1 ? " s" : " s^" + std::to_string(power); }

void print(const char* what, const SymbolicPolynomial& polynomial) {
  TextTable table({what, "value", "coefficient"});
  const bool nothing = std::all_of(polynomial.begin(), polynomial.end(), [](const auto& c) { return c.text == "0"; });
  if (nothing) table.add({"1", "0", "0"});
  for (std::size_t i = polynomial.size(); i-- > 0;)
    if (polynomial[i].text != "0")
      table.add({i == 0   ? "1"
                 : i == 1 ? "s"
                          : "s^" + std::to_string(i),
                 number_text(polynomial[i].value, 6), polynomial[i].text});
  std::cout << table.text();
}

void print(const char* what, const std::vector<CausalPath>& paths) {
  TextTable table({what, "at the point", "through", "gain"});
  std::size_t number = 0;
  for (const CausalPath& path : paths) {
    std::string value, through;
    for (const auto& [power, coefficient] : path.values)
      value += (value.empty() ? "" : " + ") + number_text(coefficient, 5) + power_text(power);
    for (const std::string& element : path.elements) through += (through.empty() ? "" : ", ") + short_name(element);
    table.add({std::to_string(++number), value, through, path.gain});
  }
  std::cout << table.text();
}

void print(const std::vector<std::pair<std::string, double>>& values) {
  if (values.empty()) return;
  std::cout << "at the point:";
  for (std::size_t i = 0; i < values.size() && i < 20; ++i)
    std::cout << (i > 0 ? ", " : " ") << short_name(values[i].first) << " = " << number_text(values[i].second, 6);
  std::cout << (values.size() > 20 ? ", ..." : "") << '\n';
}

}  // namespace

Exit transfer_command(const Arguments& arguments) {
  LinearArguments options;
  bool paths = false;
  CLI::App app("The transfer function from an input to an output in symbols: coefficients over the parameters' names.",
               "bgsim transfer");
  app.footer(
      "Of models with few states between input and output. Nonlinear laws are linearized at the point.\n"
      "Example: bgsim transfer models/dc_motor.json --in V --out omega --paths");
  add_linear_options(app, options, "");
  add_path_options(app, options, false);
  app.add_flag("--paths", paths, "also lists causal paths and loops with their gains (Mason) and elements");
  parse_arguments(app, arguments);
  const std::vector<std::string> inputs = split_names(options.inputs);
  require_one(inputs, "--in", "pump.e");
  require_one(options.outputs, "--out", "x");
  take_outputs(options);
  if (options.reading.record.size() != 1) require_one(options.reading.record, "--out", "x");
  const LinearStudy linear = linearized(options, inputs);
  const TransferFunction transfer = transfer_function(linear.study.shared_model(), linear.point, inputs.front());
  std::cout << visible_line(linear.system.model) << ' ' << linear.where << ", from " << short_name(transfer.input)
            << " to " << short_name(transfer.output) << ":\n";
  print("numerator", transfer.numerator);
  std::cout << '\n';
  print("denominator", transfer.denominator);
  print(transfer.values);
  if (!transfer.hidden.empty()) {
    std::cout << "not between input and output:";
    for (std::size_t i = 0; i < transfer.hidden.size() && i < 12; ++i)
      std::cout << (i > 0 ? ", " : " ") << short_name(transfer.hidden[i]);
    std::cout << (transfer.hidden.size() > 12 ? ", ..." : "") << '\n';
  }
  constexpr double kApart = 1e-6;
  if (!(transfer.mismatch <= kApart))
    std::cerr << "note: the values of the coefficients give a response that differs from that of the matrices (bgsim "
                 "bode) by a part of "
              << number_text(transfer.mismatch, 2) << " of its terms\n";
  if (!paths) return Exit::done;
  const CausalPaths found = causal_paths(linear.study.shared_model(), linear.point, inputs.front());
  std::cout << '\n';
  print("path", found.paths);
  std::cout << '\n';
  if (found.loops.empty())
    std::cout << (found.all ? "no loops\n" : "");
  else
    print("loop", found.loops);
  print(found.values);
  if (!found.all) std::cout << "there are more than these\n";
  return Exit::done;
}

}  // namespace bgsim::cli
