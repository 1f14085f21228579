#include "stages.hpp"

#include <algorithm>
#include <iostream>

#include "command.hpp"

namespace bgsim::cli {

void print_warnings(const std::vector<Diagnostic>& warnings, const Model& model) {
  for (const Diagnostic& warning : warnings) std::cerr << render(warning, *model.sources);
}

bool is_wrong_usage(const ModelError& error) {
  const std::vector<SourceText> sources = error.sources ? source_texts(*error.sources) : std::vector<SourceText>{};
  return std::all_of(error.diagnostics.begin(), error.diagnostics.end(), [&](const Diagnostic& problem) {
    if (!problem.place || problem.place->document.index() >= sources.size()) return problem.code != "BG100";
    return sources[problem.place->document.index()].path == kCommandLine;
  });
}

Study read_study(const std::string& path, const ReadOptions& reading) {
  try {
    Study study(path, reading);
    print_warnings(study.model().warnings, study.model());
    return study;
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

Study study_of(const std::string& path, const ReadOptions& reading) {
  Study study = read_study(path, reading);
  assign_causality(study);
  derive_equations(study);
  return study;
}

}  // namespace bgsim::cli
