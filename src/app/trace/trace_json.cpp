// SPDX-License-Identifier: Apache-2.0
#include "app/trace/trace_json.hpp"

#include <algorithm>
#include <boost/json/value.hpp>
#include <fmt/core.h>
#include <utility>

#include "app/text.hpp"
#include "base/text.hpp"
#include "config/toml/match_entry.hpp"
#include "modbus/describe.hpp"
#include "modbus/mbap.hpp"
#include "report/text.hpp"

namespace mbgate::app {
namespace {

using boost::json::object;
using gateway::AskedTrace;
using gateway::ByteString;
using gateway::WireTrace;
using modbus::Direction;
using std::chrono::system_clock;

/// Instants of the machine as the time of day.
class Clock {
 public:
  explicit Clock(system_clock::time_point epoch) : epoch_(epoch) {}
  [[nodiscard]] std::string at(gateway::Instant instant) const {
    return utc_microsecond(
        epoch_ + std::chrono::duration_cast<system_clock::duration>(instant.time_since_epoch()));
  }

 private:
  system_clock::time_point epoch_;
};

object adu_json(const ByteString& adu, Direction direction, const std::string& at) {
  return {{"at", at}, {"bytes", modbus::hex(adu)}, {"text", modbus::describe_mbap(adu, direction)}};
}

/// null: it has none.
boost::json::value name_json(const std::string& name) {
  return name.empty() ? boost::json::value(nullptr) : boost::json::value(valid_utf8(name));
}

/// null: it has none.
boost::json::value instant_json(const std::optional<gateway::Instant>& instant,
                                const Clock& clock) {
  return instant ? boost::json::value(clock.at(*instant)) : boost::json::value(nullptr);
}

/// Whole, unlike the difference of two instants: it is held against what is required.
boost::json::value silence_json(const WireTrace& wire) {
  using Milliseconds = std::chrono::duration<double, std::milli>;
  return wire.silent_since
             ? boost::json::value(Milliseconds(wire.sent_at - *wire.silent_since).count())
             : boost::json::value(nullptr);
}

object wire_json(const WireTrace& wire, const Clock& clock) {
  object json{{"bus", valid_utf8(wire.bus)},
              {"device", name_json(wire.device)},
              {"address", wire.address},
              {"framing", config::word_for(config::kFramings, wire.framing)},
              {"sent", nullptr},
              {"outcome", report::to_text(wire.outcome)},
              {"ended_at", clock.at(wire.ended_at)},
              {"response", nullptr}};
  if (wire.outcome != WireTrace::Outcome::unasked) {
    json["sent"] = object{{"at", clock.at(wire.sent_at)},
                          {"bytes", modbus::hex(wire.frame)},
                          {"text", report::sent_text(wire)}};
    json["try"] = wire.tries;
    json["shared_by"] = wire.shared_by;
    json["silence_ms"] = silence_json(wire);
    json["left_at"] = instant_json(wire.left_at, clock);
    json["held_until"] = instant_json(wire.held_until, clock);
  }
  json["heard"] = array_of(wire.heard, [&](const gateway::HeardBytes& part) {
    return object{{"at", clock.at(part.at)}, {"bytes", modbus::hex(part.bytes)}};
  });
  json["heard_not_kept"] = wire.not_kept;
  json["heard_text"] = report::heard_text(wire);
  if (wire.response) {
    json["response"] = modbus::hex(*wire.response);
  }
  return json;
}

void add_asked(object& json, const AskedTrace& asked, const Clock& clock) {
  json["client"] = object{{"address", asked.client.to_text()},
                          {"connection", static_cast<std::uint64_t>(asked.connection)},
                          {"listener", valid_utf8(asked.listener)}};
  json["request"] = adu_json(asked.request, Direction::request, clock.at(asked.asked_at));
  json["answer"] = nullptr;
  if (asked.answer) {
    json["answer"] = adu_json(*asked.answer, Direction::response, clock.at(asked.answered_at));
  }
  json["refused"] = asked.refused;
  json["targets"] = array_of(asked.targets, [](const AskedTrace::Target& target) {
    return object{{"bus", valid_utf8(target.bus)}, {"device", name_json(target.device)}};
  });
}

/// "a%20b+c" is "a b c" (application/x-www-form-urlencoded); nothing if a '%' has no two digits.
std::optional<std::string> decoded(std::string_view text) {
  std::string plain;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] != '%') {
      plain += text[at] == '+' ? ' ' : text[at];
      continue;
    }
    constexpr std::size_t kDigits = 2;
    const std::string_view digits = text.substr(at + 1, kDigits);
    const auto byte = integer_in<unsigned char>(digits, 16);
    if (!byte || digits.size() != kDigits) {
      return std::nullopt;
    }
    plain += static_cast<char>(*byte);
    at += kDigits;
  }
  return plain;
}

/// Takes what stands before the separator, or all, out of the text.
std::string_view take_before(std::string_view& text, char separator) {
  const std::string_view part = text.substr(0, text.find(separator));
  text.remove_prefix(std::min(part.size() + 1, text.size()));
  return part;
}

/// Returns what is wrong, or nothing.
std::string set(TraceFilter& filter, std::string_view key, const std::string& value) {
  if (key == "bus") {
    filter.bus = value;
  } else if (key == "device") {
    filter.device = value;
  } else if (key == "client") {
    filter.client = routing::ClientAddress::parse(value);
    return filter.client ? "" : fmt::format("client={}: expected an IP address", value);
  } else if (key == "function") {
    filter.function = integer_in<std::uint8_t>(value);
    return filter.function ? "" : fmt::format("function={}: expected a number, 0 to 255", value);
  } else if (key == "only" && value == "failed") {
    filter.only_failed = true;
  } else if (key == "events" && value == "1") {
    filter.with_journal = true;
  } else {
    return fmt::format("{}={}: expected bus=, device=, client=, function=, only=failed or events=1",
                       key, value);
  }
  return {};
}

}  // namespace

const char* trace_kind(const gateway::TraceRecord& record) {
  if (record.asked) {
    return "transaction";
  }
  const bool is_heard = record.wire.front().outcome == WireTrace::Outcome::unasked;
  return is_heard ? "heard" : "frame";
}

object trace_json(const gateway::TraceRecord& record, system_clock::time_point epoch) {
  const Clock clock(epoch);
  object json{{"failed", record.is_failed()}};
  if (record.asked) {
    add_asked(json, *record.asked, clock);
    json["ended"] = nullptr;
    if (record.ended_as) {
      json["ended"] = report::to_text(*record.ended_as, !record.wire.empty());
    }
  }
  json["wire"] = array_of(record.wire, [&](const WireTrace& it) { return wire_json(it, clock); });
  json["wire_not_kept"] = record.wire_not_kept;
  return json;
}

Result<TraceFilter, std::string> TraceFilter::parse(std::string_view query) {
  TraceFilter filter;
  while (!query.empty()) {
    std::string_view value = take_before(query, '&');
    const std::string_view key = take_before(value, '=');
    const auto plain = decoded(value);
    std::string wrong = plain ? set(filter, key, *plain)
                              : fmt::format("{}: expected two hexadecimal digits after %", key);
    if (!wrong.empty()) {
      return {boost::system::in_place_error, std::move(wrong)};
    }
  }
  return filter;
}

bool TraceFilter::matches(const gateway::TraceRecord& record) const {
  if (only_failed && !record.is_failed()) {
    return false;
  }
  if (client && (!record.asked || record.asked->client != *client)) {
    return false;
  }
  if (function && (!record.asked || record.asked->request[modbus::kMbapHeaderSize] != *function)) {
    return false;
  }
  const auto is_one = [](const auto& all, const auto& name, auto member) {
    return std::ranges::find(all, name, member) != all.end();
  };
  using Target = gateway::AskedTrace::Target;
  const auto is_of = [&](const auto& name, auto of_wire, auto of_target) {
    return !name || is_one(record.wire, *name, of_wire) ||
           (record.asked && is_one(record.asked->targets, *name, of_target));
  };
  return is_of(bus, &gateway::WireTrace::bus, &Target::bus) &&
         is_of(device, &gateway::WireTrace::device, &Target::device);
}

}  // namespace mbgate::app
