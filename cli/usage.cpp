#include "usage.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>

#include "bgsim/diagnostic.hpp"
#include "bgsim/text.hpp"

namespace bgsim::cli {
namespace {

namespace fs = std::filesystem;

struct Word {
  std::string_view other;
  const char* help;
};

/// Commands of other tools.
constexpr std::array kOtherCommands{
    Word{"simulate", "bgsim run simulates"},
    Word{"sim", "bgsim run simulates"},
    Word{"start", "bgsim run simulates"},
    Word{"validate", "bgsim check checks a model without running it"},
    Word{"lint", "bgsim check checks a model without running it"},
    Word{"info", "bgsim check describes a model"},
    Word{"causality", "bgsim check lists the strokes with reasons"},
    Word{"init", "bgsim new writes a starter model"},
    Word{"create", "bgsim new writes a starter model"},
    Word{"template", "bgsim new writes a starter model"},
    Word{"render", "bgsim draw draws the graph"},
    Word{"graph", "bgsim draw draws the graph"},
    Word{"view", "bgsim draw draws the graph, bgsim plot a trace"},
    Word{"chart", "bgsim plot draws a trace"},
    Word{"latex", "bgsim equations --latex prints the equations"},
    Word{"test", "bgsim verify compares scenes with their references"},
    Word{"compare", "bgsim verify compares scenes with references, bgsim plot --against draws two traces"},
    Word{"html", "bgsim report writes a page"},
    Word{"doc", "bgsim explain CODE explains a message"},
    Word{"scan", "bgsim sweep runs a scene with many values"},
    Word{"montecarlo", "bgsim sweep --sample runs a scene with random values"},
    Word{"sobol", "bgsim sweep --sample saltelli:N gives the shares of the variance"},
    Word{"morris", "bgsim sweep --sample morris:N gives elementary effects"},
    Word{"controllability", "bgsim control says which states inputs can move and outputs show"},
    Word{"observability", "bgsim control says which states inputs can move and outputs show"},
    Word{"ctrb", "bgsim control says which states inputs can move and outputs show"},
    Word{"tf", "bgsim transfer gives the transfer function in symbols"},
    Word{"mason", "bgsim transfer --paths lists paths and loops with their gains"},
    Word{"linearise", "bgsim linearize gives the matrices, bgsim poles the poles"},
    Word{"eigenvalues", "bgsim poles gives the poles"},
    Word{"eig", "bgsim poles gives the poles"},
    Word{"equilibrium", "bgsim steady looks for steady states"},
    Word{"trim", "bgsim steady looks for steady states"},
    Word{"freqresp", "bgsim bode gives the frequency response"},
    Word{"impulse", "bgsim step --impulse gives the impulse response"},
    Word{"pzmap", "bgsim poles and bgsim zeros"},
    Word{"calibrate", "bgsim fit finds parameters from measured data"},
    Word{"estimate", "bgsim fit finds parameters from measured data"},
    Word{"identify", "bgsim fit finds parameters from measured data"},
    Word{"optimize", "bgsim fit finds parameters from measured data"},
    Word{"sens", "bgsim sensitivity gives derivatives by parameters"},
    Word{"derivative", "bgsim sensitivity gives derivatives by parameters"},
    Word{"gradient", "bgsim sensitivity gives derivatives by parameters"},
    Word{"help", "bgsim --help lists the commands, bgsim COMMAND --help explains one"},
    Word{"version", "bgsim --version"},
};

/// Options of other tools, with those that stand for them here.
constexpr std::array kOtherOptions{
    Word{"--tolerance", "--relative"},
    Word{"--tol", "--relative"},
    Word{"--rtol", "--relative"},
    Word{"--reltol", "--relative"},
    Word{"--atol", "--absolute"},
    Word{"--abstol", "--absolute"},
    Word{"--solver", "--method"},
    Word{"--integrator", "--method"},
    Word{"--dt", "--step"},
    Word{"--step-size", "--step"},
    Word{"--param", "--set"},
    Word{"--parameter", "--set"},
    Word{"--override", "--set"},
    Word{"-p", "--set"},
    Word{"-s", "--set"},
    Word{"-D", "--set"},
    Word{"--out", "--output"},
    Word{"--csv", "--output"},
    Word{"--file", "--output"},
    Word{"--trace", "--output"},
    Word{"--experiment", "--scene"},
    Word{"--silent", "--quiet"},
    Word{"-q", "--quiet"},
    Word{"--json", "--report-json"},
};
/// What a scene says of its run.
constexpr std::array kSceneKeys{"--samples", "--interval", "--start", "--stop",
                                "--outputs", "--initial",  "--t-end", "--duration"};

/// "did you mean X?" with what precedes it; the nearest of the candidates.
std::string question(const std::string& name, const std::vector<std::string>& candidates) {
  const std::string near = nearest_name(name, candidates);
  return near.empty() ? std::string() : "did you mean " + near + "?";
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
  return text;
}

/// The option as it is written: "--relative" of "--relative=1e-3".
std::string bare(const std::string& argument) { return argument.substr(0, argument.find('=')); }

std::string unknown_option(const CLI::App& app, const std::string& argument) {
  const std::string name = bare(argument);
  const std::vector<std::string> names = option_names(app);
  const auto has = [&](std::string_view known) { return std::find(names.begin(), names.end(), known) != names.end(); };
  std::string help;
  for (const Word& word : kOtherOptions)
    if (word.other == name && has(word.help)) help = std::string("it is called ") + word.help;
  for (const std::string_view key : kSceneKeys)
    if (key == name && has("--scene"))
      help = "this belongs in the scene of the model: \"scenes\": { \"run\": { \"stop\": 1, \"samples\": 101 } }";
  if (help.empty()) help = question(name, names);
  if (help.empty() && !name.starts_with("--") && name.size() > 2) help = question("-" + name, names);  // -scene
  if (help.empty()) {
    std::vector<std::string> longer;  // --rel of --relative, --output-file of --output
    for (const std::string& known : names)
      if (name.size() > 3 && known.size() > 3 && (known.starts_with(name) || name.starts_with(known)))
        longer.push_back(known);
    if (longer.size() == 1) help = "did you mean " + longer[0] + "?";
  }
  return app.get_name() + " has no option " + short_name(name) + "\n" +
         (help.empty() ? "options: " + joined(names) : help);
}

/// An argument that no option takes, and that is none itself.
std::string left_over(const CLI::App& app, const std::string& argument) {
  const auto equals = argument.find('=');
  if (equals == 0)
    return "\"" + short_name(argument) +
           "\" is left over\nwrite --set NAME=VALUE without spaces around the equals sign";
  if (equals != std::string::npos && app.get_option_no_throw("--set") != nullptr)
    return "\"" + short_name(argument) + "\" is left over\nwrite --set " + short_name(argument) + " to set a value";
  return "\"" + short_name(argument) + "\" is left over: " + app.get_name() +
         " takes one file at a time, and options with -- before them";
}

/// A known option that CLI11 refuses for how often or with what it is given.
std::string misused_option(const CLI::App& app, const Arguments& arguments, const std::string& message) {
  const std::string name = message.substr(0, message.find(':'));
  const CLI::Option* option = app.get_option_no_throw(name);
  if (option == nullptr || !name.starts_with("-")) return {};
  std::size_t times = 0;
  for (const std::string& argument : arguments)
    if (option->check_name(bare(argument)) && argument.starts_with("-")) ++times;
  const std::string value = option->get_type_name().empty() ? "VALUE" : option->get_type_name();
  if (message.find(" missing") != std::string::npos) return name + " needs a value: " + name + " " + value;
  if (times > 1 && message.find("received") != std::string::npos)
    return name + " is given " + (times == 2 ? "twice" : std::to_string(times) + " times") +
           ", but holds once\nkeep one of them";
  return {};
}

}  // namespace

std::string unknown_command(const std::string& first, std::span<const std::string> commands) {
  std::error_code ignored;
  if (first.empty() || first.starts_with("-") || fs::exists(first, ignored) || first.find('/') != std::string::npos ||
      first.find('.') != std::string::npos)
    return {};
  std::string text = "\"" + short_name(first) + "\" is neither a command nor a file\n";
  const auto* other =
      std::find_if(kOtherCommands.begin(), kOtherCommands.end(), [&](const Word& w) { return w.other == first; });
  if (fs::exists(first + ".json", ignored))
    text += "did you mean " + short_name(first) + ".json?\n";
  else if (other != kOtherCommands.end())
    text += std::string(other->help) + "\n";
  else if (const std::string help = question(first, {commands.begin(), commands.end()}); !help.empty())
    text += help + "\n";
  text += "commands:";
  for (const std::string& command : commands) text += " " + command;
  return text + "; bgsim model.json runs a model; bgsim --help lists the commands";
}

std::string unknown_argument(const CLI::App& app, const Arguments& arguments, const std::string& message) {
  std::string text = misused_option(app, arguments, message);
  if (text.empty() && message.find("not expected") != std::string::npos) {
    const std::vector<std::string> names = option_names(app);
    for (const std::string& argument : app.remaining()) {
      if (argument == "--") continue;
      if (argument.starts_with("-") && argument.size() > 1) {
        text = unknown_option(app, argument);
        break;  // what follows it is likely to be its value
      }
      if (text.empty()) text = left_over(app, argument);
    }
  }
  if (text.empty() && message == "model.json is required") text = "which model? " + app.get_name() + " model.json";
  if (text.empty()) text = short_line(message, 500);
  return text + "\nusage: " + app.get_name() + " --help lists the options";
}

}  // namespace bgsim::cli
