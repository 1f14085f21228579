/// The subcommands, one file each, and what they share: exit codes and faults.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace bgsim::cli {

/// Exit codes; fixed by model format 1 (docs/cli.md).
enum class Exit : int {
  done = 0,
  model_at_fault = 1,   ///< also: a reference is missed (verify)
  wrong_usage = 2,      ///< also: a file cannot be written
  numerics_failed = 3,  ///< also: interrupted
  defect = 4,
};

/// The worse of two outcomes when several things were done in one call.
constexpr Exit worse(Exit a, Exit b) { return a < b ? b : a; }

/// What was asked for cannot be done as asked: an option, or a place to write to. Exit::wrong_usage.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// --help was given, and answered.
class HelpAsked : public std::exception {};

/// Arguments after the subcommand's own name.
using Arguments = std::vector<std::string>;

/// Parses @p arguments into what @p app's options are bound to.
/// @throws UsageError for what the app does not take; HelpAsked after printing the app's help.
void parse_arguments(::CLI::App& app, Arguments arguments);

Exit run_command(const Arguments& arguments);          ///< run.cpp
Exit check_command(const Arguments& arguments);        ///< check.cpp
Exit equations_command(const Arguments& arguments);    ///< equations.cpp
Exit linearize_command(const Arguments& arguments);    ///< linearize.cpp
Exit steady_command(const Arguments& arguments);       ///< steady.cpp
Exit bode_command(const Arguments& arguments);         ///< bode.cpp
Exit step_command(const Arguments& arguments);         ///< bode.cpp
Exit poles_command(const Arguments& arguments);        ///< poles.cpp
Exit zeros_command(const Arguments& arguments);        ///< poles.cpp
Exit control_command(const Arguments& arguments);      ///< control.cpp
Exit transfer_command(const Arguments& arguments);     ///< transfer.cpp
Exit show_command(const Arguments& arguments);         ///< show.cpp
Exit draw_command(const Arguments& arguments);         ///< draw.cpp
Exit plot_command(const Arguments& arguments);         ///< plot.cpp
Exit reduce_command(const Arguments& arguments);       ///< reduce.cpp
Exit report_command(const Arguments& arguments);       ///< report.cpp
Exit trade_command(const Arguments& arguments);        ///< trade.cpp
Exit sweep_command(const Arguments& arguments);        ///< sweep.cpp
Exit sensitivity_command(const Arguments& arguments);  ///< sensitivity.cpp
Exit fit_command(const Arguments& arguments);          ///< fit/
Exit verify_command(const Arguments& arguments);       ///< verify.cpp
Exit new_command(const Arguments& arguments);          ///< new.cpp
Exit explain_command(const Arguments& arguments);      ///< explain.cpp
Exit completion_command(const Arguments& arguments);   ///< completion.cpp

}  // namespace bgsim::cli
