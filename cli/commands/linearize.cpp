// bgsim linearize: the linear system at a point, as matrices.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "files.hpp"
#include "linear_files.hpp"
#include "linear_options.hpp"
#include "output_file.hpp"

namespace bgsim::cli {

namespace {

std::string ending_of(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  if (ending != ".json" && ending != ".csv" && ending != ".m")
    throw UsageError("-o " + short_path(file) + ": the file is to end in .json, .csv or .m");
  return ending;
}

}  // namespace

Exit linearize_command(const Arguments& arguments) {
  LinearArguments options;
  bool descriptor = false;
  CLI::App app("Linearizes a model at a point, by exact derivatives: x' = A x + B u, y = C x + D u.",
               "bgsim linearize");
  app.footer("Example: bgsim linearize models/dc_motor.json --in supply --out omega --at steady -o motor.json");
  add_linear_options(app, options, "writes the matrices, exact: .json, .csv or .m (Octave, MATLAB)");
  add_path_options(app, options, true);
  app.add_flag("--descriptor", descriptor, "E v' = A v + B u, y = C v + D u: algebraic loops are not eliminated");
  parse_arguments(app, arguments);
  const std::string ending = options.output.empty() ? "" : ending_of(options.output);
  take_outputs(options);
  std::vector<std::string> inputs = split_names(options.inputs);
  // All sources are known once the model is read.
  if (inputs.empty()) inputs = all_sources(linear_study(options).model());
  const LinearStudy linear = linearized(options, inputs);
  if (options.output.empty()) {
    std::cout << linear_text(linear.system, linear.where, descriptor);
    return Exit::done;
  }
  check_outputs({{options.output, "-o"}}, files_of(linear.study.model()));
  OutputFile file(options.output);
  file.stream() << (ending == ".json"  ? linear_json(linear.system, linear.where, descriptor)
                    : ending == ".csv" ? linear_csv(linear.system, descriptor)
                                       : linear_m(linear.system, linear.where, descriptor));
  commit_all({&file});
  return Exit::done;
}

}  // namespace bgsim::cli
