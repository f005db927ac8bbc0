// SPDX-License-Identifier: Apache-2.0
// A device that answers exactly as a profile foresees, and the shipped profiles.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "config/profiles/profile_library.hpp"
#include "ctl/scan/identifier.hpp"

namespace mbgate::ctl {

inline config::ProfileLibrary& shipped_profiles() {
  static config::ProfileLibrary library({MBGATE_SOURCE_DIR "/conf/profiles"});
  return library;
}

inline std::vector<const config::ProfileFile*> shipped_files() {
  std::vector<const config::ProfileFile*> files;
  for (const auto& name : shipped_profiles().names()) {
    files.push_back(shipped_profiles().find(name));
  }
  return files;
}

inline const Catalogue& shipped_catalogue() {
  static const Catalogue kCatalogue(shipped_files());
  return kCatalogue;
}

/// Registers hold 0; its word order, if it can be read, is little.
class ProfileDevice {
 public:
  explicit ProfileDevice(const std::string& profile)
      : file_(*shipped_profiles().find(profile)), candidate_(file_) {}

  [[nodiscard]] Answer answer(const modbus::TableRange& read) const {
    const std::chrono::milliseconds took(4);
    switch (candidate_.foresees(read)) {
      case Foreseen::no_function: return {AnswerKind::exception, 0x01, {}, took};
      case Foreseen::refusal:
      case Foreseen::anything: return {AnswerKind::exception, 0x02, {}, took};
      case Foreseen::text:
        return {AnswerKind::data, 0, std::vector<std::uint16_t>(read.count, 0x4142), took};
      case Foreseen::word_order:
        return {AnswerKind::data, 0, {file_.profile.word_order_register->little.front()}, took};
      case Foreseen::data: break;
    }
    return {AnswerKind::data, 0, std::vector<std::uint16_t>(read.count, 0), took};
  }

 private:
  const config::ProfileFile& file_;
  Candidate candidate_;
};

}  // namespace mbgate::ctl
