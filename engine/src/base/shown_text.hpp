/// Which files messages may show: a file that a model names may be anything, a password file among them.
#pragma once

#include "base/document.hpp"

namespace bgsim {

/// Whether messages may show the text of a file: it is the user's own, or a model's, with the key "bgsim" somewhere,
/// JSON or not yet.
bool shows_text(const Document& file);

}  // namespace bgsim
