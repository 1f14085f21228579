// bgsim control: which states inputs move and outputs show, whatever the values of the parameters.
#include <CLI/CLI.hpp>
#include <iostream>

#include "bgsim/structure.hpp"
#include "bgsim/text.hpp"
#include "command.hpp"
#include "linear_options.hpp"
#include "stages.hpp"

namespace bgsim::cli {

namespace {

std::string list_of(const std::vector<std::string>& names, std::size_t most = 20) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < most; ++i) text += (i > 0 ? ", " : "") + short_name(names[i]);
  return text + (names.size() > most ? ", ..." : "");
}

void print(const std::string& what, const StructuralRank& found, std::size_t states, const char* no_path,
           const char* combination) {
  std::cout << what << ": " << found.rank << " of " << states << (states == 1 ? " state\n" : " states\n");
  if (!found.without_path.empty()) std::cout << "  " << no_path << ": " << list_of(found.without_path) << '\n';
  constexpr std::size_t kShown = 10;
  for (std::size_t i = 0; i < found.combinations.size() && i < kShown; ++i)
    std::cout << "  " << combination << ": " << list_of(found.combinations[i]) << '\n';
  if (found.combinations.size() > kShown) std::cout << "  and " << found.combinations.size() - kShown << " more\n";
}

}  // namespace

Exit control_command(const Arguments& arguments) {
  LinearArguments options;
  CLI::App app(
      "Which states the inputs can move and the outputs show (structural controllability and observability): for "
      "almost "
      "all values of the parameters.",
      "bgsim control");
  app.footer("Example: bgsim control models/quarter_car.json --in road --out zs");
  add_linear_options(app, options, "");
  add_path_options(app, options, true);
  parse_arguments(app, arguments);
  take_outputs(options);
  std::vector<std::string> inputs = split_names(options.inputs);
  if (inputs.empty()) inputs = all_sources(linear_study(options).model());
  const LinearStudy linear = linearized(options, inputs);
  if (inputs.empty() && linear.study.model().parameters.empty())
    throw UsageError("which inputs? the model has no sources; --in NAME may be a parameter or a signal");
  if (linear.point.outputs.empty()) throw UsageError("which outputs? --out NAME,NAME");
  const StructuralControl found = structural_control(linear.study.shared_model(), linear.point, inputs);
  std::cout << visible_line(linear.system.model) << ' ' << linear.where << ":\n";
  if (found.states.empty()) {
    std::cout << "the model has no states\n";
    return Exit::done;
  }
  if (inputs.empty())
    std::cout << "no inputs: the model has no sources, and --in names none\n";
  else
    print("controllable by " + list_of(found.inputs), found.controllable, found.states.size(),
          "no causal path from an input", "a combination of these is not moved");
  print("observable in " + list_of(found.outputs), found.observable, found.states.size(), "no causal path to an output",
        "a combination of these is not seen");
  const bool all = (inputs.empty() || found.controllable.rank == found.states.size()) &&
                   found.observable.rank == found.states.size();
  return all ? Exit::done : Exit::model_at_fault;
}

}  // namespace bgsim::cli
