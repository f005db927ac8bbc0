// SPDX-License-Identifier: Apache-2.0
#include "app/trace/trace_json.hpp"

#include <boost/json/array.hpp>
#include <boost/json/value.hpp>

#include "app/text.hpp"
#include "gateway/trace/trace_text.hpp"
#include "modbus/describe.hpp"

namespace mbgate::app {
namespace {

using boost::json::array;
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
              {"framing", framing_word(wire.framing)},
              {"sent", nullptr},
              {"outcome", to_text(wire.outcome)},
              {"ended_at", clock.at(wire.ended_at)},
              {"response", nullptr}};
  if (wire.outcome != WireTrace::Outcome::unasked) {
    json["sent"] = object{{"at", clock.at(wire.sent_at)},
                          {"bytes", modbus::hex(wire.frame)},
                          {"text", sent_text(wire)}};
    json["try"] = wire.tries;
    json["shared_by"] = wire.shared_by;
    json["silence_ms"] = silence_json(wire);
    json["left_at"] = instant_json(wire.left_at, clock);
    json["held_until"] = instant_json(wire.held_until, clock);
  }
  array heard;
  for (const gateway::HeardBytes& part : wire.heard) {
    heard.push_back(object{{"at", clock.at(part.at)}, {"bytes", modbus::hex(part.bytes)}});
  }
  json["heard"] = std::move(heard);
  json["heard_not_kept"] = wire.not_kept;
  json["heard_text"] = heard_text(wire);
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
  array targets;
  for (const AskedTrace::Target& target : asked.targets) {
    targets.push_back(
        object{{"bus", valid_utf8(target.bus)}, {"device", name_json(target.device)}});
  }
  json["targets"] = std::move(targets);
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
      json["ended"] = gateway::to_text(*record.ended_as, !record.wire.empty());
    }
  }
  array wire;
  for (const WireTrace& it : record.wire) {
    wire.push_back(wire_json(it, clock));
  }
  json["wire"] = std::move(wire);
  json["wire_not_kept"] = record.wire_not_kept;
  return json;
}

}  // namespace mbgate::app
