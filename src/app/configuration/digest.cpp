// SPDX-License-Identifier: Apache-2.0
#include "app/configuration/digest.hpp"

#include <fmt/core.h>
#include <string_view>

#include "io/tls/fingerprint.hpp"

namespace mbgate::app {
namespace {

constexpr std::string_view kPlain =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789/._-+,:@%";

/// As a shell takes it for one word.
std::string word(const std::string& path) {
  if (!path.empty() && path.find_first_not_of(kPlain) == std::string::npos) {
    return path;
  }
  std::string quoted = "'";
  for (const char letter : path) {
    quoted += letter == '\'' ? "'\\''" : std::string(1, letter);
  }
  return quoted + "'";
}

}  // namespace

std::string config_digest(const std::vector<config::TextFile>& files) {
  std::string text;
  for (const config::TextFile& file : files) {
    text += file.text;
  }
  return io::sha256(text);
}

std::string digest_command(const std::vector<config::TextFile>& files) {
  std::string command = "cat";
  for (const config::TextFile& file : files) {
    command += " " + word(file.name);
  }
  return command + " | sha256sum";
}

std::string in_force_text(const std::string& digest, const std::string& before) {
  return "configuration in force: sha256 " +
         (before.empty() || before == digest ? digest : fmt::format("{} -> {}", before, digest));
}

}  // namespace mbgate::app
