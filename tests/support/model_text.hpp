/// The usual wrapping of a model's text.
#pragma once

#include <string>

namespace bgsim::test {

/// A model of the name "test": @p body is the content between that and the closing brace.
inline std::string model_text(const std::string& body) { return R"({ "bgsim": 1, "name": "test", )" + body + " }"; }

}  // namespace bgsim::test
