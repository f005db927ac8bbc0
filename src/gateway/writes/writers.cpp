// SPDX-License-Identifier: Apache-2.0
#include "gateway/writes/writers.hpp"

namespace mbgate::gateway {

std::optional<modbus::ExceptionCode> Writers::objection(std::size_t device,
                                                        const DeviceGuard& guard,
                                                        const ClientInfo& client,
                                                        const ClientKey& key,
                                                        bus::Instant now) const {
  const auto& owner = owners_[device];
  switch (guard.writer) {
    case WriterRule::any: return std::nullopt;
    case WriterRule::first:
      return owner && owner->client != key && now < owner->wrote + guard.writer_hold
                 ? std::optional(modbus::ExceptionCode::server_device_busy)
                 : std::nullopt;
    case WriterRule::listed:
      return guard.writers.contains(client.address, client.role)
                 ? std::nullopt
                 : std::optional(modbus::ExceptionCode::illegal_function);
  }
  return std::nullopt;
}

}  // namespace mbgate::gateway
