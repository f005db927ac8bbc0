// SPDX-License-Identifier: Apache-2.0
#include "gateway/input.hpp"

namespace mbgate::gateway {
namespace {

struct Door {
  Gateway& gateway;
  Instant now;

  void operator()(const ClientConnected& input) const {
    gateway.handle_client_connected(input.client, input.info, now);
  }
  void operator()(const ClientBytes& input) const {
    gateway.handle_client_bytes(input.client, input.bytes, now, input.unread);
  }
  void operator()(const ClientSent& input) const { gateway.handle_client_sent(input.client, now); }
  void operator()(const ClientHalfClosed& input) const {
    gateway.handle_client_half_closed(input.client, now);
  }
  void operator()(const ClientDisconnected& input) const {
    gateway.handle_client_disconnected(input.client, now);
  }
  void operator()(const LineOpened& input) const {
    gateway.handle_bus_opened(input.bus, now, input.kind);
  }
  void operator()(const LineBytes& input) const {
    gateway.handle_bus_bytes(input.bus, input.bytes, now);
  }
  void operator()(const LineLost& input) const {
    gateway.handle_bus_lost(input.bus, now, input.loss);
  }
  void operator()(const LineLooked& input) const { gateway.handle_bus_looked(input.bus, now); }
  void operator()(const DeadlineReached& /*input*/) const { gateway.handle_deadline(now); }
  void operator()(const ShutdownAsked& /*input*/) const { gateway.handle_shutdown(now); }
};

}  // namespace

void apply(Gateway& gateway, const Input& input, Instant now) {
  std::visit(Door{gateway, now}, input);
}

}  // namespace mbgate::gateway
