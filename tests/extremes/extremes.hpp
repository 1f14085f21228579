/// The extremes: what the physics says of an input, and what bgsim does with it. The same rows are the suite, each a
/// test of its own, and the table of docs/extremes.md.
#pragma once

#include <catch2/catch.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "support/run.hpp"

namespace bgsim::test {

/// One row: the texts are Markdown.
struct Extreme {
  std::string input;
  std::string must;                   ///< what must happen, with its source
  std::function<std::string()> does;  ///< runs it, checks it (Catch), and tells what happened in stable words
  std::string tags = {};              ///< Catch's: "[long]"
};

/// Rows of one heading. Each becomes a test, "HEADING: INPUT", which also compares its row with the document; with
/// BGSIM_UPDATE_GOLDEN=1 the row is rewritten.
class Section {
 public:
  Section(std::string title, std::vector<Extreme> rows,
          const Catch::SourceLineInfo& where = Catch::SourceLineInfo(__builtin_FILE(), __builtin_LINE()));
};

/// What became of a model's text: a run, or the first thing said against it.
struct Ran {
  std::optional<RunResult> result;  ///< none if the model was refused
  std::optional<Diagnostic> said;   ///< the first error, or why the run ended
  std::vector<Diagnostic> warnings;

  [[nodiscard]] bool completed() const { return result && result->stop == StopReason::completed; }
  [[nodiscard]] double last(const std::string& name) const { return bgsim::test::last(*result, name); }
  [[nodiscard]] std::string note(const std::string& containing) const;  ///< of the report; empty if none
};

/// Reads and runs. No number of the trace may be NaN or infinite: checked here for every run of the suite.
Ran ran(const std::string& text, const SceneOverrides& overrides = {}, const std::string& scene = {});

/// The same of a compiled model.
Ran ran(const CompiledModel& compiled);

// Texts of the table
/// "error below 1e-05": the decade above, which rounding does not change. Checks that @p error is at most @p limit.
std::string within(double error, double limit);
/// "BG601: ...", digits cut to three. Checks the code, and that all of @p words are there.
std::string diagnosis(const Ran& ran, const std::string& code, const std::vector<std::string>& words = {});

// Models
/// Se - 1 - R, C, with q and u = q/C.
std::string charging(const std::string& effort, const std::string& resistance, const std::string& capacitance,
                     const std::string& scene, const std::string& initial = "");
/// C fed by an MSf of any expression.
std::string filling(const std::string& flow, const std::string& initial, const std::string& scene);
/// C and I on a 1-junction.
std::string oscillator(const std::string& inertance, const std::string& capacitance, const std::string& initial,
                       const std::string& scene);
/// Elements (JSON members), bonds ("a>b c>d"), outputs (JSON members) and one scene (JSON members).
std::string model_of(const std::string& elements, const std::string& bonds, const std::string& outputs,
                     const std::string& scene);

}  // namespace bgsim::test
