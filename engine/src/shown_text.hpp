/// Which files messages may show: a file that a model names may be anything, a password file among them.
#pragma once

#include <string>

#include "bgsim/document.hpp"
#include "bgsim/input_file.hpp"
#include "bgsim/trace_csv.hpp"

namespace bgsim {

/// Whether messages may show the text of a file: it is a model's, with the key "bgsim" somewhere, JSON or not yet.
bool shows_text(const Document& file);

/// A fault in a CSV text, also in words that show nothing of it.
class CsvFileError : public CsvError {
 public:
  CsvFileError(std::size_t line_, const std::string& message, std::string without)
      : CsvError(line_, message), without_text(std::move(without)) {}
  std::string without_text;
};

/// @p options with the folder of the model @p path as the first of the roots.
ReadOptions with_folder_of(const std::string& path, const ReadOptions& options);

}  // namespace bgsim
