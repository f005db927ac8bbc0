// SPDX-License-Identifier: Apache-2.0
// The text forms of events.
#include <algorithm>
#include <bitset>
#include <string_view>
#include <vector>

#include "gateway/event.hpp"
#include "gateway/status/quality_text.hpp"

namespace mbgate::gateway {
namespace {

std::string bus_text(const Settings& settings, BusId bus) {
  return "bus " + settings.bus(bus).name;
}

std::string device_text(const Settings& settings, BusId bus, std::uint8_t address) {
  for (const drive::Device& device : settings.devices) {
    if (device.bus == bus && device.address == address) {
      return "device " + device.name;
    }
  }
  return bus_text(settings, bus) + ": address " + std::to_string(address);
}

std::string what_of(modbus::Table table) {
  return table == modbus::Table::coils ? "coils " : "holding registers ";
}

template <typename ClientEvent>
std::string client_text(const Settings& settings, const ClientEvent& event) {
  return "listener " + settings.listener(event.listener).name + ": client " +
         event.address.to_text();
}

std::string asker_text(const Settings& settings, const Asker& asker) {
  return client_text(settings, asker) + identity_text(asker);
}

std::string left_out_text(std::uint64_t left_out, const char* what) {
  return left_out == 0 ? std::string()
                       : "; " + std::to_string(left_out) + " more " + what +
                             " since this was last said of the client";
}

std::string denied_text(const Settings& settings, const Denied& denied, const char* kind) {
  return asker_text(settings, denied) + kind + request_text(denied) + ", " + denied.by +
         left_out_text(denied.left_out, "were denied");
}

std::string_view reason_text(RefusalReason reason) {
  switch (reason) {
    case RefusalReason::not_allowed: return "not in the allow list";
    case RefusalReason::full:
      return "max_connections is reached, and each other client has one connection, which it uses, "
             "or is in the keep list";
    case RefusalReason::stopping: return "the gateway is stopping";
    case RefusalReason::no_rule: return "no access rule permits its address anything";
    case RefusalReason::address_full:
      return "max_connections_per_address is reached and none of these connections is idle";
    case RefusalReason::too_often: return "more than max_connects_per_second";
  }
  return "";
}

std::string seconds(Duration duration) {
  return std::to_string(std::chrono::ceil<std::chrono::seconds>(duration).count()) + " s";
}

std::string notice_text(const bus::DeviceNotice& notice) {
  using Kind = bus::DeviceNotice::Kind;
  switch (notice.kind) {
    case Kind::lost:
      return notice.answered_before
                 ? "does not answer any more"
                 : "no valid answer came so far, after " + std::to_string(notice.transmissions) +
                       (notice.transmissions == 1 ? " transmission" : " transmissions");
    case Kind::back: return notice.answered_before ? "answers again" : "answers";
    case Kind::late:
      return "an answer came " + milliseconds_text(notice.lateness) +
             " after its response timeout; after an unanswered request it is now left alone for " +
             milliseconds_text(notice.quarantine);
    case Kind::early: return "answers before its response_wait, which is set too long";
    case Kind::foreign:
      return std::string(notice.is_request ? "a request to it was heard that nobody here sent"
                                           : "a frame of it was heard that nobody here asked for") +
             "; another client is on this line";
    case Kind::misfit:
      return "its answer does not fit the request (if it limits values: write_echo = \"address\")";
    case Kind::pauses:
      return "its answers pause: frame_slack is less than " + milliseconds_text(notice.lateness);
    case Kind::second_answer: return "two answers came to one request: two devices at one address?";
    case Kind::stop_unanswered: return "a stop command was not acknowledged";
    case Kind::stop_refused:
      return "a stop command was refused with " + modbus::exception_text(notice.exception);
    case Kind::stop_forced:
      return "a stop command was sent though the line was never silent (stop_deadline)";
  }
  return {};
}

std::string failsafe_text(const FailsafeNews& news) {
  std::string reason;
  switch (news.reason) {
    case FailsafeReason::gone: reason = "the client that counts for it has gone"; break;
    case FailsafeReason::silent: reason = "the client that counts for it is silent"; break;
    case FailsafeReason::exit: reason = "the gateway stops"; break;
  }
  switch (news.outcome) {
    case FailsafeOutcome::acknowledged: return reason + "; it has acknowledged its failsafe writes";
    case FailsafeOutcome::waits:
      return reason + "; its failsafe writes are not acknowledged yet, and are sent again";
    case FailsafeOutcome::client_back:
      return "the client that counts for it asks again; not all of its failsafe writes were "
             "acknowledged";
    case FailsafeOutcome::given_up:
      return "not all of its failsafe writes were acknowledged before the gateway stopped";
    case FailsafeOutcome::device_gone:
      return "a reload has taken the device away; its failsafe writes are not sent any more, "
             "whatever clients have written to it";
  }
  return {};
}

// "11, 12, 20-32": more than two in a row are a range.
std::string routed_text(const std::bitset<256>& routed) {
  constexpr std::size_t kShown = 8;
  std::vector<std::string> entries;
  for (std::size_t unit = 0; unit < routed.size(); ++unit) {
    std::size_t last = unit;
    while (routed[unit] && last + 1 < routed.size() && routed[last + 1]) {
      ++last;
    }
    if (last - unit > 1) {
      entries.push_back(std::to_string(unit) + "-" + std::to_string(last));
      unit = last;
    } else if (routed[unit]) {
      entries.push_back(std::to_string(unit));
    }
  }
  if (entries.empty()) {
    return "no unit is routed";
  }
  std::string text = entries.size() == 1 && routed.count() == 1 ? "routed is " : "routed are ";
  for (std::size_t at = 0; at < std::min(entries.size(), kShown); ++at) {
    text += (at == 0 ? "" : ", ") + entries[at];
  }
  return entries.size() > kShown ? text + ", ..." : text;
}

std::string fault_text(bus::LineFault fault) {
  switch (fault) {
    case bus::LineFault::echo_differed:
      return "the echo differs from what was sent (collision, or echo = true is wrong)";
    case bus::LineFault::framing_lost: return "what comes in cannot be followed any further";
    case bus::LineFault::echo_found:
      return "the line hears what it sends; the echo is compared from now on (echo = true says so "
             "from the start)";
    case bus::LineFault::echo_unproven:
      return "a write was answered by its own repetition, and no read has shown yet whether that "
             "is an echo: until one has, it proves nothing (say echo = true or echo = false)";
    case bus::LineFault::echo_gone:
      return "no echo came with the last answers: the line does not hear what it sends (any more)";
    case bus::LineFault::echo_denied:
      return "the line hears what it sends: say echo = true, for with echo = false the echo of a "
             "write is taken for its answer";
    case bus::LineFault::unanswered: return "nothing comes from the far end";
    case bus::LineFault::answer_cut_off:
      return "an answer was not complete at the end of its response timeout: its length is wrong, "
             "or the rest of it is lost; the connection is replaced";
    case bus::LineFault::driver_stalled:
      return "the adapter does not send: the driver still holds bytes of a frame that should have "
             "left; they are dropped, so that they do not leave later, and the port is opened "
             "again";
    case bus::LineFault::answered_while_sending:
      return "an answer began before its request was sent whole, and was not taken; if the adapter "
             "does not keep the pace of the wire, say paced = false";
  }
  return "";
}

struct EventText {
  const Settings& settings;

  std::string operator()(const BusOpened& e) const {
    return bus_text(settings, e.bus) + " is open";
  }
  std::string operator()(const BusLost& e) const {
    return bus_text(settings, e.bus) + " is lost; it is being reopened";
  }
  std::string operator()(const AdapterSilent& e) const {
    return bus_text(settings, e.bus) + ": nothing at all was heard for " +
           std::to_string(std::chrono::duration_cast<std::chrono::seconds>(e.silence).count()) +
           " s, in which " + std::to_string(e.requests) +
           " requests left; in case that the adapter hangs it is closed and opened again, "
           "now and ever less often until something is heard";
  }
  std::string operator()(const ConnectionReplaced& e) const {
    return bus_text(settings, e.bus) + ": requests go out, but nothing has come for " +
           seconds(bus::kSilenceToReplace) + "; the connection is replaced";
  }
  std::string operator()(const ClientRefused& e) const {
    return client_text(settings, e) + " refused: " + std::string(reason_text(e.reason));
  }
  std::string operator()(const ClientDisplaced& e) const {
    const ListenerSettings& listener = settings.listener(e.listener);
    return client_text(settings, e) +
           (e.limit == RefusalReason::full
                ? " closed for a newcomer: max_connections (" +
                      std::to_string(listener.max_connections) +
                      ") is reached, and it had the most connections or had never asked anything"
                : " closed for a newer connection of the same client: max_connections_per_address "
                  "(" +
                      std::to_string(listener.max_connections_per_address) + ") is reached");
  }
  std::string operator()(const ClientOverRate& e) const {
    return client_text(settings, e) + " sends more than max_requests_per_second (" +
           std::to_string(settings.listener(e.listener).max_requests_per_second) +
           "): requests beyond that get exception 06, stops excepted";
  }
  std::string operator()(const ClientFramingLost& e) const {
    return client_text(settings, e) + " closed: MBAP length " + std::to_string(e.length) +
           " is not 2 to 254";
  }
  std::string operator()(const ClientSpeaksRtu& e) const {
    return client_text(settings, e) +
           " sends RTU frames to the Modbus TCP port; it must be set to Modbus TCP";
  }
  std::string operator()(const ClientFrameTimedOut& e) const {
    return client_text(settings, e) + " closed: a request stayed incomplete";
  }
  std::string operator()(const LineNews& e) const {
    return bus_text(settings, e.bus) + ": " + fault_text(e.fault);
  }
  std::string operator()(const LineNeverSilent& e) const {
    return bus_text(settings, e.bus) +
           " is never silent: another client, wrong baud rate, missing termination or bias";
  }
  std::string operator()(const Reconfigured& e) const {
    return device_text(settings, e.bus, e.address) + ": client " + e.client.to_text() +
           (e.by_value
                ? " has written a value that restores or rearranges it, or takes it off the line"
                : " has written its communication registers");
  }
  std::string operator()(const WriteEndedEarly& e) const {
    return device_text(settings, e.bus, e.address) + ": a write of " + what_of(e.table) +
           std::to_string(e.first) + " to " + std::to_string(e.end - 1) +
           " ended early; written up to " + std::to_string(e.failed - 1);
  }
  std::string operator()(const WordOrderDiffers& e) const {
    return device_text(settings, e.bus, e.address) +
           ": its own word order is not the one configured; values are not written to it";
  }
  std::string operator()(const DeviceNews& e) const {
    return device_text(settings, e.bus, e.notice.address) + ": " + notice_text(e.notice);
  }
  std::string operator()(const QualityNews& e) const {
    return (e.notice.address ? device_text(settings, e.bus, *e.notice.address)
                             : bus_text(settings, e.bus)) +
           ": " + quality_text(e.notice);
  }
  std::string operator()(const FailsafeNews& e) const {
    return device_text(settings, e.bus, e.address) + ": " + failsafe_text(e);
  }
  std::string operator()(const UnitNotRouted& e) const {
    return client_text(settings, e) + " asks for unit " + std::to_string(e.unit) + "; " +
           routed_text(e.routed);
  }
  std::string operator()(const Denied& e) const { return denied_text(settings, e, ": "); }
  std::string operator()(const StopDenied& e) const {
    return denied_text(settings, e, ": a stop, ");
  }
  std::string operator()(const WriteAccepted& e) const {
    return asker_text(settings, e) + (e.is_stop ? " stops" : " writes") +
           (e.target ? " (" + device_text(settings, e.target->bus, e.target->address) + "): "
                     : std::string(": ")) +
           request_text(e);
  }
  std::string operator()(const BroadcastLeavesOut& e) const {
    return asker_text(settings, e) + (e.is_stop ? " stops" : " writes") +
           " by broadcast, but not devices " + e.devices + ": " + request_text(e);
  }
  std::string operator()(const CountersCleared& e) const {
    return asker_text(settings, e) + " has cleared all counters: " + request_text(e) +
           left_out_text(e.left_out, "times");
  }
  std::string operator()(const ClientLoggedIn& e) const {
    return asker_text(settings, e) + " has logged in with its certificate" +
           left_out_text(e.left_out, "logins");
  }
};

}  // namespace

std::string to_text(const Event& event, const Settings& settings) {
  return std::visit(EventText{settings}, event);
}

}  // namespace mbgate::gateway
