// SPDX-License-Identifier: Apache-2.0
// What the machine wants done, and whether it may want that.
#include "fuzz/driver.hpp"
#include "report/text.hpp"

namespace mbgate::fuzz {

void Driver::take(const gateway::Send& action) {
  Client* const client = client_at(static_cast<std::size_t>(action.client));
  require(client != nullptr, "answers go to clients that are there");
  const auto scan = modbus::scan_mbap({action.adu.data(), action.adu.size()});
  const auto* frame = std::get_if<modbus::MbapFrame>(&scan);
  require(frame != nullptr && frame->size == action.adu.size(), "an answer is one ADU");
  const auto& [header, pdu] = frame->adu;
  const auto [begin, end] = client->due.equal_range(header.transaction);
  const auto asked = std::find_if(begin, end, [&, unit = header.unit](const auto& due) {
    return due.second.unit == unit && (due.second.function & 0x7FU) == (pdu.function() & 0x7FU);
  });
  require(asked != end, "an answer was asked for, once");
  client->due.erase(asked);
  ++client->unconfirmed;
}

void Driver::take(const gateway::Pause& action) {
  Client* const client = client_at(static_cast<std::size_t>(action.client));
  require(client != nullptr && !client->paused, "a client that is read can be paused");
  client->paused = true;
}

void Driver::take(const gateway::Resume& action) {
  Client* const client = client_at(static_cast<std::size_t>(action.client));
  require(client != nullptr && client->paused, "a client that is paused can be resumed");
  client->paused = false;
  resumed_.push_back(action.client);
}

void Driver::take(const gateway::Close& action) {
  Client* const client = client_at(static_cast<std::size_t>(action.client));
  require(client != nullptr, "a client is closed once");
  client->open = false;
}

void Driver::take(const gateway::Open& action) {
  Line& asked = line(action.bus);
  require(!asked.open && !asked.outdated, "a line is opened when it is closed");
  asked.asked = true;
}

void Driver::take(const gateway::Look& action) {
  require(line(action.bus).open, "an open line is looked at");
  harness_.handle(gateway::LineLooked{action.bus});
}

void Driver::take(const gateway::Transmit& action) {
  Line& used = line(action.bus);
  require(used.open && !used.outdated, "nothing is transmitted on a closed line");
  require(!action.frame.empty(), "a frame has bytes");
  used.heard = action.frame;
}

void Driver::take(const gateway::Shut& action) {
  Line& shut = line(action.bus);
  require(shut.open || shut.outdated, "a line is closed when it is open, or has changed");
  shut.open = shut.asked = shut.outdated = false;
}

void Driver::take(const gateway::Report& action) {
  require(!report::to_text(action.event, harness_.settings()).empty(), "an event has a text");
}

void Driver::take(const gateway::Finished& /*action*/) {
  require(stopping_ && !finished_, "a gateway that was asked to stop finishes once");
  finished_ = true;
}

}  // namespace mbgate::fuzz
