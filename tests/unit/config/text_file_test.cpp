// SPDX-License-Identifier: Apache-2.0
// A configuration of several files: which are read, in which order, and what they say together.

#include "config/text_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "config/load.hpp"

namespace mbgate::config {
namespace {

using testing::ElementsAre;
namespace fs = std::filesystem;

constexpr auto kMain =
    "[[listen]]\n"
    "name = \"plant\"\n"
    "port = 0\n"
    "bus = \"line-a\"\n"
    "[[bus]]\n"
    "name = \"line-a\"\n"
    "device = \"/dev/ttyS0\"\n";

std::string axis(const std::string& name, int address) {
  return "[[device]]\nname = \"" + name +
         "\"\nbus = \"line-a\"\naddress = " + std::to_string(address) + "\n";
}

/// A folder with main.toml and an empty conf.d.
class ConfigFiles : public testing::Test {
 protected:
  ConfigFiles() {
    fs::create_directories(folder_ / "conf.d");
    write("main.toml", kMain);
  }
  ~ConfigFiles() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  [[nodiscard]] Loaded load() const { return load_settings(folder_ / "main.toml"); }
  /// What is wrong, with the names of files as they are within the folder.
  [[nodiscard]] std::string wrong() const {
    std::string text = render(load().diagnostics);
    const std::string beginning = folder_.string() + "/";
    for (auto at = text.find(beginning); at != std::string::npos; at = text.find(beginning)) {
      text.erase(at, beginning.size());
    }
    return text;
  }

  const fs::path folder_ =
      fs::path(testing::TempDir()) / ("mbgate-conf-" + std::to_string(::getpid()));
};

TEST_F(ConfigFiles, AreReadInTheOrderOfTheBytesOfTheirNames) {
  int address = 1;
  for (const auto* name : {"a", "9", "\xC3\xA4", "10", "B"}) {
    write("conf.d/" + std::string(name) + ".toml",
          axis("axis-" + std::to_string(address), address));
    ++address;
  }
  write("main.toml", kMain + axis("axis-0", 100));
  const auto loaded = load();
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  std::vector<std::string> names;
  for (const auto& device : loaded.settings->devices) {
    names.push_back(device.name);
  }
  EXPECT_THAT(names, ElementsAre("axis-0", "axis-4", "axis-2", "axis-5", "axis-1", "axis-3"));
}

TEST_F(ConfigFiles, PutTheirListsTogether) {
  write(
      "conf.d/10.toml",
      "listen = [{ name = \"hall\", port = 0, bus = \"line-b\" }, { name = \"door\", port = 0 }]\n"
      "[[client]]\naddress = \"192.0.2.1\"\nweight = 2\n"
      "[[bus]]\nname = \"line-b\"\ndevice = \"/dev/ttyS1\"\n");
  write("conf.d/20.toml", axis("axis-x", 7) +
                              "[[route]]\nlistener = \"door\"\nunit = 1\ndevice = \"axis-x\"\n"
                              "[[client]]\naddress = \"192.0.2.2\"\nweight = 3\n");
  const auto loaded = load();
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  ASSERT_EQ(loaded.settings->listeners.size(), 3U);
  EXPECT_EQ(loaded.settings->listeners[0].name, "plant");
  EXPECT_EQ(loaded.settings->listeners[1].name, "hall");
  EXPECT_EQ(loaded.settings->listeners[1].bus, drive::BusId{1});
  EXPECT_EQ(loaded.settings->listeners[2].name, "door");
  ASSERT_EQ(loaded.settings->routes.size(), 1U);
  EXPECT_EQ(loaded.settings->routes[0].listener, routing::ListenerId{2});
  ASSERT_EQ(loaded.settings->weights.size(), 2U);
  EXPECT_EQ(loaded.settings->weights[1].weight, 3U);
}

TEST_F(ConfigFiles, ShareTheKeysOfATable) {
  write("main.toml", "[gateway]\nunit = 200\n" + std::string(kMain));
  write("conf.d/10.toml", "gateway.lock_memory = true\nhttp = { socket = \"\" }\n");
  const auto loaded = load();
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->status_unit, 200);
  EXPECT_TRUE(loaded.settings->lock_memory);
  EXPECT_EQ(loaded.settings->control_socket, "");
}

TEST_F(ConfigFiles, SayAKeyOnce) {
  write("main.toml", "[gateway]\nunit = 200\n" + std::string(kMain));
  write("conf.d/10.toml", "[gateway]\nlock_memory = true\nunit = 200\n");
  write("conf.d/20.toml", "[gateway]\nlock_memory = true\n");
  EXPECT_EQ(wrong(),
            "conf.d/10.toml:3:1: error: unit: is already set at main.toml:2:1\nunit = 200\n^\n"
            "conf.d/20.toml:2:1: error: lock_memory: is already set at conf.d/10.toml:2:1\n"
            "lock_memory = true\n^\n");
  EXPECT_FALSE(load().settings);
}

TEST_F(ConfigFiles, SayOfWhatKindAKeyIsWhereTheyDisagree) {
  write("conf.d/10.toml", "[bus]\nname = \"line-b\"\ndevice = \"/dev/ttyS1\"\n");
  EXPECT_EQ(wrong(),
            "conf.d/10.toml:1:2: error: bus: is already set at main.toml:5:3, as a list; here it "
            "is a table\n[bus]\n ^\n");
}

// An empty list says that there is nothing.
TEST_F(ConfigFiles, AddNothingToAListThatIsEmpty) {
  write("conf.d/10.toml", "client = []\n");
  write("conf.d/20.toml", "[[client]]\naddress = \"192.0.2.2\"\nweight = 3\n");
  EXPECT_EQ(wrong(),
            "conf.d/20.toml:1:3: error: client: is already set at conf.d/10.toml:1:1\n"
            "[[client]]\n  ^\n");
}

TEST_F(ConfigFiles, GiveANameOnce) {
  write("conf.d/10.toml", axis("axis-x", 1));
  write("conf.d/20.toml", axis("axis-x", 1));
  write("conf.d/30.toml", "[[bus]]\nname = \"line-a\"\ndevice = \"/dev/ttyS1\"\n");
  EXPECT_EQ(wrong(),
            "conf.d/20.toml:2:8: error: name: \"axis-x\" is already used at conf.d/10.toml:2:8\n"
            "name = \"axis-x\"\n       ^\n"
            "conf.d/20.toml:4:11: error: address: 1 on this bus is already used at "
            "conf.d/10.toml:4:11\naddress = 1\n          ^\n"
            "conf.d/30.toml:2:8: error: name: \"line-a\" is already used at main.toml:6:8\n"
            "name = \"line-a\"\n       ^\n");
}

TEST_F(ConfigFiles, AreKnownToEachOther) {
  write("conf.d/10.toml", axis("axis-x", 7));
  const auto loaded = load();
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->devices.at(0).bus, drive::BusId{0});
}

TEST_F(ConfigFiles, AreNamedInTheirOrderByWhatIsWrong) {
  write("main.toml", std::string(kMain) + "retries = 300\n");
  write("conf.d/10.toml", axis("axis-x", 7) + "retries = 301\nzzzzzzzzzzzz = 1\n");
  EXPECT_EQ(wrong(),
            "main.toml:8:11: error: retries: expected an integer from 0 to 100, found 300\n"
            "retries = 300\n          ^\n"
            "conf.d/10.toml:5:11: error: retries: expected an integer from 0 to 100, found 301\n"
            "retries = 301\n          ^\n"
            "conf.d/10.toml:6:1: error: unknown key 'zzzzzzzzzzzz' in [[device]]\n"
            "zzzzzzzzzzzz = 1\n^\n");
}

TEST_F(ConfigFiles, EachHaveTheirFirstErrorOfSyntax) {
  write("conf.d/10.toml", "[[bus]]\nparity = none\nparity = even\n");
  write("conf.d/20.toml", axis("axis-x", 300));
  write("conf.d/30.toml", "parity = none\n");
  fs::create_directory(folder_ / "conf.d/40.toml");
  EXPECT_EQ(
      wrong(),
      "conf.d/10.toml:2:10: error: syntax: quotes are missing: expected \"none\", found none\n"
      "parity = none\n         ^\n"
      "conf.d/30.toml:1:10: error: syntax: quotes are missing: expected \"none\", found none\n"
      "parity = none\n         ^\n"
      "conf.d/40.toml: error: cannot be read: Is a directory\n");
}

TEST_F(ConfigFiles, HaveOnlyCertainNames) {
  for (const auto* name : {".hidden.toml", ".#10.toml", "#10.toml#", "10.toml~", "10.toml.bak",
                           "10.TOML", "10.conf", "toml", ".toml"}) {
    write("conf.d/" + std::string(name), "[[");
  }
  fs::create_directory(folder_ / "conf.d/profiles");
  EXPECT_EQ(wrong(), "");
  EXPECT_EQ(read_config_files(folder_ / "main.toml").size(), 1U);
}

TEST_F(ConfigFiles, AreFiles) {
  write("other", axis("axis-x", 7));
  fs::create_symlink("../other", folder_ / "conf.d/a-link.toml");
  fs::create_symlink("../absent", folder_ / "conf.d/broken-link.toml");
  fs::create_symlink("/dev/null", folder_ / "conf.d/null.toml");
  ASSERT_EQ(::mkfifo((folder_ / "conf.d/pipe.toml").c_str(), 0600), 0);
  EXPECT_EQ(wrong(),
            "conf.d/broken-link.toml: error: cannot be read: No such file or directory\n"
            "conf.d/null.toml: error: is not a regular file\n"
            "conf.d/pipe.toml: error: is not a regular file\n");
  EXPECT_FALSE(load().settings);
}

TEST_F(ConfigFiles, ThatMayNotBeReadAreErrors) {
  if (::geteuid() == 0) {
    GTEST_SKIP() << "root may read everything";
  }
  write("conf.d/10.toml", "");
  fs::permissions(folder_ / "conf.d/10.toml", fs::perms::none);
  EXPECT_EQ(wrong(), "conf.d/10.toml: error: cannot be read: Permission denied\n");
  fs::permissions(folder_ / "conf.d", fs::perms::none);
  EXPECT_EQ(wrong(), "conf.d: error: cannot be read: Permission denied\n");
  fs::permissions(folder_ / "conf.d", fs::perms::owner_all);
}

TEST_F(ConfigFiles, NeedNoFolder) {
  fs::remove(folder_ / "conf.d");
  EXPECT_EQ(wrong(), "");
  write("conf.d", "");
  EXPECT_EQ(wrong(), "conf.d: error: cannot be read: Not a directory\n");
  fs::remove(folder_ / "conf.d");
  fs::create_symlink("absent", folder_ / "conf.d");
  EXPECT_EQ(wrong(), "conf.d: error: cannot be read: No such file or directory\n");
}

// A profile folder beside the file that names it; there is none beside main.toml.
TEST_F(ConfigFiles, NamePathsRelativeToTheirOwnFolder) {
  write("conf.d/10.toml", "[gateway]\nprofiles = \"own\"\n");
  fs::create_directory(folder_ / "conf.d/own");
  EXPECT_EQ(wrong(), "");
  EXPECT_TRUE(load().settings);
}

TEST_F(ConfigFiles, MayBeginWithAByteOrderMarkAndEndWithoutANewline) {
  write("main.toml", std::string(kMain) + "[http]");
  write("conf.d/10.toml", "\xEF\xBB\xBFgateway.unit = 5");
  const auto loaded = load();
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->status_unit, 5);
}

TEST_F(ConfigFiles, AreSoughtBesideAFileWithoutAPathToo) {
  write("conf.d/10.toml", "");
  const auto before = fs::current_path();
  fs::current_path(folder_);
  const auto files = read_config_files("main.toml");
  fs::current_path(before);
  ASSERT_EQ(files.size(), 2U);
  EXPECT_EQ(files[0].name, "main.toml");
  EXPECT_EQ(files[0].text, kMain);
  EXPECT_EQ(files[1].name, "conf.d/10.toml");
  EXPECT_EQ(files[1].failure, "");
}

}  // namespace
}  // namespace mbgate::config
