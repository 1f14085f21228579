/// Options that say something of the model beside its file: parameters from files, times, what is recorded.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim::cli {

/// --parameters, may be given again.
void add_parameters_option(CLI::App& app, ReadOptions& options);

/// --mode: which sides the switches of a model are on.
void add_mode_option(CLI::App& app, std::string& mode);

/// --start, --stop, --samples and --interval.
void add_time_options(CLI::App& app, ReadOptions& options);

/// -o FILE; --output NAME=EXPR, may be given again, or --output FILE; --record LIST, may be given again.
struct RecordOptions {
  std::string file;                  ///< of -o or --output
  std::vector<std::string> columns;  ///< texts NAME=EXPR
};
/// Adds the three to @p app. @p what and @p type tell of the file in the help: "file for the trace", "FILE".
/// @note Both arguments must live until the app has parsed.
void add_record_options(CLI::App& app, RecordOptions& record, ReadOptions& options, const std::string& what,
                        const std::string& type = "FILE");
/// -o and --output as file alone, as add_record_options has it, and --output NAME=EXPR.
void add_output_options(CLI::App& app, RecordOptions& record, const std::string& what, const std::string& type);

/// Splits the columns into names and expressions; to be called when the app has parsed.
void take_columns(const RecordOptions& record, ReadOptions& options);

/// The words that say @p options again.
std::vector<std::string> words_of(const ReadOptions& options);

}  // namespace bgsim::cli
