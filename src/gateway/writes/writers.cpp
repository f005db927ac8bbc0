// SPDX-License-Identifier: Apache-2.0
#include "gateway/writes/writers.hpp"

namespace mbgate::gateway {

std::optional<modbus::ExceptionCode> Writers::objection(std::size_t device,
                                                        const DeviceGuard& guard,
                                                        const routing::ClientAddress& client,
                                                        bus::Instant now) const {
  const auto& owner = owners_[device];
  switch (guard.writer) {
    case WriterRule::any: return std::nullopt;
    case WriterRule::first:
      return owner && owner->client != client && now < owner->wrote + guard.writer_hold
                 ? std::optional(modbus::ExceptionCode::server_device_busy)
                 : std::nullopt;
    case WriterRule::listed:
      return routing::contains(guard.writers, client)
                 ? std::nullopt
                 : std::optional(modbus::ExceptionCode::illegal_function);
  }
  return std::nullopt;
}

}  // namespace mbgate::gateway
