// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/trace_printer.hpp"

#include <algorithm>
#include <array>
#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <cerrno>
#include <cstring>
#include <fmt/core.h>
#include <fstream>
#include <ostream>
#include <string_view>

#include "ctl/request/carry_out.hpp"
#include "ctl/request/repetition.hpp"
#include "ctl/trace/trace_event.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

/// {"event":"transaction", and what came}
std::string with_name(const ServerEvent& event) {
  boost::json::object whole{{"event", event.name}};
  const boost::json::value data = boost::json::parse(event.data);
  for (const auto& [key, value] : data.as_object()) {
    whole[key] = value;
  }
  return visible_text(boost::json::serialize(whole));
}

constexpr std::string_view kUnreserved =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";

std::string percent_encoded(std::string_view text) {
  std::string encoded;
  for (const char character : text) {
    if (kUnreserved.find(character) != std::string_view::npos) {
      encoded += character;
    } else {
      encoded += fmt::format("%{:02X}", static_cast<unsigned char>(character));
    }
  }
  return encoded;
}

std::string cannot_write(const std::string& file) {
  return "cannot write " + file + ": " + std::strerror(errno);
}

}  // namespace

bool TracePrinter::start() {
  if (ways_.capture != nullptr) {
    put(TraceCapture::start());
  }
  return is_written();
}

bool TracePrinter::take(const ServerEvent& event) {
  if (ways_.json != nullptr) {
    *ways_.json << with_name(event) << '\n';
  }
  // What JSON alone is printed of is not looked into: another version may say more of it.
  if (ways_.text != nullptr || ways_.capture != nullptr) {
    look_into(event);
  }
  taken_ += event.name == "lost" ? 0 : 1;
  return is_written() && !is_done();
}

void TracePrinter::look_into(const ServerEvent& event) {
  std::string lines;
  if (event.name == "lost") {
    const auto data = boost::json::parse(event.data);
    const auto lost = data.as_object().at("lost").to_number<std::uint64_t>();
    lines = missing_records(lost) + "\n";
    capture_.note_lost(lost);
  } else {
    const TraceEvent record = parse_trace(event.data);
    lines = trace_lines(record);
    if (ways_.capture != nullptr) {
      put(capture_.add(record));
    }
  }
  if (ways_.text != nullptr) {
    *ways_.text << lines;
  }
}

void TracePrinter::put(const ByteString& blocks) {
  ways_.capture->write(reinterpret_cast<const char*>(blocks.data()),
                       static_cast<std::streamsize>(blocks.size()));
}

bool TracePrinter::is_written() const {
  return std::ranges::all_of(std::array{ways_.text, ways_.json, ways_.capture},
                             [](auto* out) { return out == nullptr || out->flush().good(); });
}

std::string trace_target(const TraceFilter& filter) {
  std::string query;
  const auto add = [&](std::string_view key, std::string_view value) {
    if (!value.empty()) {
      query += fmt::format("{}{}={}", query.empty() ? "?" : "&", key, percent_encoded(value));
    }
  };
  add("bus", filter.bus);
  add("device", filter.device);
  add("client", filter.client);
  add("function", filter.function ? std::to_string(*filter.function) : "");
  add("only", filter.only_failed ? "failed" : "");
  return "/api/v1/trace" + query;
}

int run(const TraceCommand& command, std::ostream& out, std::ostream& errors) {
  const auto fail = [&](const std::string& why) {
    return report_failure({kExitNotDone, why}, command.json, out, errors);
  };
  std::ostream* const printed = command.quiet || command.pcapng == "-" ? nullptr : &out;
  std::ofstream file;
  if (!command.pcapng.empty() && command.pcapng != "-") {
    file.open(command.pcapng, std::ios::binary);
    if (!file) {
      return fail(cannot_write(command.pcapng));
    }
  }
  std::ostream* const capture = command.pcapng == "-"    ? &out
                                : command.pcapng.empty() ? nullptr
                                                         : &file;
  const Interruption interruption;
  TracePrinter printer(
      {command.json ? nullptr : printed, command.json ? printed : nullptr, capture, command.times});
  if (printer.start()) {
    const std::string why =
        follow_events(command.socket, trace_target(command.filter), interruption,
                      [&](const ServerEvent& event) { return printer.take(event); });
    if (!why.empty()) {
      return fail(why);
    }
  }
  if (file.is_open() && !file) {
    return fail(cannot_write(command.pcapng));
  }
  return printer.is_done() ? kExitDone : kExitNotDone;
}

}  // namespace mbgate::ctl
