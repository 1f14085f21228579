// bgsim equations: the state equations in the model's own names.
#include <CLI/CLI.hpp>
#include <iostream>

#include "command.hpp"
#include "options.hpp"
#include "stages.hpp"

namespace bgsim::cli {

Exit equations_command(const Arguments& arguments) {
  std::string file;
  bool latex = false;
  ReadOptions reading;
  CLI::App app("Prints the state equations that the causality yields.", "bgsim equations");
  app.add_option("model.json", file, "the model")->required();
  add_read_options(app, reading);
  app.add_flag("--latex", latex, "as LaTeX");
  app.footer(
      "Examples:\n  bgsim equations models/bellow.json           as text\n  bgsim equations models/bellow.json --latex "
      "  as LaTeX");
  parse_arguments(app, arguments);

  const Stages stages = run_stages(file, reading, Stage::order);
  const auto text = latex ? equations_latex : equations_text;
  std::cout << text(*stages.model, *stages.system, *stages.order);
  return Exit::done;
}

}  // namespace bgsim::cli
