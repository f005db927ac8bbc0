// SPDX-License-Identifier: Apache-2.0
#include "io/lines/line.hpp"

#include "io/lines/serial_line.hpp"
#include "io/lines/tcp_line.hpp"

namespace mbgate::io {

std::unique_ptr<Line> make_line(const LineContext& context, drive::BusId bus,
                                const bus::LineSettings& line) {
  if (line.remote) {
    return std::make_unique<TcpLine>(context, bus, line);
  }
  return std::make_unique<SerialLine>(context, bus, line);
}

}  // namespace mbgate::io
