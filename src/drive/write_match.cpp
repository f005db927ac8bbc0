// SPDX-License-Identifier: Apache-2.0
#include "drive/write_match.hpp"

#include "drive/register_range.hpp"

namespace mbgate::drive {

bool writes(const modbus::Request& request, const WriteMatch& match) {
  const auto& field = request.writes();
  if (!field || !contains(field->range, match.table, match.address)) {
    return false;
  }
  const auto written = request.written(match.address);
  return written && match.fits(*written);
}

}  // namespace mbgate::drive
