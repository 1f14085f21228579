// bgsim explain: the page of a message's code.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <iostream>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "texts.hpp"

namespace bgsim::cli {

namespace {

const std::string_view kAnchor = "<a id=\"bg", kHeading = "## BG";

/// "bg301" and "301" are BG301 as well.
std::string code_of(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text.starts_with("BG") ? text : "BG" + text;
}

/// The lines "BG301 Two bonds set ..." of all sections.
std::string all_titles() {
  std::string titles;
  for (std::size_t at = kMessagesText.find(kHeading); at != std::string_view::npos;
       at = kMessagesText.find(kHeading, at + 1)) {
    const std::size_t begin = at + std::string_view("## ").size();
    titles += std::string(kMessagesText.substr(begin, kMessagesText.find('\n', begin) - begin)) + "\n";
  }
  return titles;
}

/// A section from its heading to the next one's anchor; empty if there is no such code.
std::string_view section(const std::string& code) {
  const std::size_t begin = kMessagesText.find("## " + code + " ");
  if (begin == std::string_view::npos) return {};
  const std::size_t end = kMessagesText.find(kAnchor, begin);
  std::string_view text = kMessagesText.substr(begin, end == std::string_view::npos ? end : end - begin);
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  return text;
}

}  // namespace

Exit explain_command(const Arguments& arguments) {
  std::string code;
  CLI::App app("Explains the code of a message, and how to correct the model.", "bgsim explain");
  app.add_option("code", code, "BG301, bg301 or 301; none: a list of all codes");
  app.footer(
      "Examples:\n  bgsim explain BG301      two bonds set the effort of one junction\n  bgsim explain            all "
      "codes");
  parse_arguments(app, arguments);

  if (code.empty()) {
    std::cout << all_titles();
    return Exit::done;
  }
  const std::string_view text = section(code_of(code));
  if (text.empty())
    throw UsageError("there is no message " + short_name(code_of(code)) + "; bgsim explain lists all of them");
  std::cout << text << '\n';
  return Exit::done;
}

}  // namespace bgsim::cli
