/// Tests whose names come from data: one for each row of a table or each file of a list. ctest runs them one by one.
#pragma once

#include <catch2/catch.hpp>
#include <functional>
#include <string>

namespace bgsim::test {

/// Makes @p body a test. To be called while static objects are initialized. What a command line cannot hand over is
/// left out of @p name or replaced, so that ctest and -R see plain text. @param tags  Catch's: "[long]".
void add_test(const std::string& name, std::function<void()> body, const std::string& tags = {},
              const Catch::SourceLineInfo& where = Catch::SourceLineInfo(__builtin_FILE(), __builtin_LINE()));

}  // namespace bgsim::test
