/// A file that is not there: the one that may be meant.
#pragma once

#include <string>

namespace bgsim {

/// "did you mean "models/bellow.json"?", or which folder is not there either; empty if nothing is near. Looks at the
/// names in one folder only.
std::string file_suggestion(const std::string& path);

}  // namespace bgsim
