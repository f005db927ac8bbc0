// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/trace_printer.hpp"

#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <fmt/core.h>
#include <ostream>
#include <string_view>

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

}  // namespace

bool TracePrinter::start() {
  if (ways_.capture != nullptr) {
    put(TraceCapture::start());
  }
  return is_written();
}

bool TracePrinter::take(const ServerEvent& event) {
  if (ways_.text != nullptr && ways_.json) {
    *ways_.text << with_name(event) << '\n';
  }
  const bool is_lost = event.name == "lost";
  if (is_read() && is_lost) {
    take_lost(event);
  } else if (is_read()) {
    take_record(event);
  }
  taken_ += is_lost ? 0 : 1;
  if (ways_.text != nullptr) {
    ways_.text->flush();
  }
  return is_written() && !is_done();
}

// What JSON alone is printed of is not looked into: another version may say more of it.
bool TracePrinter::is_read() const {
  return (ways_.text != nullptr && !ways_.json) || ways_.capture != nullptr;
}

void TracePrinter::take_lost(const ServerEvent& event) {
  const auto data = boost::json::parse(event.data);
  const auto lost = data.as_object().at("lost").to_number<std::uint64_t>();
  if (ways_.text != nullptr && !ways_.json) {
    *ways_.text << missing_records(lost) << '\n';
  }
  capture_.note_lost(lost);
}

void TracePrinter::take_record(const ServerEvent& event) {
  const TraceEvent record = parse_trace(event.data);
  if (ways_.text != nullptr && !ways_.json) {
    *ways_.text << trace_lines(record);
  }
  if (ways_.capture != nullptr) {
    put(capture_.add(record));
  }
}

void TracePrinter::put(const ByteString& blocks) {
  ways_.capture->write(reinterpret_cast<const char*>(blocks.data()),
                       static_cast<std::streamsize>(blocks.size()));
  ways_.capture->flush();
}

bool TracePrinter::is_written() const {
  return (ways_.text == nullptr || ways_.text->good()) &&
         (ways_.capture == nullptr || ways_.capture->good());
}

namespace {

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

}  // namespace

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

}  // namespace mbgate::ctl
