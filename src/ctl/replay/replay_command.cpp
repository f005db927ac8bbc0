// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <fstream>
#include <ostream>
#include <system_error>

#include "ctl/replay/replay.hpp"
#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {
namespace {

int unreadable_recording(const std::string& file, int error, std::ostream& errors) {
  errors << file << ": error: cannot be read: "
         << std::error_code(error == 0 ? EIO : error, std::generic_category()).message() << '\n';
  return kExitConfiguration;
}

void print_difference(const std::string& file, const ReplayOutcome& outcome, std::ostream& out) {
  const auto& difference = *outcome.difference;
  out << file << ':' << difference.line << ": different, after " << outcome.inputs << " inputs and "
      << outcome.actions << " actions that were the same\n";
  if (!difference.input.empty()) {
    out << "the last input:    " << difference.input << '\n';
  }
  out << "recorded:          " << difference.recorded << '\n'
      << "this version does: " << difference.replayed << '\n';
}

void print_same(const ReplayOutcome& outcome, std::ostream& out) {
  out << "same actions at every input: " << outcome.inputs << " inputs, " << outcome.actions
      << " actions, recorded by mbgated " << outcome.version;
  if (!outcome.ended.empty()) {
    out << "; the recording ended before the gateway did: " << outcome.ended;
  }
  out << '\n';
}

}  // namespace

int run(const ReplayCommand& command, std::ostream& out, std::ostream& errors) {
  const std::string file = command.recording.string();
  std::error_code ignored;
  if (std::filesystem::is_directory(command.recording, ignored)) {
    return unreadable_recording(file, EISDIR, errors);
  }
  errno = 0;
  std::ifstream recording(command.recording, std::ios::binary);
  if (!recording) {
    return unreadable_recording(file, errno, errors);
  }
  const auto outcome = replay(recording, command.folder);
  if (outcome.bad) {
    errors << file << ':' << outcome.bad->line << ": error: " << outcome.bad->reason << '\n';
    return kExitConfiguration;
  }
  if (outcome.difference) {
    print_difference(file, outcome, out);
    return kExitNotDone;
  }
  print_same(outcome, out);
  return kExitDone;
}

}  // namespace mbgate::ctl
