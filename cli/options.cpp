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

void add_method_options(CLI::App& app, SceneOverrides& overrides) {
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
      ->check(positive_number());
  app.add_option("--max-order", overrides.max_order, "highest order that auto, bdf, ida (5) and adams (12) may use")
      ->type_name("N")
      ->check(CLI::Range(1, 12));
}

}  // namespace bgsim::cli
