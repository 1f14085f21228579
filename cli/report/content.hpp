/// What a report tells, before it is a page.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"
#include "command.hpp"
#include "lanes.hpp"
#include "options.hpp"
#include "stages.hpp"

namespace bgsim::cli {

/// A scene, run with the energy audit over time. Nothing is left out of the run: the audit and the activities are those
/// of the whole model.
struct ReportedScene {
  RunInputs inputs;  ///< as run: the reference's times are among the output times
  std::string about;
  RunResult result;
  std::vector<Lane> lanes;  ///< of its switches, diodes, contacts, memory and events
  std::vector<ElementActivity> activity;
  std::optional<CsvTable> reference;
  std::vector<ReferenceBand> bands;     ///< by output that the reference has
  std::optional<ReferenceCheck> check;  ///< none without a reference, or if the run ended early
};

/// Another command, called for the report's model.
struct ReportedStudy {
  Arguments command;                                          ///< "bgsim", "poles", ...: as a call of its own
  std::string text;                                           ///< what it printed, and the message if it failed
  std::vector<std::pair<std::string, std::string>> pictures;  ///< SVG: what it shows, the file
  Exit outcome = Exit::done;
};

struct ReportContent {
  explicit ReportContent(Study own) : study(std::move(own)) {}

  Study study;
  std::string file;
  std::vector<std::string> command;   ///< as it was called, with the program's name
  std::vector<std::string> settings;  ///< what was given beside the model and the scenes, as options
  std::string version, date;
  std::size_t points = 0;          ///< samples of a curve that are kept for drawing, at most
  std::optional<std::string> svg;  ///< the drawing
  std::string why_no_drawing;
  std::vector<ReportedScene> scenes;
  std::vector<ReportedStudy> studies;
};

/// Runs a scene for a report.
/// @throws ModelError as prepare_scene, and for its reference as read_reference and at_reference_times; UsageError.
ReportedScene run_for_report(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                             const RunLimits& limits, bool quiet);

/// What is asked for by "--study 'bode --in pump.e --out x'".
/// @param words   of the study: the command and its options
/// @param common  options that the report was given and each study takes, too
/// @param scene   for a study that does not name one; empty for the first
/// @return what it said, its messages too if it failed: nothing else of the report is lost for that
/// @throws UsageError if there is no such command; Interrupted.
ReportedStudy run_study(const Study& study, const std::string& file, const std::string& words, const Arguments& common,
                        const std::string& scene);

/// The command of a study, and that it is one.
/// @throws UsageError
void check_study(const std::string& words);

/// The page: one HTML file that needs nothing else.
std::string report_page(const ReportContent& content);

// Its sections (report_sections.cpp).
std::string causality_section(const ReportContent& content);
std::string parameters_section(const ReportContent& content);
std::string equations_section(const ReportContent& content);
std::string activity_section(const ReportContent& content);
std::string studies_section(const ReportContent& content);
std::string statistics_section(const ReportContent& content);
std::string reproduction_section(const ReportContent& content);

/// "1.5e-07", with at most @p digits digits.
std::string short_number(double value, int digits);

}  // namespace bgsim::cli
