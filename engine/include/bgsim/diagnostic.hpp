/// Messages: the error, its location, the rule, and a fix.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bgsim/id.hpp"

namespace bgsim {

/// What the options' own texts are called in messages: a file of their own.
inline constexpr const char* kCommandLine = "command line";

/// A stretch of a file: bytes [begin, end) of its text, and the JSON value they belong to (for the JSON Pointer).
struct Place {
  DocumentId document;
  NodeId node;  ///< none for a syntax error
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

/// The parsed JSON files of one model, by DocumentId (inside the engine).
class Sources;

/// A file of a model as it was read; valid as long as the sources are.
struct SourceText {
  std::string_view path, text;
};
/// All of them, by DocumentId: the model's own first, then submodels and what the options say (kCommandLine).
std::vector<SourceText> source_texts(const Sources& sources);

enum class Severity { warning, error };

/// A further place that takes part in a diagnostic.
struct Note {
  std::optional<Place> place;
  std::string text;
};

/// One problem. Texts use names, units and times, never indices.
struct Diagnostic {
  Severity severity = Severity::error;
  std::string code;       ///< "BG301"; has a section in docs/errors.md
  std::string situation;  ///< one sentence, no full stop
  std::optional<Place> place;
  std::vector<Note> notes;
  std::string rule;  ///< the rule that is broken, one line; may be empty
  std::string help;  ///< the fix, one line; may be empty
};

/// Thrown by the stages up to compile when the model is at fault; holds every problem found, at most one per cause.
class ModelError : public std::runtime_error {
 public:
  ModelError(std::vector<Diagnostic> problems, std::shared_ptr<const Sources> files);

  std::vector<Diagnostic> diagnostics;
  std::shared_ptr<const Sources> sources;
};

/// Renders as `file:line:col: severity CODE: situation`, excerpt with caret and JSON Pointer, notes, rule, help, link.
/// Lines and columns count from 1; columns count characters, not bytes.
std::string render(const Diagnostic& diagnostic, const Sources& sources);
std::string render(const ModelError& error);
/// Its first line alone: `file:line:col: severity CODE: situation`.
std::string headline(const Diagnostic& diagnostic, const Sources& sources);

/// The candidate nearest to @p name by edit distance, if near enough to be a misspelling; else empty.
std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace bgsim
