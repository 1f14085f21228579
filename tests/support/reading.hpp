/// Helpers for tests of the reader: a model's text in, its first fault as one line out.
#pragma once

#include <string>

#include "bgsim/model.hpp"
#include "support/files.hpp"
#include "support/model_text.hpp"

namespace bgsim::test {

inline Model read(const std::string& body) { return read_model_text("test.json", model_text(body)); }

/// "CODE [faulty text] situation; help"
inline std::string line_of(const Diagnostic& d, const Sources& sources) {
  std::string text = d.code;
  if (d.place) {
    const std::string_view file = source_texts(sources)[d.place->document.index()].text;
    text += " [" + std::string(file.substr(d.place->begin, d.place->end - d.place->begin)) + "]";
  }
  return text + " " + d.situation + (d.help.empty() ? "" : "; " + d.help);
}

/// Whether a fault is one of reading. Tests of the reader use fragments, whose elements mostly have no bonds.
inline bool of_reading(const Diagnostic& d) { return d.code.starts_with("BG1"); }

/// The first fault of reading a whole text, or "none".
inline std::string whole_fault(const std::string& text, const std::string& path = "test.json") {
  try {
    read_model_text(path, text);
  } catch (const ModelError& error) {
    for (const Diagnostic& d : error.diagnostics)
      if (of_reading(d)) return line_of(d, *error.sources);
  }
  return "none";
}
inline std::string fault(const std::string& body) { return whole_fault(model_text(body)); }

/// The codes of all faults of reading, in order.
inline std::string codes(const std::string& body) {
  std::string result;
  try {
    read(body);
  } catch (const ModelError& error) {
    for (const Diagnostic& d : error.diagnostics)
      if (of_reading(d)) result += d.code + " ";
  }
  return result;
}
inline std::size_t faults(const std::string& body) { return codes(body).size() / 6; }

/// The whole model that docs/model-format.md begins with.
inline std::string example_of_the_format() {
  const std::string text = file_text(BGSIM_SOURCE_DIR "/docs/model-format.md");
  const auto begin = text.find("```json\n") + 8;
  return text.substr(begin, text.find("\n```", begin) - begin);
}

inline std::string example_of_submodels() {
  const std::string text = file_text(BGSIM_SOURCE_DIR "/docs/model-format.md"), mark = "```json submodel\n";
  const auto begin = text.find(mark) + mark.size();
  return text.substr(begin, text.find("\n```", begin) - begin);
}

}  // namespace bgsim::test
