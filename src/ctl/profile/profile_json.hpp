// SPDX-License-Identifier: Apache-2.0
// A profile as JSON, for programs. Addresses are protocol addresses.
#pragma once

#include <string>
#include <vector>

#include "config/profiles/profile_file.hpp"

namespace mbgate::ctl {

/// One line: {"name": ..., "values32": {"holding": [first addresses], "input": [...]}, ...};
/// everything else (names, the manual's register numbers and lines, notes) is in "entries".
std::string profile_json(const config::ProfileFile& file);

/// A name and what kind of drive it is.
struct ProfileTitle {
  std::string name;
  std::string description;
};

/// One line: [{"name": ..., "description": ...}, ...]
std::string profiles_json(const std::vector<ProfileTitle>& titles);

}  // namespace mbgate::ctl
