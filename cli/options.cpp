#include "options.hpp"

#include <cmath>

namespace bgsim::cli {

CLI::Validator positive_number() {
  const auto check = [](const std::string& text) {
    double value = 0.0;
    const bool number = CLI::detail::lexical_cast(text, value);
    return number && value > 0.0 && std::isfinite(value) ? std::string() : text + " is no number above zero";
  };
  return {check, ""};
}

void add_set_option(CLI::App& app, SceneOverrides& overrides) {
  app.add_option("--set", overrides.set, "a parameter or an initial value; may be given again")
      ->type_name("NAME=EXPR")
      ->allow_extra_args(false);
}

void add_solver_options(CLI::App& app, SceneOverrides& overrides) {
  const CLI::Validator positive = positive_number();
  app.add_option("--relative", overrides.relative, "relative tolerance")->type_name("X")->check(positive);
  app.add_option("--absolute", overrides.absolute, "absolute tolerance of every state")
      ->type_name("X")
      ->check(positive);
  app.add_option_function<std::string>(
         "--method",
         [&overrides](const std::string& name) {
           overrides.method = method_from(name);
           if (!overrides.method) {
             throw CLI::ValidationError("--method", "there is no method \"" + name + "\"; there are " + method_list());
           }
         },
         method_list())
      ->type_name("NAME");
  app.add_option("--step", overrides.step, "length of the steps of euler, implicit_euler, rk4 and verlet")
      ->type_name("H")
      ->check(positive);
  app.add_option("--max-order", overrides.max_order, "highest order that auto, bdf, ida (5) and adams (12) may use")
      ->type_name("N")
      ->check(CLI::Range(1, 12));
}

}  // namespace bgsim::cli
