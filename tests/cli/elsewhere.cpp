// Commands that are in a program beside bgsim: bgsim-studies, bgsim-fit.
#include <catch2/catch.hpp>
#include <filesystem>

#include "command.hpp"

namespace fs = std::filesystem;
using Catch::Contains;

namespace {

/// bgsim alone in build/release of a project whose script, if there is one, tells how it was called.
void make_build(const Workplace& here, bool script) {
  const fs::path folder = here.folder();
  fs::create_directories(folder / "build/release");
  fs::copy_file(bgsim_path(), folder / "build/release/bgsim");
  if (!script) return;
  fs::create_directory(folder / "scripts");
  here.write("scripts/bgsim", "#!/bin/sh\nfor word in \"$@\"; do printf '<%s>' \"$word\"; done\n");
  fs::permissions(folder / "scripts/bgsim", fs::perms::owner_all);
  here.write("build/release/built", "../../scripts/bgsim\n");
}

}  // namespace

TEST_CASE("bgsim without bgsim-studies beside it says what builds it") {
  const Workplace here;
  make_build(here, false);
  for (const char* words : {"trade rc.json", "bode --help", "run rc.json --accuracy 1e-3", "rc.json --accuracy=1e-3"}) {
    CAPTURE(words);
    const Outcome alone = here.shell(std::string("build/release/bgsim ") + words);
    CHECK(alone.code == 2);
    CHECK_THAT(alone.err, Contains("bgsim-studies") && Contains("scripts/bgsim"));
  }
  // What it does itself needs nothing beside it.
  CHECK(here.shell("b=build/release/bgsim; $b new electric -o own.json && $b own.json -o own.csv && $b check own.json")
            .code == 0);
}

TEST_CASE("in the build of scripts/bgsim a command that is not built yet is built by it, with the words as they were") {
  const Workplace here;
  make_build(here, true);
  CHECK(here.shell("build/release/bgsim sweep 'a b.json' --vary 'R=1,2' ''").out ==
        "<--with><bgsim-studies><sweep><a b.json><--vary><R=1,2><>");
  CHECK(here.shell("build/release/bgsim fit x.json").out == "<--with><bgsim-fit><fit><x.json>");
  CHECK(here.shell("build/release/bgsim x.json --accuracy 1e-3 -o -").out ==
        "<--with><bgsim-studies><run><x.json><--accuracy><1e-3><-o><->");
  // From another folder, and through a link.
  CHECK(here.shell("ln -s build/release/bgsim link; cd build && ../link steady x.json").out ==
        "<--with><bgsim-studies><steady><x.json>");
}
