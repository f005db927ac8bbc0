// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bitset>
#include <fmt/format.h>
#include <span>
#include <string_view>
#include <vector>

#include "base/text.hpp"
#include "modbus/describe.hpp"
#include "report/findings/findings.hpp"
#include "report/text.hpp"

namespace mbgate::report {
namespace {

using namespace gateway;

std::string left_out_text(std::uint64_t left_out, const char* what) {
  return left_out == 0
             ? std::string()
             : fmt::format("; {} more {} since the last report for this client", left_out, what);
}

std::string_view reason_text(RefusalReason reason) {
  switch (reason) {
    case RefusalReason::not_allowed: return "not in the allow list";
    case RefusalReason::full:
      return "max_connections is reached, and every other client uses its only connection or is in "
             "the keep list";
    case RefusalReason::stopping: return "the gateway is stopping";
    case RefusalReason::no_rule: return "no access rule permits its address anything";
    case RefusalReason::address_full:
      return "max_connections_per_address is reached and none of these connections is idle";
    case RefusalReason::too_often: return "more than max_connects_per_second";
  }
  return "";
}

std::string seconds(Duration duration) {
  return fmt::format("{} s", std::chrono::ceil<std::chrono::seconds>(duration).count());
}

std::string notice_text(const bus::DeviceNotice& notice) {
  using Kind = bus::DeviceNotice::Kind;
  switch (notice.kind) {
    case Kind::lost:
      return notice.answered_before ? "does not answer any more"
                                    : fmt::format("no valid answer came so far, after {}",
                                                  counted(notice.transmissions, "transmission"));
    case Kind::back: return notice.answered_before ? "answers again" : "answers";
    case Kind::late:
      return fmt::format(
          "an answer came {} after its response timeout; the device is now held back for {} "
          "after an unanswered request",
          milliseconds_text(notice.lateness), milliseconds_text(notice.quarantine));
    case Kind::early: return "answers before its response_wait, which is set too long";
    case Kind::foreign:
      return fmt::format("{}; another client is on this line",
                         notice.is_request
                             ? "a request to it was heard that the gateway did not send"
                             : "a frame of it was heard that the gateway had not asked for");
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
    case FailsafeOutcome::acknowledged:
      return reason + "; the device has acknowledged its failsafe writes";
    case FailsafeOutcome::waits:
      return reason + "; its failsafe writes are not acknowledged yet, and are sent again";
    case FailsafeOutcome::client_back:
      return "the client that counts for it asks again; not all of its failsafe writes were "
             "acknowledged";
    case FailsafeOutcome::given_up:
      return "not all of its failsafe writes were acknowledged before the gateway stopped";
    case FailsafeOutcome::device_gone:
      return "a reload has removed the device; its failsafe writes are not sent any more, although "
             "clients have written to it";
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
      entries.push_back(fmt::format("{}-{}", unit, last));
      unit = last;
    } else if (routed[unit]) {
      entries.push_back(std::to_string(unit));
    }
  }
  if (entries.empty()) {
    return "no unit is routed";
  }
  const auto shown = std::span(entries).first(std::min(entries.size(), kShown));
  return fmt::format("routed {} {}{}", routed.count() == 1 ? "is" : "are", fmt::join(shown, ", "),
                     entries.size() > kShown ? ", ..." : "");
}

std::string fault_text(bus::LineFault fault) {
  switch (fault) {
    case bus::LineFault::echo_differed:
      return "the echo differs from what was sent (collision, or echo = true is wrong)";
    case bus::LineFault::framing_lost:
      return "framing is lost: the start of the next message cannot be found";
    case bus::LineFault::echo_found:
      return "the adapter receives what it sends; the echo is checked from now on (echo = true: "
             "from the start)";
    case bus::LineFault::echo_unproven:
      return "a write came back unchanged, and no read has shown yet whether that is its answer or "
             "an echo: until then it acknowledges nothing (set echo = true or echo = false)";
    case bus::LineFault::echo_gone:
      return "the last answers came without an echo: the adapter does not receive what it sends "
             "(any more)";
    case bus::LineFault::echo_denied:
      return "the adapter receives what it sends: set echo = true, because with echo = false the "
             "echo of a write is taken for its answer";
    case bus::LineFault::unanswered:
      return fmt::format(
          "requests are sent, but nothing has come back for {}; the connection is replaced",
          seconds(bus::kSilenceToReplace));
    case bus::LineFault::answer_cut_off:
      return "an answer was not complete at the end of its response timeout: its length is wrong, "
             "or the rest of it is lost; the connection is replaced";
    case bus::LineFault::driver_stalled:
      return "the adapter does not send: the driver still holds bytes of a frame that should have "
             "left; they are dropped, so that they do not leave later, and the port is opened "
             "again";
    case bus::LineFault::answered_while_sending:
      return "an answer began before its request was completely sent, and was not accepted; if the "
             "adapter is not bound to the speed of the wire, set paced = false";
  }
  return "";
}

/// What the journal calls them.
struct Names {
  const Settings& settings;

  [[nodiscard]] std::string bus(BusId id) const { return "bus " + settings.bus(id).name; }
  [[nodiscard]] std::string device(BusId id, std::uint8_t address) const {
    const std::string name = settings.device_name(id, address);
    return name.empty() ? fmt::format("{}: address {}", bus(id), address) : "device " + name;
  }
  [[nodiscard]] std::string client(const Asker& who) const {
    return fmt::format("listener {}: client {}", settings.listener(who.listener).name,
                       who.address.to_text());
  }
  [[nodiscard]] std::string asker(const Asker& who) const {
    return client(who) + identity_text(who);
  }
};

std::string denied_text(const Names& names, const Denied& denied, const char* kind) {
  return fmt::format("{}{}{}, {}{}", names.asker(denied), kind, request_text(denied), denied.by,
                     left_out_text(denied.left_out, "were denied"));
}

struct EventText {
  Names names;

  std::string operator()(const BusOpened& e) const { return names.bus(e.bus) + " is open"; }
  std::string operator()(const BusLost& e) const {
    return names.bus(e.bus) + " is lost; it is being reopened";
  }
  std::string operator()(const AdapterSilent& e) const {
    return fmt::format(
        "{}: not a byte was heard for {} s, in which {} requests were sent; the adapter may hang, "
        "so it is closed and opened again, now and at growing intervals until something is heard",
        names.bus(e.bus), std::chrono::duration_cast<std::chrono::seconds>(e.silence).count(),
        e.requests);
  }
  std::string operator()(const ClientRefused& e) const {
    return fmt::format("{} refused: {}", names.client(e), reason_text(e.reason));
  }
  std::string operator()(const ClientDisplaced& e) const {
    const ListenerSettings& listener = names.settings.listener(e.listener);
    return names.client(e) +
           (e.limit == RefusalReason::full
                ? fmt::format(" closed for a newcomer: max_connections ({}) is reached, and it had "
                              "the most connections or had never asked anything",
                              listener.max_connections)
                : fmt::format(" closed for a newer connection of the same client: "
                              "max_connections_per_address ({}) is reached",
                              listener.max_connections_per_address));
  }
  std::string operator()(const ClientOverRate& e) const {
    return fmt::format(
        "{} sends more than max_requests_per_second ({}): requests beyond that get exception 06, "
        "stops excepted",
        names.client(e), names.settings.listener(e.listener).max_requests_per_second);
  }
  std::string operator()(const ClientFramingLost& e) const {
    const auto why = e.sends.empty() ? fmt::format("MBAP length {} is not 2 to 254", e.length)
                                     : fmt::format("it sends {} to the Modbus TCP port", e.sends);
    return names.client(e) + " closed: " + why;
  }
  std::string operator()(const ClientSpeaksRtu& e) const {
    return names.client(e) +
           " sends RTU frames to the Modbus TCP port; it must be set to Modbus TCP";
  }
  std::string operator()(const ClientFrameTimedOut& e) const {
    return names.client(e) + " closed: a request stayed incomplete";
  }
  std::string operator()(const LineNews& e) const {
    return fmt::format("{}: {}", names.bus(e.bus), fault_text(e.fault));
  }
  std::string operator()(const LineNeverSilent& e) const {
    return names.bus(e.bus) +
           " is never silent: another client, wrong baud rate, missing termination or bias";
  }
  std::string operator()(const Reconfigured& e) const {
    return fmt::format(
        "{}: client {}{}", names.device(e.bus, e.address), e.client.to_text(),
        e.by_value ? " has written a value that restores or rearranges it, or takes it off the line"
                   : " has written its communication registers");
  }
  std::string operator()(const WriteEndedEarly& e) const {
    return fmt::format("{}: a write of {} {} to {} ended early; written up to {}",
                       names.device(e.bus, e.address), modbus::table_name(e.table), e.first,
                       e.end - 1, e.failed - 1);
  }
  std::string operator()(const WordOrderDiffers& e) const {
    return names.device(e.bus, e.address) +
           ": its own word order is not the one configured; values are not written to it";
  }
  std::string operator()(const DeviceNews& e) const {
    return fmt::format("{}: {}", names.device(e.bus, e.notice.address), notice_text(e.notice));
  }
  std::string operator()(const QualityNews& e) const {
    return fmt::format("{}: {}",
                       e.notice.address ? names.device(e.bus, *e.notice.address) : names.bus(e.bus),
                       quality_text(e.notice));
  }
  std::string operator()(const FailsafeNews& e) const {
    return fmt::format("{}: {}", names.device(e.bus, e.address), failsafe_text(e));
  }
  std::string operator()(const UnitNotRouted& e) const {
    return fmt::format("{} asks for unit {}; {}", names.client(e), e.unit, routed_text(e.routed));
  }
  std::string operator()(const Denied& e) const { return denied_text(names, e, ": "); }
  std::string operator()(const StopDenied& e) const { return denied_text(names, e, ": a stop, "); }
  std::string operator()(const WriteAccepted& e) const {
    return fmt::format(
        "{} {}{}: {}", names.asker(e), e.is_stop ? "stops" : "writes",
        e.target ? fmt::format(" ({})", names.device(e.target->bus, e.target->address)) : "",
        request_text(e));
  }
  std::string operator()(const BroadcastLeavesOut& e) const {
    return fmt::format("{}{} by broadcast, but not devices {}: {}", names.asker(e),
                       e.is_stop ? " stops" : " writes", e.devices, request_text(e));
  }
  std::string operator()(const CountersCleared& e) const {
    return fmt::format("{} has cleared all counters: {}{}", names.asker(e), request_text(e),
                       left_out_text(e.left_out, "times"));
  }
  std::string operator()(const ClientLoggedIn& e) const {
    return fmt::format("{} has logged in with its certificate{}", names.asker(e),
                       left_out_text(e.left_out, "logins"));
  }
};

}  // namespace

std::string to_text(const Event& event, const Settings& settings) {
  return std::visit(EventText{{settings}}, event);
}

}  // namespace mbgate::report
