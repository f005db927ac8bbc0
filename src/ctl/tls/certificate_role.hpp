// SPDX-License-Identifier: Apache-2.0
// The role in a client's certificate (routing/role_extension), in words.
#pragma once

#include <filesystem>
#include <string>

namespace mbgate::ctl {

/// The role in the first certificate of a file, as a gateway reads it: "operator" in quotes, or
/// "none: ..."; empty if the file has no certificate.
std::string role_in_file(const std::filesystem::path& file);

}  // namespace mbgate::ctl
