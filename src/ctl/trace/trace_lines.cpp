// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <string_view>
#include <vector>

#include "base/text.hpp"
#include "ctl/request/repetition.hpp"
#include "ctl/trace/trace_event.hpp"
#include "modbus/codes.hpp"
#include "modbus/describe.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::ctl {
namespace {

constexpr std::string_view kFailed = "FAILED: ";
constexpr const char* kNoAnswer = "no answer (the client has disconnected or gets none)";

/// "5.1 ms"
std::string span_text(std::chrono::microseconds span) {
  return fmt::format("{:.1f} ms", std::chrono::duration<double, std::milli>(span).count());
}

/// "2nd", "11th"
std::string ordinal(std::uint64_t number) {
  const std::uint64_t tens = number / 10 % 10;
  const std::uint64_t last = tens == 1 ? 0 : number % 10;
  const char* const ends[] = {"th", "st", "nd", "rd"};
  return std::to_string(number) + ends[last < 4 ? last : 0];
}

/// "unit 1: 2 registers" of "transaction 7 unit 1: 2 registers".
std::string_view without_transaction(std::string_view text) {
  const std::size_t unit = text.find(" unit ");
  const bool has_both = text.starts_with("transaction ") && unit != std::string_view::npos;
  return has_both ? text.substr(unit + 1) : text;
}

/// "2 registers" of "transaction 7 unit 1: 2 registers".
std::string_view without_unit(std::string_view text) {
  text = without_transaction(text);
  const std::size_t colon = text.find(": ");
  return text.starts_with("unit ") && colon != std::string_view::npos ? text.substr(colon + 2)
                                                                      : text;
}

bool is_exception(const TracedAdu& answer) {
  const ByteString& adu = answer.raw.bytes;
  return adu.size() > modbus::kMbapHeaderSize &&
         (adu[modbus::kMbapHeaderSize] & modbus::kExceptionBit) != 0;
}

std::string ended_behind(const TracedRequest& asked) {
  const bool is_known = asked.ended.empty() || asked.ended == "answered";
  return is_known ? std::string() : ": " + asked.ended;
}

/// "line-a axis-x"
std::string place_of(const TracedFrame& frame) {
  if (frame.outcome == TracedOutcome::unasked) {
    return frame.bus;
  }
  return fmt::format(
      "{} {}", frame.bus,
      frame.device.empty() ? fmt::format("address {}", frame.address) : frame.device);
}

/// "(+0.1 ms after the request came; 2nd try)", or nothing.
std::string sent_note(const TracedFrame& frame, const std::optional<TracedRequest>& asked) {
  std::vector<std::string> notes;
  const std::string_view meaning = without_transaction(frame.sent->text);
  if (asked) {
    const auto after = frame.sent->raw.at - asked->request.raw.at;
    notes.push_back(after.count() < 0
                        ? span_text(-after) + " before the request came"
                        : fmt::format("+{} after the request came", span_text(after)));
  }
  if (!asked || meaning != without_transaction(asked->request.text)) {
    notes.emplace_back(meaning);
  }
  if (frame.tries > 1) {
    notes.push_back(ordinal(frame.tries) + " try");
  }
  if (frame.shared_by > 1) {
    notes.push_back(fmt::format("shared by {} requests", frame.shared_by));
  }
  if (frame.outcome == TracedOutcome::sent) {
    notes.emplace_back("no device answers this");
  }
  return notes.empty() ? "" : fmt::format("  ({})", fmt::join(notes, "; "));
}

/// What is said of heard bytes beside them.
std::string heard_note(const TracedFrame& frame, const std::optional<TracedRequest>& asked) {
  if (const std::string failure = failure_of(frame); !failure.empty()) {
    return std::string(kFailed) + failure;
  }
  const bool says_the_answer =
      asked && asked->answer && frame.heard_text == without_unit(asked->answer->text);
  return says_the_answer ? std::string() : frame.heard_text;
}

/// The line of what was heard, or nothing where nothing had to be heard.
std::string heard_line(const TracedFrame& frame, const std::optional<TracedRequest>& asked) {
  if (frame.heard.empty() && frame.outcome == TracedOutcome::sent) {
    return {};
  }
  std::string line = fmt::format("  {} <", place_of(frame));
  if (!frame.heard.empty()) {
    line += " " + modbus::hex(all_heard(frame));
    if (frame.not_kept > 0) {
      line += " " + and_more(frame.not_kept, "byte");
    }
    if (frame.sent) {
      line += "  " + span_text(frame.heard.front().at - frame.sent->raw.at);
    }
  }
  if (const std::string note = heard_note(frame, asked); !note.empty()) {
    line += (frame.heard.empty() ? " " : "  ") + note;
  }
  return line + "\n";
}

std::string frame_lines(const TracedFrame& frame, const std::optional<TracedRequest>& asked) {
  std::string lines;
  if (frame.sent) {
    lines = fmt::format("  {} > {}{}\n", place_of(frame), modbus::hex(frame.sent->raw.bytes),
                        sent_note(frame, asked));
  }
  return lines + heard_line(frame, asked);
}

std::string answer_line(const TraceEvent& event) {
  const TracedRequest& asked = *event.asked;
  const std::string failure = request_failure(event);
  std::string line = "  = ";
  if (!failure.empty()) {
    line.append(kFailed).append(failure);
  } else if (!asked.answer) {
    line += kNoAnswer;
  } else {
    line += without_unit(asked.answer->text);
    if (asked.refused) {
      line += "  (from the gateway itself)";
    } else if (event.wire.empty()) {
      line += "  (nothing was sent for it)";
    }
  }
  if (asked.answer) {
    line += fmt::format("  {} in all", span_text(asked.answer->raw.at - asked.request.raw.at));
  }
  return line + "\n";
}

std::string head_line(const TraceEvent& event) {
  if (event.asked) {
    const TracedRequest& asked = *event.asked;
    return fmt::format("{}{}{} {} {}\n", time_of_day(asked.request.raw.at),
                       request_failure(event).empty() ? " " : " FAILED ", asked.client,
                       asked.listener, without_transaction(asked.request.text));
  }
  const TracedFrame& frame = event.wire.front();
  if (frame.sent) {
    return fmt::format("{}{} without a traced request of a client\n",
                       time_of_day(frame.sent->raw.at), failure_of(frame).empty() ? "" : " FAILED");
  }
  return time_of_day(frame.heard.empty() ? frame.ended_at : frame.heard.front().at) +
         " heard without a request\n";
}

}  // namespace

std::string trace_lines(const TraceEvent& event) {
  std::string lines = head_line(event);
  for (const TracedFrame& frame : event.wire) {
    lines += frame_lines(frame, event.asked);
  }
  if (event.wire_not_kept > 0) {
    lines += fmt::format("  {}\n", and_more(event.wire_not_kept, "frame"));
  }
  return event.asked ? lines + answer_line(event) : lines;
}

std::string missing_records(std::uint64_t lost) {
  return fmt::format("{}{} missing here: they came faster than they were read", lost,
                     lost == 1 ? " record is" : " records are");
}

std::string failure_of(const TracedFrame& frame) {
  const std::string heard = frame.heard.empty() ? std::string() : ": " + frame.heard_text;
  const auto lasted = [&] {
    return frame.sent ? span_text(frame.ended_at - frame.sent->raw.at) : std::string();
  };
  switch (frame.outcome) {
    case TracedOutcome::answered:
    case TracedOutcome::sent:
    case TracedOutcome::unasked: return {};
    case TracedOutcome::damaged: return frame.heard_text;
    case TracedOutcome::no_response:
      return fmt::format("{}{}{}", heard.empty() ? "nothing within " : "no response within ",
                         lasted(), heard);
    case TracedOutcome::cut: return fmt::format("cut off after {}{}", lasted(), heard);
  }
  return {};
}

std::string request_failure(const TraceEvent& event) {
  if (!event.failed || !event.asked) {
    return {};
  }
  const TracedRequest& asked = *event.asked;
  if (!asked.answer) {
    return asked.ended == "transmitted" ? std::string() : kNoAnswer + ended_behind(asked);
  }
  if (!is_exception(*asked.answer)) {
    return {};
  }
  return fmt::format("{}{}{}", asked.refused ? "refused by the gateway: " : "",
                     without_unit(asked.answer->text), ended_behind(asked));
}

std::string and_more(std::uint64_t not_kept, const std::string& what) {
  return fmt::format("and {} more", counted(not_kept, what));
}

}  // namespace mbgate::ctl
