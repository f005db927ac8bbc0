// SPDX-License-Identifier: Apache-2.0
// The text forms of events and actions.
#include <string_view>

#include "gateway/action.hpp"
#include "modbus/describe.hpp"

namespace mbgate::gateway {
namespace {

template <typename... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};

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

std::string_view reason_text(RefusalReason reason) {
  switch (reason) {
    case RefusalReason::not_allowed: return "not in the allow list";
    case RefusalReason::full: return "max_connections is reached and no connection is idle";
    case RefusalReason::stopping: return "the gateway is stopping";
  }
  return "";
}

std::string client_number(ClientId client) {
  return "client " + std::to_string(static_cast<std::uint64_t>(client));
}

std::string milliseconds(Duration duration) {
  return std::to_string(std::chrono::ceil<std::chrono::milliseconds>(duration).count()) + " ms";
}

std::string notice_text(const bus::DeviceNotice& notice) {
  using Kind = bus::DeviceNotice::Kind;
  switch (notice.kind) {
    case Kind::lost: return "does not answer any more";
    case Kind::back: return "answers again";
    case Kind::late:
      return "an answer came " + milliseconds(notice.lateness) +
             " after its response timeout, which is too short; after an unanswered request it is "
             "now left alone for " +
             milliseconds(notice.quarantine);
    case Kind::early: return "answers before its response_wait, which is set too long";
    case Kind::foreign:
      return "a frame of it was heard that nobody here asked for; another client is on this line";
    case Kind::stop_unanswered: return "a stop command was not acknowledged";
  }
  return {};
}

}  // namespace

std::string to_text(const Event& event, const Settings& settings) {
  return std::visit(
      Overloaded{
          [&](const BusOpened& e) { return bus_text(settings, e.bus) + " is open"; },
          [&](const BusLost& e) {
            return bus_text(settings, e.bus) + " is lost; it is being reopened";
          },
          [&](const ClientRefused& e) {
            return client_text(settings, e) + " refused: " + std::string(reason_text(e.reason));
          },
          [&](const ClientDisplaced& e) {
            return client_text(settings, e) + " closed: idle, and its place was needed";
          },
          [&](const ClientFramingLost& e) {
            return client_text(settings, e) + " closed: MBAP length " + std::to_string(e.length) +
                   " is not 2 to 254";
          },
          [&](const ClientSpeaksRtu& e) {
            return client_text(settings, e) +
                   " sends RTU frames to the Modbus TCP port; it must be set to Modbus TCP";
          },
          [&](const ClientFrameTimedOut& e) {
            return client_text(settings, e) + " closed: a request stayed incomplete";
          },
          [&](const EchoMismatch& e) {
            return bus_text(settings, e.bus) +
                   ": the echo differs from what was sent (collision, or echo = true is wrong)";
          },
          [&](const Reconfigured& e) {
            return device_text(settings, e.bus, e.address) + ": client " + e.client.to_text() +
                   " has written its communication registers";
          },
          [&](const WriteEndedEarly& e) {
            return device_text(settings, e.bus, e.address) + ": a write of " + what_of(e.table) +
                   std::to_string(e.first) + " to " + std::to_string(e.end - 1) +
                   " ended early; written up to " + std::to_string(e.failed - 1);
          },
          [&](const WordOrderDiffers& e) {
            return device_text(settings, e.bus, e.address) +
                   ": its own word order is not the one configured; values are not written to it";
          },
          [&](const DeviceNews& e) {
            return device_text(settings, e.bus, e.notice.address) + ": " + notice_text(e.notice);
          },
          [&](const FailsafeSent& e) {
            return device_text(settings, e.bus, e.address) + ": " +
                   (e.silence ? "the clients that may write are silent"
                              : "the last client that may write has gone") +
                   "; its failsafe writes are sent";
          }},
      event);
}

std::string to_text(const Action& action, const Settings& settings) {
  return std::visit(
      Overloaded{[&](const Send& a) {
                   return client_number(a.client) + " < " +
                          modbus::describe_mbap({a.adu.data(), a.adu.size()},
                                                modbus::Direction::response);
                 },
                 [&](const Pause& a) { return client_number(a.client) + ": pause reading"; },
                 [&](const Resume& a) { return client_number(a.client) + ": resume reading"; },
                 [&](const Close& a) { return client_number(a.client) + ": close"; },
                 [&](const Open& a) { return bus_text(settings, a.bus) + ": open the line"; },
                 [&](const Transmit& a) {
                   return bus_text(settings, a.bus) + " > " +
                          modbus::describe_rtu({a.frame.data(), a.frame.size()},
                                               modbus::Direction::request);
                 },
                 [&](const Shut& a) { return bus_text(settings, a.bus) + ": close the line"; },
                 [&](const Report& a) { return to_text(a.event, settings); },
                 [&](const Finished&) { return std::string("finished"); }},
      action);
}

}  // namespace mbgate::gateway
