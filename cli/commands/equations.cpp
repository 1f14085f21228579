// bgsim equations: the state equations in the model's own names.
#include <CLI/CLI.hpp>
#include <iostream>

#include "bgsim/describe.hpp"
#include "command.hpp"
#include "model_options.hpp"
#include "names.hpp"
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
  std::vector<std::string> columns;
  app.add_option("--output", columns, "one more output, any expression over the model's names; may be given again")
      ->type_name("NAME=EXPR")
      ->allow_extra_args(false);
  std::string mode;
  add_mode_option(app, mode);
  app.footer(
      "Examples:\n  bgsim equations models/bellow.json           as text\n  bgsim equations models/bellow.json --latex "
      "  as LaTeX");
  parse_arguments(app, arguments);

  for (const std::string& column : columns)
    if (end_of_name(column) == std::string::npos)
      throw UsageError("--output \"" + column + "\" is not of the form NAME=EXPR");
  take_columns({{}, columns}, reading);
  const Study study = study_of(file, reading, mode);
  const auto text = latex ? equations_latex : equations_text;
  std::cout << text(study.model(), study.equations(), study.order());
  return Exit::done;
}

}  // namespace bgsim::cli
