// SPDX-License-Identifier: Apache-2.0
// The beginning of a frame that nobody waits for, and whose rest an adapter hands over only after
// its pause: a late answer crosses the latency timer of an FTDI as any other does.
#pragma once

#include <boost/container/static_vector.hpp>

#include "bus/instant.hpp"
#include "bus/state_reader.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::bus {

class CutFrame {
 public:
  /// These bytes (at least one), the first of which came at `began` and the last at `last`, were
  /// given up. From where they, or what is kept already with them, may be the beginning of a frame
  /// they are kept.
  void keep(modbus::Bytes bytes, Instant began, Instant last, Duration slack);
  /// A good frame that begins with what is kept, or with a later piece of it, but for a bit of
  /// noise, if these bytes complete it, and began not later than `slack` after that; it is kept no
  /// longer. Nothing if they begin with a good frame themselves.
  struct Joined {
    modbus::RtuAdu frame;
    std::size_t taken;  ///< of these bytes
    bool is_response;   ///< else another client asks
    bool after_noise;
  };
  std::optional<Joined> complete(modbus::Bytes bytes, Instant began, Duration slack);

 private:
  friend struct mbgate::StateReader;
  void clear();

  static constexpr std::size_t kMostPieces = 16;

  boost::container::static_vector<std::uint8_t, modbus::kMaxRtuSize> kept_;
  /// Where each of what was given up begins in `kept_`: a frame may begin with any of them.
  boost::container::static_vector<std::size_t, kMostPieces> pieces_;
  Instant last_;
};

}  // namespace mbgate::bus
