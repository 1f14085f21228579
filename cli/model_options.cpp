#include "model_options.hpp"

#include <algorithm>
#include <filesystem>

#include "command.hpp"
#include "names.hpp"

namespace bgsim::cli {

namespace {

namespace fs = std::filesystem;

/// Whether a value of --output has the form NAME=EXPR: an equals sign, and no folder before it.
bool is_column(const std::string& value) {
  const auto equals = end_of_name(value);
  return equals != std::string::npos && value.find('/') > equals;
}

/// Whether a column's text could as well be the name of a file.
bool may_be_file(const std::string& value) {
  static const std::vector<std::string> kEndings{".csv", ".tsv", ".txt", ".dat", ".json", ".html"};
  std::error_code ignored;
  return fs::exists(value, ignored) || std::any_of(kEndings.begin(), kEndings.end(),
                                                   [&](const std::string& ending) { return value.ends_with(ending); });
}

void take_file(RecordOptions& record, const std::string& value) {
  if (!record.file.empty())
    throw CLI::ValidationError("-o", "there are two files: \"" + record.file + "\" and \"" + value + "\"");
  record.file = value;
}

void take_output(RecordOptions& record, const std::string& value) {
  if (!is_column(value)) return take_file(record, value);
  if (may_be_file(value))
    throw CLI::ValidationError("--output", "\"" + value + "\" may be a column NAME=EXPR or a file; write -o \"" +
                                               value +
                                               "\" for the file, or put the expression in parentheses for the column");
  record.columns.push_back(value);
}

}  // namespace

void add_parameters_option(CLI::App& app, ReadOptions& options) {
  app.add_option("--parameters", options.parameter_files,
                 "a JSON file of parameters and initial values; may be repeated; later files and --set override")
      ->type_name("FILE")
      ->allow_extra_args(false);
}

void add_mode_option(CLI::App& app, std::string& mode) {
  app.add_option("--mode", mode,
                 "sides of switches, such as a=closed,b=open; the others as at the start of the first scene")
      ->type_name("SIDES");
}

void add_time_options(CLI::App& app, ReadOptions& options) {
  // Not bound directly: CLI11 makes nothing of an empty text, which is to be refused.
  const auto text = [&app](const char* name, std::optional<std::string>& target, const char* about) {
    return app
        .add_option_function<std::string>(
            name, [&target](const std::string& value) { target = value; }, about)
        ->type_name("EXPR");
  };
  text("--start", options.start, "time at which the run starts, instead of the scene's");
  text("--stop", options.stop, "time at which it stops, instead of the scene's");
  auto* samples =
      app.add_option("--samples", options.samples, "number of equidistant output times, instead of the scene's")
          ->type_name("N")
          ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}));
  text("--interval", options.interval, "distance of output times, instead of the scene's")->excludes(samples);
}

void add_output_options(CLI::App& app, RecordOptions& record, const std::string& what, const std::string& type) {
  app.add_option_function<std::string>(
         "-o", [&record](const std::string& value) { take_file(record, value); }, what)
      ->type_name(type);
  app.add_option_function<std::vector<std::string>>(
         "--output",
         [&record](const std::vector<std::string>& values) {
           for (const std::string& value : values) take_output(record, value);
         },
         "NAME=EXPR: an additional column, any expression over the model's names; may be repeated. Without an = it is "
         "as -o " +
             type)
      ->type_name("NAME=EXPR")
      ->allow_extra_args(false);
}

void add_record_options(CLI::App& app, RecordOptions& record, ReadOptions& options, const std::string& what,
                        const std::string& type) {
  add_output_options(app, record, what, type);
  app.add_option_function<std::vector<std::string>>(
         "--record",
         [&options](const std::vector<std::string>& lists) {
           for (const std::string& list : lists) {
             if (list.empty()) throw CLI::ValidationError("--record", "the list is empty");
             for (const std::string& part : parts_of_list(list)) options.record.push_back(name_of(part));
           }
         },
         "what to record instead of the scene's outputs: names of outputs and quantities between commas (one with a "
         "comma in "
         "double quotes), and the groups all, states, outputs")
      ->type_name("LIST")
      ->allow_extra_args(false);
}

void take_columns(const RecordOptions& record, ReadOptions& options) {
  for (const std::string& column : record.columns) {
    const auto equals = end_of_name(column);
    options.outputs.emplace_back(name_of(column.substr(0, equals)), column.substr(equals + 1));
  }
}

std::vector<std::string> words_of(const ReadOptions& options) {
  std::vector<std::string> words;
  const auto add = [&](const char* option, const std::string& value) { words.insert(words.end(), {option, value}); };
  if (options.allow_outside) words.emplace_back("--allow-outside");
  for (const std::string& folder : options.path) add("--path", folder);
  for (const std::string& file : options.parameter_files) add("--parameters", file);
  if (options.start) add("--start", *options.start);
  if (options.stop) add("--stop", *options.stop);
  if (options.samples) add("--samples", std::to_string(*options.samples));
  if (options.interval) add("--interval", *options.interval);
  for (const auto& [name, expression] : options.outputs) {
    words.emplace_back("--output");
    words.emplace_back(quoted_name(name)).append("=").append(expression);
  }
  std::string record;
  for (const std::string& name : options.record) {
    if (!record.empty()) record += ',';
    record += quoted_name(name);
  }
  if (!record.empty()) add("--record", record);
  return words;
}

}  // namespace bgsim::cli
