// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <fmt/core.h>
#include <functional>
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

using AskLine = std::function<Result<Heard, std::string>(std::uint8_t, const TableRange&,
                                                         std::chrono::nanoseconds wait)>;
/// Puts a text into the line of progress on a terminal.
using ShowProgress = std::function<void(const std::string&)>;

Result<Answer, std::string> identify(const AskLine& ask_line, std::uint8_t unit,
                                     const TableRange& read, std::chrono::nanoseconds wait) {
  const auto heard = ask_line(unit, read, wait);
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
  return {error ? device : path.string(), lasting_name(device, paths_in()), mode};
}

/// Identifies the units that answered in one mode, which is set.
ScanResult identify_all(const AskLine& ask_line, const PortSweep& port, const Catalogue& catalogue,
                        const ModeFindings& best, const ShowProgress& show) {
  const auto wait = std::max<std::chrono::nanoseconds>(port.wait, kPresentUnitWait);
  const auto ask = [&](std::uint8_t unit, const TableRange& read) {
    return identify(ask_line, unit, read, wait);
  };
  const auto progress = [&](std::uint8_t unit, std::size_t found) {
    show(fmt::format("identifying unit {}, {} of {} identified", unit, found, best.units.size()));
  };
  return scan_units(best.units, catalogue, ask, progress);
}

}  // namespace

PortScan scan_port(const ScanCommand& command, const Catalogue& catalogue, std::ostream& errors) {
  const auto& port = *command.port;
  PortScan scan;
  auto opened = SerialClient::open(port.device);
  if (!opened) {
    scan.result.error = port_failure(port.device, opened.error());
    return scan;
  }
  Sweep sweep({port, command.units});
  if (!command.json || command.show_progress) {
    errors << sweep_announcement(sweep.plan()) << '\n' << std::flush;
  }
  const Interruption interruption;  // before the client: its end gives the port its settings back
  SerialClient client = *std::move(opened);
  const AskLine ask = [&](std::uint8_t unit, const TableRange& read,
                          std::chrono::nanoseconds wait) -> Result<Heard, std::string> {
    if (interruption.wait_until(client.ready_at())) {
      return {boost::system::in_place_error, kInterrupted};
    }
    return client.ask(unit, read, wait);
  };
  const ShowProgress show = [&](const std::string& text) {
    if (command.show_progress) {
      errors << "\r" << text << "\x1b[K" << std::flush;
    }
  };
  const auto error =
      sweep.run({[&](const LineMode& mode) { return client.set_mode(mode); },
                 [&](std::uint8_t unit) { return ask(unit, kSweepRead, port.wait); }, show});
  const auto* best = sweep.best();
  scan.notes = sweep_notes(sweep);
  if (best == nullptr || error) {
    scan.result.error = error ? *error : nobody_text(sweep);
  } else if (const auto why = client.set_mode(best->mode)) {
    scan.result.error = port.device + ": " + *why;
  } else {
    scan.result = identify_all(ask, port, catalogue, *best, show);
  }
  show({});
  if (best != nullptr) {
    scan.line = line_found(port.device, best->mode);
    if (auto missing = missing_text(best->units, scan.result)) {
      scan.notes.push_back("at " + mode_text(best->mode) + " " + *std::move(missing));
    }
  }
  return scan;
}

}  // namespace mbgate::ctl
