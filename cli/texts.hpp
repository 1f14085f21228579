/// Texts that the command carries with it, so that it needs no files beside it (made by cmake/Texts.cmake).
#pragma once

#include <string_view>

namespace bgsim::cli {

extern const std::string_view kMessagesText;  ///< docs/errors.md
extern const std::string_view kSchemaText;    ///< docs/model.schema.json

/// A starter model of `bgsim new`: cli/templates.
struct ModelTemplate {
  std::string_view name;
  std::string_view text;
};
extern const ModelTemplate kModelTemplates[];
extern const int kModelTemplateCount;

}  // namespace bgsim::cli
