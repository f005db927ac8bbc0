// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/trace_event.hpp"

#include <algorithm>
#include <array>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <charconv>
#include <ctime>
#include <fmt/core.h>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

using boost::json::object;
using boost::json::value;

std::string word_in(const object& json, std::string_view key) {
  return visible_text(json.at(key).as_string());
}

/// A word, or "" for null.
std::string word_or_none(const object& json, std::string_view key) {
  const value& it = json.at(key);
  return it.is_null() ? std::string() : visible_text(it.as_string());
}

std::uint64_t number_in(const object& json, std::string_view key) {
  return json.at(key).to_number<std::uint64_t>();
}

/// "2026-11-24T22:10:00.123456Z"
TraceInstant instant_in(const object& json, std::string_view key) {
  const std::string text = word_in(json, key);
  std::tm utc{};
  const char* rest = ::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &utc);
  constexpr std::size_t kFraction = std::string_view(".123456").size();
  const char* const end = text.data() + text.size();
  unsigned microseconds = 0;
  if (rest == nullptr || end - rest != kFraction + 1 || *rest != '.' || *(end - 1) != 'Z' ||
      std::from_chars(rest + 1, end, microseconds).ptr != end - 1) {
    throw std::invalid_argument(fmt::format("\"{}\" is not a time with microseconds", text));
  }
  return TraceInstant(std::chrono::seconds(::timegm(&utc)) +
                      std::chrono::microseconds(microseconds));
}

/// "01 03 00 1E"
ByteString bytes_from_hex(std::string_view text) {
  ByteString bytes;
  for (std::size_t at = 0; at < text.size(); at += 3) {
    const char* const end = text.data() + std::min(at + 2, text.size());
    std::uint8_t byte = 0;
    if (std::from_chars(text.data() + at, end, byte, 16).ptr != text.data() + at + 2 ||
        (at + 2 < text.size() && text[at + 2] != ' ')) {
      throw std::invalid_argument(fmt::format("\"{}\" is not a list of bytes", text));
    }
    bytes.push_back(byte);
  }
  return bytes;
}

TracedBytes raw_bytes(const object& json) {
  return {instant_in(json, "at"), bytes_from_hex(word_in(json, "bytes"))};
}

std::optional<TracedAdu> adu_in(const object& json, std::string_view key) {
  const value& it = json.at(key);
  if (it.is_null()) {
    return std::nullopt;
  }
  return TracedAdu{raw_bytes(it.as_object()), word_in(it.as_object(), "text")};
}

/// The one of `known` whose word stands there.
template <typename Meaning, std::size_t kSize>
Meaning meaning_in(const object& json, std::string_view key,
                   const std::array<std::pair<std::string_view, Meaning>, kSize>& known) {
  const std::string text = word_in(json, key);
  for (const auto& [word, meaning] : known) {
    if (text == word) {
      return meaning;
    }
  }
  throw std::invalid_argument(fmt::format("{} \"{}\" is not known", key, text));
}

constexpr std::array<std::pair<std::string_view, TracedFraming>, 3> kFramings{
    {{"rtu", TracedFraming::rtu}, {"ascii", TracedFraming::ascii}, {"tcp", TracedFraming::tcp}}};
constexpr std::array<std::pair<std::string_view, TracedOutcome>, 6> kOutcomes{
    {{"answered", TracedOutcome::answered},
     {"sent", TracedOutcome::sent},
     {"no response", TracedOutcome::no_response},
     {"damaged", TracedOutcome::damaged},
     {"cut", TracedOutcome::cut},
     {"unasked", TracedOutcome::unasked}}};

TracedFrame frame_of(const object& json) {
  TracedFrame frame;
  frame.bus = word_in(json, "bus");
  frame.device = word_or_none(json, "device");
  frame.address = json.at("address").to_number<std::uint8_t>();
  frame.framing = meaning_in(json, "framing", kFramings);
  frame.sent = adu_in(json, "sent");
  if (frame.sent) {
    frame.tries = number_in(json, "try");
    frame.shared_by = number_in(json, "shared_by");
  }
  for (const value& part : json.at("heard").as_array()) {
    frame.heard.push_back(raw_bytes(part.as_object()));
  }
  frame.not_kept = number_in(json, "heard_not_kept");
  frame.heard_text = word_in(json, "heard_text");
  if (const value& response = json.at("response"); !response.is_null()) {
    frame.response = bytes_from_hex(word_in(json, "response"));
  }
  frame.outcome = meaning_in(json, "outcome", kOutcomes);
  frame.ended_at = instant_in(json, "ended_at");
  return frame;
}

TracedRequest request_of(const object& json) {
  TracedRequest asked;
  const object& client = json.at("client").as_object();
  asked.client = word_in(client, "address");
  asked.connection = number_in(client, "connection");
  asked.listener = word_in(client, "listener");
  auto request = adu_in(json, "request");
  if (!request) {
    throw std::invalid_argument("a transaction without its request");
  }
  asked.request = *std::move(request);
  asked.answer = adu_in(json, "answer");
  asked.refused = json.at("refused").as_bool();
  asked.ended = word_or_none(json, "ended");
  return asked;
}

}  // namespace

TraceEvent parse_trace(const std::string& data) {
  const value parsed = boost::json::parse(data);
  const object& json = parsed.as_object();
  TraceEvent event;
  event.failed = json.at("failed").as_bool();
  if (json.contains("client")) {
    event.asked = request_of(json);
  }
  for (const value& frame : json.at("wire").as_array()) {
    event.wire.push_back(frame_of(frame.as_object()));
  }
  if (!event.asked && event.wire.empty()) {
    throw std::invalid_argument("a record without request and without frame");
  }
  event.wire_not_kept = number_in(json, "wire_not_kept");
  return event;
}

ByteString all_heard(const TracedFrame& frame) {
  ByteString all;
  for (const TracedBytes& part : frame.heard) {
    append(all, part.bytes);
  }
  return all;
}

}  // namespace mbgate::ctl
