// The command line: which subcommand, and the exit code of its errors. No physics here.
#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>

#include "bgsim/diagnostic.hpp"
#include "bgsim/text.hpp"
#include "command.hpp"
#include "exit_code.hpp"
#include "interruption.hpp"
#include "standard_output.hpp"
#include "usage.hpp"

namespace bgsim::cli {

namespace {

struct Command {
  const char* name;
  const char* about;
  Exit (*act)(const Arguments&);
};

constexpr Command kCommands[] = {
    {"run", "simulate a scene and write its trace (the default)", run_command},
    {"check", "report strokes and why, states, dependent stores, loops, units", check_command},
    {"equations", "print the state equations, --latex for LaTeX", equations_command},
    {"draw", "draw the bond graph: SVG, PNG or DOT", draw_command},
    {"plot", "draw a trace, or two over each other with their difference", plot_command},
    {"linearize", "linearize at a point: A, B, C, D by exact derivatives", linearize_command},
    {"poles", "poles with damping, frequency and the stores they belong to", poles_command},
    {"control", "which states inputs can move and outputs show", control_command},
    {"transfer", "the transfer function in symbols, causal paths and loops", transfer_command},
    {"zeros", "zeros, poles and gain from an input to an output", zeros_command},
    {"bode", "frequency response, or the impedance at a bond", bode_command},
    {"step", "response to a unit step or impulse", step_command},
    {"steady", "states in which all stores rest", steady_command},
    {"show", "print the value of a stage of the pipeline", show_command},
    {"reduce", "remove elements that a scene does not require", reduce_command},
    {"report", "scenes on one HTML page: plots, equations, energy audit", report_command},
    {"trade", "measure error against cost over methods and tolerances", trade_command},
    {"sweep", "run a scene with many values; a table of results", sweep_command},
    {"sensitivity", "by how much outputs change with parameters", sensitivity_command},
    {"fit", "find parameters from measured data", fit_command},
    {"verify", "hold scenes against their reference traces", verify_command},
    {"new", "write a starter model", new_command},
    {"explain", "explain the code of a message", explain_command},
    {"completion", "print a script for shell completion", completion_command},
};

void print_help() {
  std::cout << "bgsim: bond graphs from JSON to a trace.\n\n"
               "Usage: bgsim model.json [--scene NAME] [--set NAME=EXPR]... [--relative X] [--absolute X]\n"
               "             [--method NAME] [-o FILE]\n"
               "       bgsim COMMAND ...\n\n"
               "Commands (details: bgsim COMMAND --help; for a file of such a name write ./NAME):\n";
  for (const Command& command : kCommands) {
    std::cout << "  " << command.name << std::string(13 - std::string(command.name).size(), ' ') << command.about
              << '\n';
  }
  std::cout << "\nExamples:\n"
               "  bgsim models/bellow.json                 simulate the first scene; trace in bellow.tracking.csv\n"
               "  bgsim models/bellow.json -o - --quiet    the trace on standard output\n"
               "  bgsim check models/actuator.json         causality, states, loops and units in words\n"
               "  bgsim draw models/actuator.json          the bond graph in actuator.svg\n"
               "  bgsim plot actuator.bending.csv          a trace in actuator.bending.svg\n"
               "  bgsim verify                             every model under models/ against its references\n\n"
               "Exit codes: 0 done, 1 error in the model, 2 wrong usage, 3 numerical failure,\n"
               "4 a defect of bgsim.\n";
}

Exit act(const Arguments& arguments) {
  if (arguments.empty()) throw UsageError("which model? bgsim model.json; bgsim --help lists the commands");
  const std::string& first = arguments.front();
  if (arguments.size() == 1 && (first == "--help" || first == "-h")) {
    print_help();
    return Exit::done;
  }
  if (arguments.size() == 1 && first == "--version") {
    std::cout << "bgsim " << BGSIM_VERSION << '\n';
    return Exit::done;
  }
  for (const Command& command : kCommands) {
    if (first == command.name) return command.act({arguments.begin() + 1, arguments.end()});
  }
  std::vector<std::string> names;
  for (const Command& command : kCommands) names.emplace_back(command.name);
  if (const std::string fault = unknown_command(first, names); !fault.empty()) throw UsageError(fault);
  return run_command(arguments);
}

Exit act_and_flush(const Arguments& arguments) {
  Exit outcome = Exit::done;
  try {
    outcome = act(arguments);
  } catch (const HelpAsked&) {
  }
  StandardOutput::flush();
  return outcome;
}

int guarded(const Arguments& arguments) {
  const auto end = [](Exit code) { return static_cast<int>(code); };
  try {
    return end(act_and_flush(arguments));
  } catch (const ModelError& error) {
    std::cerr << render(error);
    return end(exit_of(error));
  } catch (const Interrupted& interruption) {
    std::cerr << "bgsim: " << interruption.what() << '\n';
    return end(Exit::numerics_failed);
  } catch (const UsageError& error) {
    const std::string text = error.what();
    std::cerr << "bgsim: " << text << (text.ends_with('\n') ? "" : "\n");
    return end(Exit::wrong_usage);
  } catch (const std::bad_alloc&) {
    std::cerr << "bgsim: out of memory\n";
    return end(Exit::numerics_failed);
  } catch (const std::exception& error) {
    std::cerr << "bgsim: a defect of bgsim, not of the model: " << error.what()
              << "\nPlease report it with the model that shows it.\n";
    return end(Exit::defect);
  }
}

}  // namespace

void parse_arguments(CLI::App& app, Arguments arguments) {
  const Arguments given = arguments;
  // CLI11 takes a vector of arguments in reverse.
  std::reverse(arguments.begin(), arguments.end());
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::CallForHelp&) {
    std::cout << app.help();
    throw HelpAsked();
  } catch (const CLI::ParseError& error) {
    throw UsageError(unknown_argument(app, given, error.what()));
  }
  // As a shell makes of a variable that is not set: to take it for an option that is not given would lose what it is
  // for.
  for (const CLI::Option* option : app.get_options())
    for (const std::string& value : option->results())
      if (value.empty() && option->get_envname().empty())
        throw UsageError(option->get_name() + " is given an empty text: give it a value, or leave it out");
}

}  // namespace bgsim::cli

int main(int argc, char** argv) {
  // A closed pipe, and a file that grows beyond its limit, are then failed writes, reported like any other.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  const bgsim::cli::StandardOutput output;
  bgsim::cli::catch_interruptions();
  return bgsim::cli::guarded({argv + 1, argv + argc});
}
