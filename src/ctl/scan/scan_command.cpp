// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <fmt/core.h>
#include <memory>
#include <ostream>
#include <system_error>

#include "base/text.hpp"
#include "config/profiles/profile_library.hpp"
#include "ctl/profile/profile_text.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/request/modbus_client.hpp"
#include "ctl/scan/scan.hpp"
#include "ctl/scan/scan_report.hpp"
#include "modbus/request.hpp"

namespace mbgate::ctl {
namespace {

using modbus::TableRange;

/// Empty if the file was written, else what was wrong.
std::string write_new_file(const std::filesystem::path& path, const std::string& text) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "wx"),
                                                             &std::fclose);
  const bool written =
      file && std::fputs(text.c_str(), file.get()) >= 0 && std::fflush(file.get()) == 0;
  return written ? std::string()
                 : fmt::format("{}: {}", path.string(), std::generic_category().message(errno));
}

/// Why the scan ended early, or found nobody.
std::optional<std::string> find_error(const ScanCommand& command, const ScanResult& result) {
  if (result.error || !result.found.empty()) {
    return result.error;
  }
  if (!result.busy.empty()) {
    return "no other unit answered";
  }
  if (command.port) {
    return "no unit answered again";
  }
  return fmt::format("no unit answered{}",
                     result.any_way
                         ? std::string()
                         : fmt::format(", and the gateway transmitted nothing: is port {} that of "
                                       "a transparent listener, and is its line open?",
                                       command.target.port));
}

void print_misses(const PortScan& scan, const std::optional<std::string>& error,
                  std::ostream& errors) {
  for (const auto& note : scan.notes) {
    errors << "mbgatectl: " << note << '\n';
  }
  for (const auto unit : scan.result.busy) {
    errors << "mbgatectl: unit " << static_cast<unsigned>(unit)
           << " is busy, or its bus is: not scanned\n";
  }
  if (error) {
    errors << "mbgatectl: " << *error << '\n';
  }
}

std::optional<std::string> configuration_of(const ScanCommand& command, const PortScan& scan) {
  const auto& found = scan.result.found;
  if (found.empty()) {
    return std::nullopt;
  }
  return scan.line ? starting_config(*scan.line, command.bus, found)
                   : starting_config(command.target, command.bus, found);
}

int report(const ScanCommand& command, const PortScan& scan, std::ostream& out,
           std::ostream& errors) {
  auto error = find_error(command, scan.result);
  const auto configuration = configuration_of(command, scan);
  bool written = false;
  if (configuration && command.config) {
    const auto why = write_new_file(*command.config, *configuration);
    written = why.empty();
    if (!written) {
      error = error ? *error + "; " + why : why;
    }
  }
  if (command.json) {
    out << scan_json(scan, command.port.has_value(), configuration, error) << '\n';
    return error ? kExitNotDone : kExitDone;
  }
  print_misses(scan, error, errors);
  if (configuration) {
    // What could not be written to the file is printed: a scan may have taken minutes.
    out << (scan.line ? line_head(*scan.line) : std::string()) << scan_table(scan.result)
        << (written ? "" : "\n" + *configuration);
  }
  return error ? kExitNotDone : kExitDone;
}

ScanResult scan_through_gateway(const ScanCommand& command, const Catalogue& catalogue,
                                std::ostream& errors) {
  Target target = command.target;
  std::optional<Connection> connection;
  const auto ask = [&](std::uint8_t unit, const TableRange& read) -> Result<Answer, std::string> {
    if (!connection || target.unit != unit) {
      target.unit = unit;
      connection.emplace(target);
    }
    if (auto why = connection->open()) {
      return *std::move(why);
    }
    const auto begin = std::chrono::steady_clock::now();
    const auto response = connection->exchange(modbus::make_read(read));
    if (!response) {
      return Answer{AnswerKind::silence};
    }
    auto answer = answer_of(read, *response);
    answer.took = std::chrono::steady_clock::now() - begin;
    return answer;
  };
  const auto progress = [&](std::uint8_t unit, std::size_t found) {
    if (command.show_progress) {
      errors << "\rasking unit " << static_cast<unsigned>(unit) << ", " << found << " found "
             << std::flush;
    }
  };
  auto result = scan_units(command.units, catalogue, ask, progress);
  if (command.show_progress) {
    errors << "\r\x1b[K" << std::flush;
  }
  return result;
}

}  // namespace

int run(const ScanCommand& command, std::ostream& out, std::ostream& errors) {
  std::error_code ignored;
  if (command.config && std::filesystem::exists(*command.config, ignored)) {
    return report_failure({kExitUsage, command.config->string() + " already exists"}, command.json,
                          out, errors);
  }
  config::ProfileLibrary library(command.folder ? config::ProfileFolders{*command.folder}
                                                : config::default_profile_folders());
  const Catalogue catalogue(all_profiles(library));
  errors << config::render(library.diagnostics());
  if (catalogue.candidates().empty()) {
    const auto folders = joined(
        library.folders(), [](const auto& folder) { return folder.string(); }, " or ");
    return report_failure({kExitUsage, "there is no profile to compare with in " + folders},
                          command.json, out, errors);
  }
  if (command.port) {
    return report(command, scan_port(command, catalogue, errors), out, errors);
  }
  return report(command, {scan_through_gateway(command, catalogue, errors)}, out, errors);
}

}  // namespace mbgate::ctl
