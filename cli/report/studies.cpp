// Studies on a report's page: other commands, called for the report's model, with what they print and draw.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>

#include "bgsim/text.hpp"
#include "bgsim/xml.hpp"
#include "exit_code.hpp"
#include "html.hpp"
#include "report/content.hpp"
#include "scenes.hpp"
#include "scratch.hpp"
#include "shell_word.hpp"
#include "standard_output.hpp"

namespace bgsim::cli {

namespace {

/// Where a command draws.
enum class Draws {
  nothing,
  a_file,    ///< that is asked for by -o FILE.svg
  a_folder,  ///< of -o FOLDER, asked for by --picture
  beside,    ///< files named after -o BASE
};

struct StudyCommand {
  const char* name;
  Exit (*act)(const Arguments&);
  Draws draws;
  bool has_scene;
};

constexpr StudyCommand kStudies[] = {
    {"bode", bode_command, Draws::a_file, true},          {"check", check_command, Draws::nothing, false},
    {"control", control_command, Draws::nothing, true},   {"linearize", linearize_command, Draws::nothing, true},
    {"poles", poles_command, Draws::nothing, true},       {"sensitivity", sensitivity_command, Draws::a_file, true},
    {"steady", steady_command, Draws::nothing, true},     {"step", step_command, Draws::a_file, true},
    {"sweep", sweep_command, Draws::a_folder, true},      {"trade", trade_command, Draws::beside, true},
    {"transfer", transfer_command, Draws::nothing, true}, {"zeros", zeros_command, Draws::nothing, true},
};

Arguments split(const std::string& words) { return ::CLI::detail::split_up(words); }

const StudyCommand& command_of(const std::string& words) {
  const Arguments split_words = split(words);
  const std::string name = split_words.empty() ? "" : split_words.front();
  const auto* const found =
      std::find_if(std::begin(kStudies), std::end(kStudies), [&](const StudyCommand& c) { return name == c.name; });
  if (found != std::end(kStudies)) return *found;
  std::string names;
  for (const StudyCommand& command : kStudies) names += (names.empty() ? "" : ", ") + std::string(command.name);
  throw UsageError("--study " + shell_word(words) + ": the first word is to be one of " + names);
}

/// The value after an option, in either of its forms; empty if it is not there.
std::string value_of(const Arguments& words, const std::string& option) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == option && i + 1 < words.size()) return words[i + 1];
    if (words[i].starts_with(option + "=")) return words[i].substr(option.size() + 1);
  }
  return {};
}

bool has(const Arguments& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

void add(Arguments& words, std::initializer_list<std::string> more) { words.insert(words.end(), more); }

/// The SVG files of a folder whose names begin like this, in the order of their names.
std::vector<std::pair<std::string, std::string>> pictures_in(const std::string& folder, const std::string& beginning) {
  std::vector<std::string> files;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder.empty() ? "." : folder, none)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(beginning) && name.ends_with(".svg")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::pair<std::string, std::string>> pictures;
  for (const std::string& file : files) pictures.emplace_back(std::filesystem::path(file).filename(), read_whole(file));
  return pictures;
}

/// Calls a command, and keeps what it says.
Exit called(const StudyCommand& command, const Arguments& arguments, std::string& text) {
  const KeptText kept;
  Exit outcome = Exit::done;
  try {
    outcome = command.act(arguments);
  } catch (const ModelError& error) {
    std::cerr << render(error);
    outcome = exit_of(error);
  } catch (const UsageError& error) {
    std::cerr << "bgsim: " << error.what() << '\n';
    outcome = Exit::wrong_usage;
  } catch (const HelpAsked&) {
  }
  text = kept.text();
  return outcome;
}

}  // namespace

void check_study(const std::string& words) { (void)command_of(words); }

ReportedStudy run_study(const Study& study, const std::string& file, const std::string& words, const Arguments& common,
                        const std::string& scene) {
  const StudyCommand& command = command_of(words);
  Arguments own = split(words);
  own.erase(own.begin());
  if (command.has_scene && !scene.empty() && value_of(own, "--scene").empty()) add(own, {"--scene", scene});
  own.insert(own.end(), common.begin(), common.end());
  // Results of many runs stay where the command itself would leave them, so that it goes on with them when called
  // again.
  const Scratch scratch;
  const std::string drawn = scratch.file("picture.svg");
  std::string place = value_of(own, "-o");
  if (command.draws == Draws::a_folder || command.draws == Draws::beside) {
    if (place.empty()) {
      const std::string named = value_of(own, "--scene");
      const std::string first = study.model().scenes.empty() ? "" : study.model().scenes.front().name;
      place = run_name(study.model(), file, named.empty() ? first : named) + "." + command.name;
      add(own, {"-o", place});
    }
    if (command.draws == Draws::a_folder && !has(own, "--picture")) add(own, {"--picture"});
  }
  ReportedStudy made;
  made.command = {"bgsim", command.name, file};
  made.command.insert(made.command.end(), own.begin(), own.end());
  Arguments arguments = own;
  arguments.insert(arguments.begin(), file);
  if (command.draws == Draws::a_file) add(arguments, {"-o", drawn});
  made.outcome = called(command, arguments, made.text);
  if (command.draws == Draws::a_file && std::filesystem::exists(drawn))
    made.pictures.emplace_back(std::string(command.name) + ".svg", read_whole(drawn));
  if (command.draws == Draws::a_folder) made.pictures = pictures_in(place, "");
  if (command.draws == Draws::beside) {
    const std::filesystem::path base(place);
    made.pictures = pictures_in(base.parent_path(), base.filename().string() + ".");
  }
  return made;
}

std::string studies_section(const ReportContent& content) {
  if (content.studies.empty()) return {};
  std::string text;
  for (const ReportedStudy& study : content.studies) {
    std::string line;
    for (const std::string& word : study.command) line += (line.empty() ? "" : " ") + shell_word(word);
    text += xml_text_element("h3", study.command[1]) + "\n" + paragraph(xml_text_element("code", line));
    if (study.outcome != Exit::done)
      text += paragraph(badge(false, "exit code " + std::to_string(static_cast<int>(study.outcome))));
    if (!study.text.empty()) text += preformatted(study.text, study.outcome == Exit::done ? "" : "warning");
    line += ": ";
    for (const auto& [name, svg] : study.pictures) {
      std::string caption = line;
      text += scrolling(svg_image(svg, caption.append(name)));
    }
  }
  return html_section("studies", "Studies", text);
}

}  // namespace bgsim::cli
