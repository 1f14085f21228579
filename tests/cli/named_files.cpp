// Files that a model names: below its folder, regular, of an end; and nothing of other files in messages.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "command.hpp"

using Catch::Contains;
namespace fs = std::filesystem;

namespace {

const std::string kPart = R"({ "bgsim": 1, "ports": { "in": "line" }, "elements": { "line": { "kind": "1" },
  "drop": { "kind": "R", "resistance": 1 } }, "bonds": [ { "from": "line", "to": "drop" } ] })";

std::string with_submodel(const std::string& file) {
  return R"({ "bgsim": 1, "name": "top", "types": { "part": ")" + file + R"(" }, "elements": {
  "source": { "kind": "Se", "effort": 1 }, "part": { "kind": "part" } },
  "bonds": [ { "from": "source", "to": "part.in" } ], "outputs": { "e": "part.drop.e" }, "scenes": { "s": { "stop": 1 } } })";
}
std::string with_table(const std::string& file) {
  return R"({ "bgsim": 1, "name": "top", "elements": { "drop": { "kind": "R", "resistance": 1 },
  "source": { "kind": "Se", "effort": "table(')" +
         file + R"x(', 'u', t)" } }, "bonds": [ { "from": "source", "to": "drop" } ],
  "outputs": { "e": "drop.e" }, "scenes": { "s": { "stop": 1 } } })x";
}
std::string with_reference(const std::string& file) {
  return R"({ "bgsim": 1, "name": "top", "elements": { "drop": { "kind": "R", "resistance": 1 },
  "source": { "kind": "Se", "effort": 1 } }, "bonds": [ { "from": "source", "to": "drop" } ],
  "outputs": { "e": "drop.e" }, "scenes": { "s": { "stop": 1, "reference": ")" +
         file + R"(" } } })";
}

/// A model of each way to name a file.
struct Naming {
  std::string (*model)(const std::string&);
  const char* command;
};
const Naming kNamings[] = {{with_submodel, "check"}, {with_table, "check"}, {with_reference, "verify"}};

/// What is in no message.
constexpr const char* kSecret = "hunter2";

}  // namespace

TEST_CASE("a file outside of the model's folder is refused by every command, and read with --allow-outside") {
  const Workplace here;
  const fs::path folder = here.folder();
  fs::create_directories(folder / "model" / "deep");
  here.write("part.json", kPart);
  here.write("data.csv", "t,u\n0,1\n1,2\n");
  here.write("ref.csv", "t,e\n0,1\n1,1\n");
  fs::create_directory_symlink("..", folder / "model" / "up");
  fs::create_symlink(folder / "part.json", folder / "model" / "link.json");
  const auto check = [&](const std::string& command, const std::string& model) {
    INFO(command << " " << model);
    here.write("model/top.json", model);
    const Outcome strict = here.bgsim(command + " model/top.json");
    CHECK(strict.code == 1);
    CHECK_THAT(strict.err, Contains("error BG170") && Contains("--allow-outside"));
    CHECK(here.bgsim(command + " model/top.json --allow-outside").code == 0);
  };
  const std::string absolute = here.folder() + "/";
  for (const std::string& way : {std::string("../"), std::string("deep/../../"), std::string("up/"), absolute}) {
    check("check", with_submodel(way + "part.json"));
    check("check", with_table(way + "data.csv"));
    check("verify", with_reference(way + "ref.csv"));
  }
  check("check", with_submodel("link.json"));
  for (const char* command :
       {"run", "equations", "show --stage model", "draw -o x.svg", "report -o x.html", "reduce -o x.json"})
    check(command, with_submodel("../part.json"));
}

TEST_CASE("files below the model's folder are read, whatever the way that leads there") {
  const Workplace here;
  const fs::path folder = here.folder();
  fs::create_directories(folder / "model" / "deep");
  here.write("model/deep/part.json", kPart);
  fs::create_directory_symlink("deep", folder / "model" / "also");
  fs::create_directory_symlink("model", folder / "other");
  for (const std::string& way : {std::string("deep/"), std::string("./deep/../deep/"), std::string("also/"),
                                 here.folder() + "/model/deep/", std::string("../model/deep/")}) {
    INFO(way);
    here.write("model/top.json", with_submodel(way + "part.json"));
    CHECK(here.bgsim("check model/top.json").code == 0);
    CHECK(here.bgsim("check other/top.json").code == 0);
    CHECK(here.shell("cd model && '" + bgsim_path() + "' check top.json").code == 0);
  }
}

TEST_CASE("pipes, devices, folders and endless files are refused before they are opened") {
  const Workplace here;
  const fs::path folder = here.folder();
  REQUIRE(::mkfifo((folder / "fifo").c_str(), 0600) == 0);
  fs::create_directory(folder / "sub");
  for (const auto& [model, command] : kNamings) {
    for (const char* file : {"fifo", "sub", "/dev/zero", "/dev/tty", "/dev/stdin", "/dev/full"}) {
      INFO(command << " " << file);
      here.write("top.json", model(file));
      const Outcome done =
          here.shell("timeout 20 '" + bgsim_path() + "' " + std::string(command) + " top.json --allow-outside");
      CHECK(done.code == 1);
      CHECK_THAT(done.err, Contains("not a regular file") || Contains("it is a folder"));
    }
  }
  const Outcome trace = here.bgsim("plot /dev/zero -o x.svg");
  CHECK(trace.code == 2);
  CHECK_THAT(trace.err, Contains("it is a device, not a regular file"));
  CHECK(here.bgsim("check /dev/zero").code == 1);
  CHECK(here.bgsim("check sub").code == 1);
}

TEST_CASE("a model and a trace may come through a pipe") {
  const Workplace here;
  here.write("sub.json", kPart);
  here.write("top.json", with_submodel("sub.json"));
  CHECK(here.shell("cat top.json | '" + bgsim_path() + "' check /dev/stdin").code == 0);
  CHECK(here.shell("'" + bgsim_path() + "' check /dev/stdin < top.json").code == 0);
  CHECK(here.shell("bash -c \"'" + bgsim_path() + "' check <(cat top.json)\"").code == 0);
  CHECK(here.shell("printf 't,x\\n0,1\\n1,2\\n' | '" + bgsim_path() + "' plot /dev/stdin -o x.svg").code == 0);
  const Outcome endless = here.shell("yes | timeout 20 '" + bgsim_path() + "' check /dev/stdin");
  CHECK(endless.code == 1);
  CHECK_THAT(endless.err, Contains("BG101"));
}

TEST_CASE("messages show nothing of a file that is neither a model nor a table") {
  const Workplace here;
  const std::string secret = kSecret;
  const std::vector<std::string> contents{
      "root:" + secret + ":0:0:root:/root:/bin/bash\nbin:" + secret + ":1:1::/:/sbin/nologin\n",
      "-----BEGIN OPENSSH PRIVATE KEY-----\n" + secret + secret + "\n-----END OPENSSH PRIVATE KEY-----\n",
      std::string("\x7f"
                  "ELF\0\1\2",
                  7) +
          secret + std::string("\0\xff\xfe", 3),
      "{ \"auths\": { \"" + secret + "\": \"" + secret + "\" } }\n",
      "{ \"" + secret + "\": 1, \"" + secret + "\": 2 }",
      "{ \"token\": " + secret + " }",
      "{ \"a\": 1e999" + secret + " }",
      "[ \"" + secret + "\" ]",
      "\"" + secret + "\"",
      secret + "=" + secret + "\n",
      secret + "," + secret + "\n",
      "user,password\nbob," + secret + "\n",
      "user," + secret + "\n1,x\n",
      "\"" + secret + "\n",
      secret + "\n1\n2\n",
  };
  for (const auto& [model, command] : kNamings) {
    for (const std::string& content : contents) {
      INFO(command << ": " << content);
      here.write("other", content);
      here.write("top.json", model("other"));
      const Outcome done = here.bgsim(std::string(command) + " top.json");
      CHECK(done.code == 1);
      CHECK_THAT(done.err, Contains("other"));
      CHECK(done.err.find(secret) == std::string::npos);
      CHECK(done.out.find(secret) == std::string::npos);
    }
  }
  for (const std::string& content : contents) {
    INFO(content);
    here.write("other", content);
    CHECK(here.bgsim("check other").err.find(secret) == std::string::npos);
  }
  here.write("t.csv", "t,x\n0,1\n");
  here.write("t.units.json", "{ \"x\": " + secret + " }");
  const Outcome units = here.bgsim("plot t.csv -o x.svg");
  CHECK(units.code == 2);
  CHECK(units.err.find(secret) == std::string::npos);
}

TEST_CASE("a fault in one's own submodel or table is shown with its place and its text") {
  const Workplace here;
  here.write("part.json", "{ \"bgsim\": 1,\n  \"elements\": { \"line\": { \"kind\": 1. } } }");
  here.write("top.json", with_submodel("part.json"));
  const Outcome model = here.bgsim("check top.json");
  CHECK_THAT(model.err, Contains("part.json:2:") && Contains("\"kind\": 1."));
  here.write("data.csv", "t,u\n0,1\n1,two\n");
  here.write("top.json", with_table("data.csv"));
  CHECK_THAT(here.bgsim("check top.json").err, Contains("data.csv:3: \"two\" in column \"u\" is not a number"));
  here.write("data.csv", "t,v\n0,1\n1,2\n");
  CHECK_THAT(here.bgsim("check top.json").err, Contains("no column \"u\"") && Contains("\"v\""));
}

TEST_CASE("a submodel that is not beside its model is found along the path, the option before the environment") {
  const Workplace here;
  const fs::path folder = here.folder();
  for (const char* name : {"model", "first", "second"}) fs::create_directories(folder / name);
  const auto part = [](const std::string& ohms) {
    return std::string(kPart).replace(std::string(kPart).find("\"resistance\": 1"), 15, "\"resistance\": " + ohms);
  };
  here.write("model/top.json", with_submodel("part.json"));
  here.write("second/part.json", part("4"));
  const auto equations = [&](const std::string& options) {
    return here.bgsim("equations model/top.json --output f=part.drop.f " + options);
  };
  const Outcome none = equations("--path first");
  CHECK(none.code == 1);
  CHECK_THAT(none.err, Contains("BG133") && Contains("\"first\""));
  CHECK_THAT(equations("--path first:second").out, Contains("f = 0.25\n"));
  here.write("first/part.json", part("2"));
  CHECK_THAT(equations("--path first:second").out, Contains("f = 0.5\n"));
  CHECK_THAT(equations("--path second --path first").out, Contains("f = 0.25\n"));
  here.write("model/part.json", part("5"));
  CHECK_THAT(equations("--path first").out, Contains("f = 0.2\n"));
  fs::remove(folder / "model" / "part.json");
  const auto with_environment = [&](const std::string& options) {
    return here.shell("BGSIM_PATH=nowhere:second '" + bgsim_path() +
                      "' equations model/top.json --output f=part.drop.f " + options);
  };
  CHECK_THAT(with_environment("").out, Contains("f = 0.25\n"));
  CHECK_THAT(with_environment("--path first").out, Contains("f = 0.5\n"));
  const Outcome missing = equations("--path nowhere");
  CHECK(missing.code == 2);
  CHECK_THAT(missing.err, Contains("there is no folder \"nowhere\""));
}
