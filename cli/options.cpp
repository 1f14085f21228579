#include "options.hpp"

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string_view>
#include <utility>

#include "bgsim/text.hpp"

namespace bgsim::cli {

namespace {

/// The words of method_list().
std::vector<std::string> method_names() {
  std::vector<std::string> names{""};
  for (const char c : method_list()) {
    if (c != ',' && c != ' ')
      names.back() += c;
    else if (names.back() == "and")
      names.back().clear();
    else if (!names.back().empty())
      names.emplace_back();
  }
  return names;
}

/// The method with this name in another tool, or with the nearest name; empty if none is.
std::string likely_method(const std::string& name) {
  static constexpr std::array<std::pair<std::string_view, const char*>, 9> kOthers{{{"ode45", "erk5"},
                                                                                    {"rk45", "erk5"},
                                                                                    {"dopri5", "erk5"},
                                                                                    {"ode23", "erk3"},
                                                                                    {"rk23", "erk3"},
                                                                                    {"ode15s", "bdf"},
                                                                                    {"cvode", "bdf"},
                                                                                    {"lsoda", "bdf"},
                                                                                    {"dassl", "ida"}}};
  for (const auto& [other, method] : kOthers)
    if (other == name) return method;
  std::string small = name;
  for (char& c : small)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return method_from(small) ? small : nearest_name(name, method_names());
}

/// "a:b" as folders.
std::vector<std::string> folders_in(const std::string& list) {
  std::vector<std::string> folders;
  std::istringstream in(list);
  for (std::string folder; std::getline(in, folder, ':');)
    if (!folder.empty()) folders.push_back(folder);
  return folders;
}

}  // namespace

CLI::Validator positive_number() {
  const auto check = [](const std::string& text) {
    double value = 0.0;
    const bool number = CLI::detail::lexical_cast(text, value);
    return number && value > 0.0 && std::isfinite(value) ? std::string() : text + " is not a number above zero";
  };
  return {check, ""};
}

void add_read_options(CLI::App& app, ReadOptions& reading) {
  reading.allow_outside = false;
  const char* inherited = std::getenv("BGSIM_PATH");
  reading.path = folders_in(inherited != nullptr ? inherited : "");
  app.add_option_function<std::vector<std::string>>(
         "--path",
         [&reading](const std::vector<std::string>& lists) {
           std::vector<std::string> folders;
           for (const std::string& list : lists)
             for (const std::string& folder : folders_in(list)) {
               std::error_code ignored;
               if (!std::filesystem::is_directory(folder, ignored))
                 throw CLI::ValidationError("--path", "there is no folder \"" + short_path(folder) + '"');
               folders.push_back(folder);
             }
           reading.path.insert(reading.path.begin(), folders.begin(), folders.end());
         },
         "folders in which submodels are looked for that are not beside the file that names them, before those of "
         "BGSIM_PATH; may be given again")
      ->type_name("DIR[:DIR]")
      ->allow_extra_args(false);
  app.add_flag("--allow-outside", reading.allow_outside,
               "let the model name files (types, tables, references) outside of its folder");
}

void add_set_option(CLI::App& app, SceneOverrides& overrides) {
  app.add_option("--set", overrides.set, "a parameter or an initial value; may be given again")
      ->type_name("NAME=EXPR")
      ->allow_extra_args(false);
}

void add_method_option(CLI::App& app, SceneOverrides& overrides, const std::map<std::string, bool*>& others,
                       const std::string& words) {
  const auto take = [&overrides, others, words](const std::string& name) {
    if (const auto other = others.find(name); other != others.end()) {
      *other->second = true;
      return;
    }
    overrides.method = method_from(name);
    if (overrides.method) return;
    const std::string near = likely_method(name);
    throw CLI::ValidationError("--method", "there is no method \"" + name + "\"; " +
                                               (near.empty() ? "" : "did you mean " + near + "? ") + "There are " +
                                               (words.empty() ? "" : words + "; and of integration ") + method_list());
  };
  app.add_option_function<std::string>(
         "--method",
         [take, several = !others.empty()](const std::string& names) {
           if (!several) return take(names);
           for (const std::string& name : CLI::detail::split(names, ',')) take(name);
         },
         (words.empty() ? "" : words + "; and with a comma, or alone, that of integration: ") + method_list())
      ->type_name(others.empty() ? "NAME" : "LIST");
}

void add_solver_options(CLI::App& app, SceneOverrides& overrides) {
  add_method_option(app, overrides, {}, {});
  add_tolerance_options(app, overrides);
}

void add_tolerance_options(CLI::App& app, SceneOverrides& overrides) {
  const CLI::Validator positive = positive_number();
  app.add_option("--relative", overrides.relative, "relative tolerance")->type_name("X")->check(positive);
  app.add_option("--absolute", overrides.absolute, "absolute tolerance of every state")
      ->type_name("X")
      ->check(positive);
  app.add_option("--step", overrides.step, "length of the steps of euler, implicit_euler, rk4 and verlet")
      ->type_name("H")
      ->check(positive);
  app.add_option("--max-order", overrides.max_order, "highest order that auto, bdf, ida (5) and adams (12) may use")
      ->type_name("N")
      ->check(CLI::Range(1, 12));
}

void RunLimits::apply(SimulateOptions& how) const {
  how.max_steps = max_steps;
  how.time_limit = seconds;
  if (endless) how.longest_run = 0.0;
}

void add_limit_options(CLI::App& app, RunLimits& limits) {
  app.add_option("--max-steps", limits.max_steps, "end the run after that many steps")
      ->type_name("N")
      ->check(positive_number());
  auto* const limit = app.add_option("--time-limit", limits.seconds, "end the run after that many seconds of wall time")
                          ->type_name("SECONDS")
                          ->check(positive_number());
  app.add_flag("--no-time-limit", limits.endless, "also go on if the pace says that it takes more than a day")
      ->excludes(limit);
}

}  // namespace bgsim::cli
