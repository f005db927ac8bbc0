// SPDX-License-Identifier: Apache-2.0
// What a command line of mbgatectl means, for tests.
#pragma once

#include <gtest/gtest.h>

#include <iterator>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "ctl/options/subcommands.hpp"

namespace mbgate::ctl {

inline std::variant<Command, Notice> parse(const std::string& line) {
  std::istringstream words("mbgatectl " + line);
  const std::vector<std::string> arguments{std::istream_iterator<std::string>(words), {}};
  std::vector<const char*> pointers;
  pointers.reserve(arguments.size());
  for (const auto& argument : arguments) {
    pointers.push_back(argument.c_str());
  }
  return parse_command_line("1.2.3", static_cast<int>(pointers.size()), pointers.data());
}

template <typename AnyCommand>
AnyCommand command(const std::string& line) {
  const auto parsed = parse(line);
  if (const auto* notice = std::get_if<Notice>(&parsed)) {
    ADD_FAILURE() << notice->text;
    return {};
  }
  return std::get<AnyCommand>(std::get<Command>(parsed));
}

/// The first line of what a wrong command line is told; its status must be that of wrong usage.
inline std::string complaint(const std::string& line) {
  const auto parsed = parse(line);
  const auto* notice = std::get_if<Notice>(&parsed);
  if (notice == nullptr) {
    return "no complaint";
  }
  EXPECT_EQ(notice->status, 2);
  return notice->text.substr(0, notice->text.find('\n'));
}

}  // namespace mbgate::ctl
