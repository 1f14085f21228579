#include "stages.hpp"

#include <algorithm>
#include <iostream>

#include "bgsim/modes.hpp"
#include "command.hpp"

namespace bgsim::cli {

void print_warnings(const std::vector<Diagnostic>& warnings, const Model& model) {
  for (const Diagnostic& warning : warnings) std::cerr << render(warning, *model.sources);
}

bool is_wrong_usage(const ModelError& error) {
  const std::vector<SourceText> sources = error.sources ? source_texts(*error.sources) : std::vector<SourceText>{};
  return std::all_of(error.diagnostics.begin(), error.diagnostics.end(), [&](const Diagnostic& problem) {
    if (problem.place && problem.place->document.index() < sources.size())
      return sources[problem.place->document.index()].path == kCommandLine;
    // A circle of parameters has places in its notes alone. It is the model's own if all are in its file.
    const bool of_the_file =
        !problem.notes.empty() && std::all_of(problem.notes.begin(), problem.notes.end(), [](const Note& note) {
          return note.place && note.place->document.index() == 0;
        });
    return problem.code != "BG100" && !of_the_file;
  });
}

Study read_study(const std::string& path, const ReadOptions& reading, const std::string& mode) {
  try {
    const Study study(path, reading);
    print_warnings(study.model().warnings, study.model());
    const Study begun = study.at_start();
    return mode.empty() ? begun : begun.in_mode(parse_mode(begun.model(), mode, mode_of(begun.model())));
  } catch (const ModelError& error) {
    if (!is_wrong_usage(error)) throw;
    throw UsageError(render(error));
  }
}

void assign_causality(const Study& study) { print_warnings(study.causality().warnings, study.model()); }

void derive_equations(const Study& study) {
  print_warnings(study.equations().warnings, study.model());
  static_cast<void>(study.order());  // for its faults
}

void print_mode(const Study& study) {
  const Mode mode = mode_of(study.model());
  if (!mode.empty()) std::cout << "in the mode " << mode_text(study.model(), mode) << ":\n";
}

Study study_of(const std::string& path, const ReadOptions& reading, const std::string& mode) {
  Study study = read_study(path, reading, mode);
  assign_causality(study);
  derive_equations(study);
  return study;
}

}  // namespace bgsim::cli
