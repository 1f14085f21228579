// bgsim draw: the bond graph as a picture.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "drawing.hpp"
#include "files.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "output_file.hpp"
#include "scenes.hpp"
#include "stages.hpp"

namespace bgsim::cli {

namespace {

struct DrawArguments {
  std::string mode;
  std::string file, output;
  ReadOptions reading;
  DrawingOptions how;
  bool no_names = false;
  double zoom = 2.0;
};

DrawArguments parse_draw(const Arguments& arguments) {
  DrawArguments options;
  CLI::App app("Draws the bond graph: half-arrows, causal strokes, signals, submodels as frames.", "bgsim draw");
  app.footer(
      "A model whose causality conflicts is drawn as well, with the strokes assigned up to the conflict.\n\n"
      "Examples:\n"
      "  bgsim draw models/actuator.json                     actuator.svg\n"
      "  bgsim draw models/rlc.json --effort-flow -o rlc.png\n"
      "  bgsim draw models/rlc.json -o - > rlc.svg");
  app.add_option("model.json", options.file, "the model")->required();
  add_read_options(app, options.reading);
  app.add_option("-o,--output", options.output,
                 "the picture, .svg, .png or .dot by its ending; - for SVG on standard output (default: NAME.svg)")
      ->type_name("FILE");
  add_mode_option(app, options.mode);
  app.add_flag("--effort-flow", options.how.effort_flow, "effort and flow at each bond instead of its name");
  app.add_flag("--no-bond-names", options.no_names, "no names of bonds");
  app.add_option("--zoom", options.zoom, "scale of a PNG (default: 2)")->type_name("X")->check(CLI::Range(0.1, 20.0));
  parse_arguments(app, arguments);
  options.how.bond_names = !options.no_names;
  return options;
}

}  // namespace

Exit draw_command(const Arguments& arguments) {
  DrawArguments options = parse_draw(arguments);
  const Study study = read_study(options.file, options.reading, options.mode);
  const Model& model = study.model();
  if (options.output.empty()) options.output = file_name(model.name) + ".svg";
  const std::string ending =
      options.output == "-" ? ".svg" : std::filesystem::path(options.output).extension().string();
  if (ending != ".svg" && ending != ".png" && ending != ".dot")
    throw UsageError("\"" + short_path(options.output) +
                     "\" ends with none of .svg, .png and .dot: which picture is meant?");
  check_outputs({{options.output, "the picture"}}, files_of(model));
  OutputFile file(options.output);
  const DrawnCausality causality = drawn_causality(model);
  std::string picture = ending == ".dot" ? drawing_dot(model, causality) : drawn_svg(model, causality, options.how);
  if (ending == ".png") picture = png_from_svg(picture, options.zoom);
  file.stream() << picture;
  file.commit();
  if (causality.problems.empty()) {
    assign_causality(study);  // for its warnings
    return Exit::done;
  }
  std::cerr << render(ModelError(causality.problems, model.sources))
            << "drawn with the strokes assigned up to there; where the rule is broken is marked\n";
  return Exit::model_at_fault;
}

}  // namespace bgsim::cli
