// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <fmt/core.h>
#include <iterator>
#include <ostream>
#include <system_error>
#include <utility>

#include "ctl/request/repetition.hpp"
#include "ctl/scan/scan.hpp"
#include "ctl/scan/sweep.hpp"
#include "ctl/serial/serial_client.hpp"
#include "ctl/serial/serial_port.hpp"

namespace mbgate::ctl {
namespace {

using modbus::TableRange;

constexpr const char* kInterrupted = "interrupted";
/// Units that are there get more time than those that may not be: long reads take a drive longer,
/// and an answer that comes later would be taken for that to the next read.
constexpr std::chrono::seconds kPresentUnitWait{2};

/// The client, and the pauses between its questions, in which a signal ends the scan.
class PausingClient {
 public:
  explicit PausingClient(SerialClient client) : client_(std::move(client)) {}

  std::optional<std::string> set_mode(const LineMode& mode) { return client_.set_mode(mode); }

  Result<Heard, std::string> ask(std::uint8_t unit, const TableRange& read,
                                 std::chrono::nanoseconds wait) {
    if (interruption_.wait_until(client_.ready_at())) {
      return {boost::system::in_place_error, kInterrupted};
    }
    return client_.ask(unit, read, wait);
  }

 private:
  Interruption interruption_;
  SerialClient client_;
};

/// The line of progress on a terminal.
class ProgressLine {
 public:
  ProgressLine(bool shown, std::ostream& errors) : shown_(shown), errors_(errors) {}
  void show(const std::string& text) const {
    if (shown_) {
      errors_ << "\r" << text << "\x1b[K" << std::flush;
    }
  }
  void clear() const { show({}); }

 private:
  bool shown_;
  std::ostream& errors_;
};

Result<Answer, std::string> identify(PausingClient& client, std::uint8_t unit,
                                     const TableRange& read, std::chrono::nanoseconds wait) {
  const auto heard = client.ask(unit, read, wait);
  if (!heard) {
    return heard.error();
  }
  if (heard->kind != HeardKind::answer) {
    return Answer{AnswerKind::silence};
  }
  auto answer = answer_of(read, *heard->response);
  answer.took = heard->took;
  return answer;
}

/// Those of `answered` that were not identified.
std::optional<std::string> missing_text(const std::vector<std::uint8_t>& answered,
                                        const ScanResult& result) {
  std::vector<std::uint8_t> missing;
  std::ranges::copy_if(answered, std::back_inserter(missing), [&](std::uint8_t unit) {
    return std::ranges::find(result.found, unit, &FoundUnit::unit) == result.found.end() &&
           std::ranges::find(result.busy, unit) == result.busy.end();
  });
  if (missing.empty()) {
    return std::nullopt;
  }
  return fmt::format("{} answered, and {} not identified", units_text(missing),
                     missing.size() == 1 ? "was" : "were");
}

/// A configuration may be read in another folder, so its path is absolute.
FoundLine line_found(const std::string& device, const LineMode& mode) {
  std::error_code error;
  const auto path = std::filesystem::absolute(device, error);
  return {error ? device : path.string(), lasting_name(device, serial_names()), mode};
}

/// Identifies the units that answered in one mode.
ScanResult identify_all(PausingClient& client, const PortSweep& port, const Catalogue& catalogue,
                        const ModeFindings& best, const ProgressLine& line) {
  if (auto why = client.set_mode(best.mode)) {
    ScanResult result;
    result.error = port.device + ": " + *why;
    return result;
  }
  const auto wait = std::max<std::chrono::nanoseconds>(port.wait, kPresentUnitWait);
  const auto ask = [&](std::uint8_t unit, const TableRange& read) {
    return identify(client, unit, read, wait);
  };
  const auto progress = [&](std::uint8_t unit, std::size_t found) {
    line.show(
        fmt::format("identifying unit {}, {} of {} identified", unit, found, best.units.size()));
  };
  return scan_units(best.units, catalogue, ask, progress);
}

}  // namespace

PortScan scan_port(const ScanCommand& command, const Catalogue& catalogue, std::ostream& errors) {
  const auto& port = *command.port;
  PortScan scan;
  auto opened = SerialClient::open(port.device);
  if (!opened) {
    scan.result.error = opened.error();
    return scan;
  }
  Sweep sweep({command.units, port.modes, port.wait, port.all_modes});
  if (!command.json || command.show_progress) {
    errors << sweep_announcement(port.device, sweep.plan()) << '\n' << std::flush;
  }
  PausingClient client(*std::move(opened));
  const ProgressLine line(command.show_progress, errors);
  const auto error = carry_out_sweep(
      sweep, {[&](const LineMode& mode) { return client.set_mode(mode); },
              [&](std::uint8_t unit) { return client.ask(unit, kSweepRead, port.wait); },
              [&](const Sweep& now) { line.show(sweep_progress(now)); }});
  const auto* best = sweep.best();
  scan.notes = sweep_notes(sweep);
  if (best != nullptr && !error) {
    scan.result = identify_all(client, port, catalogue, *best, line);
  } else {
    scan.result.error = error ? *error : nobody_text(port.device, sweep);
  }
  line.clear();
  if (best != nullptr) {
    scan.line = line_found(port.device, best->mode);
    if (auto missing = missing_text(best->units, scan.result)) {
      scan.notes.push_back("at " + mode_text(best->mode) + " " + *std::move(missing));
    }
  }
  return scan;
}

}  // namespace mbgate::ctl
