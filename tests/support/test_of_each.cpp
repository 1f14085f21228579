#include "support/test_of_each.hpp"

#include <catch2/catch.hpp>
#include <utility>

namespace bgsim::test {

namespace {

class Body : public Catch::ITestInvoker {
 public:
  explicit Body(std::function<void()> body) : body_(std::move(body)) {}
  void invoke() const override { body_(); }

 private:
  std::function<void()> body_;
};

/// Brackets group the elements of CMake's lists, a semicolon separates them, and an asterisk at the end is a wildcard
/// of Catch.
std::string argument(const std::string& text) {
  std::string result;
  for (const char c : text) switch (c) {
      case '[':
        result += '(';
        break;
      case ']':
        result += ')';
        break;
      case ';':
        result += ',';
        break;
      case '`':
      case '"':
      case '\\':
        break;
      default:
        result += c;
    }
  while (result.ends_with('*') || result.ends_with(' ')) result.pop_back();
  return result;
}

}  // namespace

void add_test(const std::string& name, std::function<void()> body, const std::string& tags,
              const Catch::SourceLineInfo& where) {
  const std::string plain = argument(name);
  const Catch::AutoReg registered(new Body(std::move(body)), where, Catch::StringRef(),
                                  Catch::NameAndTags(plain, tags));
}

}  // namespace bgsim::test
